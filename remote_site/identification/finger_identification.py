"""Identification by one remote finger: exploration mode, texture, surface and, by its thermal sensor, material.

This module joins the estimators. Its input is a time with measurements, its output is numbers. Texture samples come
at their own rate, with None in between.
"""

from common.exploration.exploration_mode import ModeDetector
from common.exploration.hand_motion import HandMotion
from common.limits import GAP_S
from common.wire.messages import ExplorationMode
from remote_site.finger_sample import FingerSample
from remote_site.identification.finger_touch import FingerTouch, TouchEvent
from remote_site.stiffness.surface_estimate import SurfaceEstimate
from remote_site.texture.groove_detector import Impulse
from remote_site.texture.groove_period import GroovePeriod
from remote_site.texture.surface_table import SMOOTH, StrokeLaw, SurfaceTable
from remote_site.texture.texture_identification import TextureIdentification
from remote_site.texture.texture_law import ln_roughness
from remote_site.thermal.finger_thermal import FingerThermal
from remote_site.thermal.rendered_material import rendered_constants
from remote_site.thermal.thermal_identification import ThermalIdentification, ThermalKnowledge
from remote_site.thermal.thermal_result import ThermalResult


class FingerIdentification:
    """Identification by one finger; step it in every tick.

    Attributes:
        finger: number of the finger, 0..4.
        contact: whether the finger touches an object.
    """

    def __init__(
        self,
        finger: int,
        knowledge: ThermalKnowledge,
        surfaces: SurfaceTable,
        hand: HandMotion,
    ) -> None:
        """Identify with the calibrated tables of sensors, materials and surfaces.

        Args:
            finger: number of the finger, 0..4.
            knowledge: calibrated materials.
            surfaces: calibrated textures.
            hand: motion of the hand that has this finger; step it before the finger.
        """
        self.finger = finger
        self.contact = False
        self._surfaces = surfaces
        self._hand = hand
        self._exploration = ModeDetector(hand)
        self._texture = TextureIdentification(surfaces)
        self._period = GroovePeriod()
        self._surface = SurfaceEstimate()
        self._heat = FingerThermal(knowledge)
        self._texture_s = -1.0
        self._roughness_v = 0.0
        self._rough = False
        """Whether the roughness is that of the surface being touched."""
        self._texture_fault: str | None = None
        self._strokes = StrokeLaw(surfaces)
        self._stroke = self._strokes.at(surfaces.surfaces[0].ln_roughness)
        self._shown: ThermalResult | None = None
        self._constants = (0.0, 0.0, 0.0)
        """Conductivity, W/mK, density, kg/m3, and specific heat, J/kgK, to render: those of the last answer."""

    @property
    def thermal(self) -> ThermalIdentification:
        """Identification by this finger's thermal sensor alone. The caller runs its slow work with `work()`."""
        return self._heat.thermal

    @property
    def answer(self) -> ThermalResult:
        """Estimate of the object's material and temperature."""
        return self._heat.answer

    def share(self, answer: ThermalResult | None) -> None:
        """Take the joint answer of all fingers on its object, for the next step; None if it answers for itself."""
        self._heat.share(answer)

    @property
    def period(self) -> GroovePeriod:
        """Distances of the grooves crossed in this contact."""
        return self._period

    @property
    def roughness_v(self) -> tuple[float, float] | None:
        """Roughness of the touched surface and its standard deviation, V; None before a sufficiently long stroke."""
        return (self._roughness_v, self._texture.roughness_sd_v) if self._rough else None

    def step(self, sample: FingerSample) -> FingerTouch:
        """Advance to `sample.t_s`."""
        t_s, force_n = sample.t_s, sample.force_n
        exploration, surface, speed_m_s = self._exploration, self._surface, self._hand.speed_m_s
        stroked = exploration.mode is ExplorationMode.STROKING
        mode = exploration.step(t_s, force_n, sample.z_m)
        contact = self.contact = exploration.contact
        surface.step(t_s, force_n, sample.x_m, sample.y_m, sample.z_m)
        events: list[TouchEvent] = []
        if exploration.began:
            events.append(TouchEvent("tap", exploration.approach_m_s))
            self._period = GroovePeriod()
            self._rough = False
        if stroked and mode is not ExplorationMode.STROKING:
            self._period.interrupt()
        if sample.texture_v:
            self._texture_s = t_s
            impulses = self._texture.take(t_s, sample.texture_v, force_n, speed_m_s, mode)
            self._texture_fault = self._texture.fault
            if mode is ExplorationMode.STROKING or self._texture_fault is not None:
                events += self._take_texture(impulses, mode)
        # Without fresh texture samples the surface is rendered as smooth.
        measured = t_s - self._texture_s <= GAP_S and self._texture_fault is None
        stroke = self._stroke if measured else SMOOTH
        named = self._heat.step(sample, exploration)
        answer = self._heat.answer
        if named is not None:
            events.append(TouchEvent("material", answer.probability, named))
        if answer is not self._shown:
            self._shown, self._constants = answer, rendered_constants(answer)
        conductivity, density, specific_heat = self._constants
        return FingerTouch(
            mode,
            contact,
            force_n,
            surface.surface_z_m,
            surface.stiffness_n_m,
            surface.stiffness_ln_sd,
            surface.damping_n_s_m,
            surface.slope_x,
            surface.slope_y,
            stroke.k_stroke_v,
            stroke.k_stroke_f,
            conductivity,
            density,
            specific_heat,
            answer,
            self._heat.measuring,
            self._heat.no_differences,
            speed_m_s,
            self._roughness_v,
            tuple(events),
            self._texture_fault,
        )

    def _take_texture(self, impulses: list[Impulse], mode: ExplorationMode) -> list[TouchEvent]:
        """Take the result of one chunk of the texture signal; return its grooves."""
        texture = self._texture
        self._rough = texture.valid
        if self._rough and mode is ExplorationMode.STROKING:
            self._roughness_v = texture.roughness_v
            self._stroke = self._strokes.at(ln_roughness(self._roughness_v))
        for impulse in impulses:
            self._period.groove(impulse.place_m)
        return [
            TouchEvent("groove", self._surfaces.groove_rad_s(impulse.strength_v), time_s=impulse.time_s)
            for impulse in impulses
        ]
