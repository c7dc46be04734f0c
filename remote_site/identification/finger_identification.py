"""Identification by one remote finger: exploration mode, texture, surface and, by its thermal sensor, material.

This module joins the estimators. Its input is a tick's readings, its output the finger's row of the touch packet.
"""

from common.exploration.exploration_mode import ModeDetector
from common.exploration.hand_motion import HandMotion
from common.limits import GAP_S
from common.wire.messages import (
    NO_TOUCH,
    OBJECT_UNKNOWN_SD_K,
    TOUCH_RANGES,
    EventKind,
    ExplorationMode,
    ThermalReason,
    TouchRow,
    explains,
)
from remote_site.devices.sensor_frame import SensorFrame
from remote_site.devices.texture_sensor import texture_v
from remote_site.identification.touch_events import TouchEvents
from remote_site.stiffness.surface_estimate import UNKNOWN_LN_SD, SurfaceEstimate
from remote_site.texture.groove_period import GroovePeriod
from remote_site.texture.surface_table import (
    GROOVE_DECAY_PER_S,
    GROOVE_RAD_S,
    SMOOTH,
    TAP_DECAY_PER_S,
    TAP_SPEED_PER_M_S,
    StrokeConstants,
    StrokeLaw,
    SurfaceTable,
)
from remote_site.texture.texture_identification import TextureIdentification, groove_rad_s
from remote_site.texture.texture_law import ln_roughness
from remote_site.texture.tip_path import RATE_HZ
from remote_site.thermal.finger_thermal import FingerThermal
from remote_site.thermal.thermal_identification import ThermalKnowledge

_EFFUSIVITY_UNKNOWN_LN_SD = TOUCH_RANGES["effusivity_ln_sd"][1]
"""Standard deviation of ln effusivity that stands for an unknown effusivity."""
_GAPS = 16
"""Number of the latest gaps between grooves that give the period: it soon follows another grating."""


class FingerIdentification:
    """Identification by one finger; step it in every tick.

    Attributes:
        row: the finger's row of the touch packet.
        contact: whether the finger touches an object.
        thermal: identification of material and temperature.
        surface: identification of stiffness and height.
        period: distances of the grooves crossed in this contact.
        roughness_v: last measured roughness, V.
        texture_fault: fault of the texture sensor; None without a fault.
    """

    def __init__(
        self,
        finger: int,
        knowledge: ThermalKnowledge,
        surfaces: SurfaceTable,
        hand: HandMotion,
        events: TouchEvents,
    ) -> None:
        """Identify with calibrated sensors, materials and surfaces; step `hand` and `events` before the finger."""
        self._finger = finger
        self.row = NO_TOUCH
        self.contact = False
        self.thermal = FingerThermal(finger, knowledge)
        self.surface = SurfaceEstimate()
        self.period = GroovePeriod(_GAPS)
        self.roughness_v = 0.0
        self.texture_fault: str | None = None
        self._groove_v = surfaces.groove_v
        self._hand = hand
        self._events = events
        self._exploration = ModeDetector(hand)
        self._texture = TextureIdentification(surfaces)
        self._texture_s = -1.0
        self._rough = False
        """Whether the roughness is that of the surface being touched."""
        self._strokes = StrokeLaw(surfaces)
        self._stroke = self._strokes.at(surfaces.surfaces[0].ln_roughness)

    @property
    def mode(self) -> ExplorationMode:
        """The finger's exploration mode."""
        return self._exploration.mode

    @property
    def roughness(self) -> tuple[float, float] | None:
        """Roughness of the touched surface and its standard deviation, V; None before a sufficiently long stroke."""
        return (self.roughness_v, self._texture.roughness_sd_v) if self._rough else None

    def step(self, sensed: SensorFrame) -> None:
        """Advance to `sensed.time_s`."""
        finger, exploration = self._finger, self._exploration
        t_s, force_n, z_m = sensed.time_s, sensed.force_n[finger], sensed.z_m[finger]
        stroked = exploration.mode is ExplorationMode.STROKING
        mode = exploration.step(t_s, force_n, z_m)
        self.contact = exploration.contact
        offset_n = exploration.offset_n
        self.surface.step(t_s, force_n, sensed.x_m, sensed.y_m, z_m, offset_n)
        if exploration.began:
            self._events.add(EventKind.TAP, finger, exploration.approach_m_s)
            self.period = GroovePeriod(_GAPS)
            self._rough = False
        if stroked and mode is not ExplorationMode.STROKING:
            self.period.interrupt()
        if counts := sensed.texture_counts[finger]:
            self._take_texture(t_s, counts, force_n - offset_n, mode)
        named = self.thermal.step(sensed, exploration)
        if named is not None:
            self._events.add(EventKind.MATERIAL, finger, self.thermal.answer.probability, named)
        # Without fresh texture samples the surface is rendered as smooth, and nothing is known of it.
        measured = t_s - self._texture_s <= GAP_S and self.texture_fault is None
        if not measured:
            self.period = GroovePeriod(_GAPS)
            self._rough = False
        self.row = self._touch(sensed, self._stroke if measured else SMOOTH)

    def _take_texture(self, t_s: float, counts: bytes, force_n: float, mode: ExplorationMode) -> None:
        """Take one chunk of the texture signal."""
        texture = self._texture
        self._texture_s = t_s
        impulses = texture.take(t_s, texture_v(counts), force_n, self._hand.speed_m_s, mode)
        self.texture_fault = texture.fault
        if mode is not ExplorationMode.STROKING:
            return
        self._rough = texture.valid
        if self._rough:
            self.roughness_v = texture.roughness_v
            self._stroke = self._strokes.at(ln_roughness(self.roughness_v))
        self.period.stroke(self._hand.speed_m_s * (len(counts) // 2) / RATE_HZ)
        for impulse in impulses:
            amplitude_rad_s = groove_rad_s(impulse.strength_v, self._groove_v)
            at_m = self._events.add(EventKind.GROOVE, self._finger, amplitude_rad_s, time_s=impulse.time_s)
            self.period.groove(impulse.place_m, at_m)
        if texture.interrupted:
            self.period.interrupt()

    def _touch(self, sensed: SensorFrame, stroke: StrokeConstants) -> TouchRow:
        """Return the finger's row; a free finger has no surface, so that none is rendered."""
        contact, surface, answer = self.contact, self.surface, self.thermal.answer
        conductivity, density, specific_heat = answer.constants
        ln_sd = answer.effusivity_ln_sd if conductivity > 0.0 else None
        return TouchRow(
            mode=self._exploration.mode,
            contact=contact,
            contact_force_n=sensed.force_n[self._finger],
            x_m=sensed.x_m,
            y_m=sensed.y_m,
            surface_z_m=surface.surface_z_m,
            stiffness_n_m=surface.stiffness_n_m if contact else 0.0,
            stiffness_ln_sd=surface.stiffness_ln_sd if contact else UNKNOWN_LN_SD,
            damping_n_s_m=surface.damping_n_s_m if contact else 0.0,
            slope_x=surface.slope_x if contact else 0.0,
            slope_y=surface.slope_y if contact else 0.0,
            k_tap=TAP_SPEED_PER_M_S,
            b_tap_per_s=TAP_DECAY_PER_S,
            k_stroke_v=stroke.k_stroke_v,
            k_stroke_f=stroke.k_stroke_f,
            groove_rad_s=GROOVE_RAD_S,
            b_groove_per_s=GROOVE_DECAY_PER_S,
            conductivity_w_mk=conductivity,
            density_kg_m3=density,
            specific_heat_j_kgk=specific_heat,
            effusivity_ln_sd=_EFFUSIVITY_UNKNOWN_LN_SD if ln_sd is None else ln_sd,
            object_c=0.0 if answer.object_c is None else answer.object_c,
            object_c_sd=OBJECT_UNKNOWN_SD_K if answer.object_c is None else answer.object_c_sd or 0.0,
            probability=answer.probability,
            thermal_status=answer.status,
            thermal_reason=answer.reason if explains(answer.reason, answer.status) else ThermalReason.NONE,
        )
