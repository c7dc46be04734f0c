"""One remote finger's identification: mode, texture, surface, and the material that its thermal sensor finds.

Joins the parts; numbers and a time in, numbers out. Texture comes at its own rate, None in between.
"""

from common.exploration import Exploration
from common.hand_motion import HandMotion
from common.limits import GAP_S
from common.messages import ExplorationMode
from remote_site.finger_heat import FingerHeat
from remote_site.finger_touch import FingerSample, FingerTouch, TouchEvent
from remote_site.groove_period import GroovePeriod
from remote_site.heater_control import OFFSETS_K
from remote_site.rendered_material import rendered_constants
from remote_site.surface_class import SMOOTH, StrokeLaw, SurfaceTable
from remote_site.texture_identification import TextureIdentification
from remote_site.texture_law import ln_roughness
from remote_site.thermal_answer import ThermalAnswer
from remote_site.thermal_identification import ThermalKnowledge
from remote_site.touched_surface import TouchedSurface


class FingerIdentification:
    """Identification of one finger; step it at 500 Hz.

    Attributes:
        finger: number of the finger, 0..4.
        contact: whether it touches.
        heat: its thermal sensor.
    """

    def __init__(
        self,
        finger: int,
        knowledge: ThermalKnowledge,
        surfaces: SurfaceTable,
        hand: HandMotion,
        preheat_k: float = OFFSETS_K[0],
    ) -> None:
        """Identify with what is known of sensors, materials and surfaces.

        Args:
            finger: its number, 0..4.
            knowledge: of materials.
            surfaces: of textures.
            hand: whose finger it is; stepped before it.
            preheat_k: the plate waits at ambient + this, K.
        """
        self.finger = finger
        self.contact = False
        self._surfaces = surfaces
        self._exploration = Exploration(hand)
        self._texture = TextureIdentification(surfaces)
        self._period = GroovePeriod()
        self._surface = TouchedSurface()
        self.heat = FingerHeat(knowledge, preheat_k)
        self._texture_s = -1.0
        self._roughness_v = 0.0
        self._rough = False
        """The roughness is of what is being touched."""
        self._texture_fault: str | None = None
        self._strokes = StrokeLaw(surfaces)
        self._stroke = self._strokes.at(surfaces.surfaces[0].ln_roughness)
        self._shown: tuple[ThermalAnswer | None, tuple[float, float, float]] = (None, (0.0, 0.0, 0.0))

    @property
    def period(self) -> GroovePeriod:
        """Distances of the grooves crossed in this contact."""
        return self._period

    @property
    def roughness_v(self) -> tuple[float, float] | None:
        """Roughness of what is being touched and its standard deviation, V; None before it was stroked far enough."""
        return (self._roughness_v, self._texture.roughness_sd_v) if self._rough else None

    def step(self, sample: FingerSample) -> FingerTouch:
        """Advance to `sample.t_s`."""
        t_s, force_n = sample.t_s, sample.force_n
        exploration, surface = self._exploration, self._surface
        mode = exploration.step(t_s, force_n, sample.z_m)
        contact, speed_m_s = exploration.contact, exploration.speed_m_s
        surface.step(t_s, force_n, sample.x_m, sample.y_m, sample.z_m)
        events: list[TouchEvent] = []
        if exploration.began:
            events.append(TouchEvent("tap", exploration.approach_m_s))
            self._period = GroovePeriod()
            self._rough = False
        self.contact = contact
        if mode is not ExplorationMode.STROKING:
            self._period.interrupt()
        if sample.texture_v:
            self._texture_s = t_s
            events += self._feel(sample, sample.texture_v, mode, speed_m_s)
        # A texture that is no longer measured is no texture: the finger feels the object, but nothing of its surface.
        measured = t_s - self._texture_s <= GAP_S and self._texture_fault is None
        stroke = self._stroke if measured else SMOOTH
        if (named := self.heat.step(sample, exploration)) is not None:
            events.append(named)
        answer = self.heat.answer
        conductivity, density, specific_heat = self._render(answer)
        return FingerTouch(
            mode=mode,
            contact=contact,
            contact_force_n=force_n,
            surface_z_m=surface.surface_z_m,
            stiffness_n_m=surface.stiffness_n_m,
            stiffness_ln_sd=surface.stiffness_ln_sd,
            damping_n_s_m=surface.damping_n_s_m,
            slope_x=surface.slope_x,
            slope_y=surface.slope_y,
            k_stroke_v=stroke.k_stroke_v,
            k_stroke_f=stroke.k_stroke_f,
            conductivity_w_mk=conductivity,
            density_kg_m3=density,
            specific_heat_j_kgk=specific_heat,
            thermal=answer,
            heater_drive=self.heat.drive,
            speed_m_s=speed_m_s,
            roughness_v=self._roughness_v,
            events=tuple(events),
            texture_fault=self._texture_fault,
        )

    def _feel(
        self, sample: FingerSample, texture_v: list[float], mode: ExplorationMode, speed_m_s: float
    ) -> list[TouchEvent]:
        """Take a chunk of the texture signal; return the grooves found in it."""
        texture = self._texture
        impulses, _ = texture.take(sample.t_s, texture_v, sample.force_n, speed_m_s, mode)
        self._texture_fault = texture.fault
        for impulse in impulses:
            self._period.groove(impulse.place_m)
        strokes = mode is ExplorationMode.STROKING
        if strokes or texture.fault is not None:
            self._rough = texture.valid
        if strokes and texture.valid:
            self._roughness_v = texture.roughness_v
            self._stroke = self._strokes.at(ln_roughness(self._roughness_v))
        return [
            TouchEvent("groove", self._surfaces.groove_rad_s(impulse.strength_v), time_s=impulse.time_s)
            for impulse in impulses
        ]

    def _render(self, answer: ThermalAnswer) -> tuple[float, float, float]:
        """Conductivity, density and specific heat to render: mean in logarithms over the likely materials."""
        if self._shown[0] is not answer:
            self._shown = (answer, rendered_constants(answer))
        return self._shown[1]
