"""One remote finger's identification: mode, texture, stiffness, material, and its sensor's heater.

Joins the parts; numbers and a time in, numbers out. Texture and thermal readings come at their own rates,
None in between.
"""

from collections import deque
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from common.limits import GAP_S
from common.materials import ALIASES, Material, materials
from common.messages import ExplorationMode, ThermalStatus
from remote_site.exploration import TAP_S, Exploration
from remote_site.heater_control import OFFSETS_K, HeaterControl, next_offset_k
from remote_site.motion_estimate import MotionEstimate
from remote_site.peltier_back import PeltierBack
from remote_site.reading_clock import ReadingClock
from remote_site.roughness import Roughness
from remote_site.stiffness import Stiffness
from remote_site.surface_class import (
    GROOVE_DECAY_PER_S,
    GROOVE_RAD_S,
    SMOOTH,
    TAP_DECAY_PER_S,
    TAP_SPEED_PER_M_S,
    GroovePeriod,
    SurfaceTable,
    stroke_constants,
)
from remote_site.thermal_answer import NO_CONTACT, NO_DIFFERENCE, ThermalAnswer
from remote_site.thermal_identification import CONTACT_LOST, ThermalIdentification, ThermalKnowledge
from remote_site.thermal_touches import WARMING, reading_at_contact
from remote_site.warmed_spot import TRACES, WARM, WarmedSpot

STROKED = "stroked: the touch did not rest"
READING_AGE_S = 0.10
"""A thermal reading older than this is none, s."""
VAGUE_LN_SD = 0.7
"""An effusivity known no better than this (a factor of two) is not rendered."""
_SHOWN = (ThermalStatus.DECIDING, ThermalStatus.IDENTIFIED, ThermalStatus.AMBIGUOUS, ThermalStatus.UNKNOWN)


@dataclass(frozen=True, slots=True)
class FingerSample:
    """One tick's input; SI, C and V. `texture_v`, `sensor_c` and `ambient_c` are None where nothing new came.

    `device_us` is the thermal sensor's own time of its reading; without it the reading was taken when it came.
    """

    t_s: float
    force_n: float
    x_m: float
    y_m: float
    z_m: float
    texture_v: NDArray[np.float64] | None = None
    sensor_c: float | None = None
    ambient_c: float | None = None
    sensor_fault: str | None = None
    device_us: int | None = None
    heater_drive: float = 0.0
    """What the sensor's heater gets, as the sensor says, -1..1."""


@dataclass(frozen=True, slots=True)
class TouchEvent:
    """Something that happened once.

    `kind` is `tap` (value: approach speed, m/s), `groove` (value: amplitude, rad/s) or `material` (name).
    """

    kind: str
    value: float
    name: str = ""


@dataclass(frozen=True, slots=True)
class FingerTouch:
    """One tick's output: what the operator site renders, and the heater's drive, -1..1.

    A conductivity of 0 says that the material is unknown. Units: N, m, N/m, (rad/s)/(m/s), 1/s,
    (rad/s)/(m/s), (rad/s)/N, rad/s, 1/s, W/mK, kg/m3, J/kgK.
    """

    mode: ExplorationMode
    contact: bool
    contact_force_n: float
    surface_z_m: float
    stiffness_n_m: float
    k_tap: float
    b_tap_per_s: float
    k_stroke_v: float
    k_stroke_f: float
    groove_rad_s: float
    b_groove_per_s: float
    conductivity_w_mk: float
    density_kg_m3: float
    specific_heat_j_kgk: float
    thermal: ThermalAnswer
    heater_drive: float
    speed_m_s: float
    roughness_v: float
    events: tuple[TouchEvent, ...]


class FingerIdentification:
    """Identification of one finger; step it at 500 Hz.

    Attributes:
        finger: number of the finger, 0..4.
        preheat_k: pre-heat of the thermal sensor above ambient in use, K.
        thermal: identification by this finger alone.
        shared: what all fingers on its object say together; None where it speaks for itself.
    """

    def __init__(
        self,
        finger: int,
        knowledge: ThermalKnowledge,
        surfaces: SurfaceTable,
        preheat_k: float = OFFSETS_K[0],
    ) -> None:
        """Identify with what is known of sensors, materials and surfaces; the plate waits at ambient + `preheat_k`."""
        self.finger = finger
        self._surfaces = surfaces
        self._motion = MotionEstimate()
        self._exploration = Exploration()
        self._roughness = Roughness()
        self._period = GroovePeriod()
        self._stiffness = Stiffness()
        self._heater = HeaterControl(preheat_k)
        self._back = PeltierBack()
        self.thermal = ThermalIdentification(knowledge)
        self.shared: ThermalAnswer | None = None
        self._spot = WarmedSpot()
        self._found = NO_CONTACT
        """What the last touch came to."""
        self._waiting: tuple[float, float, float] | None = None
        """Time, reading and force that are still to be identified from."""
        self._turn = 0
        self._contact_s = 0.0
        self._clock = ReadingClock()
        self._free_c: deque[float] = deque(maxlen=WARMING)
        self._texture_s = -1.0
        self._sensor_s = -1.0
        self._ambient_c: float | None = None
        self._drive = 0.0
        self._before_s: float | None = None
        self._roughness_v = 0.0
        self._stroke = stroke_constants(surfaces, surfaces.surfaces[0].ln_roughness)
        self._shown: tuple[ThermalAnswer | None, tuple[float, float, float]] = (None, (0.0, 0.0, 0.0))
        self._told: str | None = None

    @property
    def preheat_k(self) -> float:
        """Offset of the thermal sensor's set-point above ambient, K."""
        return self._heater.offset_k

    @property
    def _answer(self) -> ThermalAnswer:
        if not self._exploration.contact:
            return NO_CONTACT
        return self.thermal.answer if self.shared is None else self.shared

    @property
    def period(self) -> GroovePeriod:
        """Distances of the grooves crossed in this contact."""
        return self._period

    def step(self, sample: FingerSample) -> FingerTouch:
        """Advance to `sample.t_s`."""
        t_s, force_n = sample.t_s, sample.force_n
        motion, exploration = self._motion, self._exploration
        motion.step(t_s, sample.x_m, sample.y_m, sample.z_m)
        speed_m_s = motion.speed_m_s
        mode = exploration.step(t_s, force_n, sample.x_m, sample.y_m, speed_m_s, approach_m_s=motion.approach_m_s)
        self._stiffness.step(force_n, sample.z_m)
        events: list[TouchEvent] = []
        if exploration.began:
            events.append(TouchEvent("tap", exploration.approach_m_s))
            self._period = GroovePeriod()
        self._follow_grooves(t_s, mode, speed_m_s)
        if sample.texture_v is not None and len(sample.texture_v):
            self._texture_s = t_s
            self._texture(sample, mode, speed_m_s, events)
        # A texture that is no longer measured is no texture: the finger feels the object, but nothing of its surface.
        stroke = self._stroke if t_s - self._texture_s <= GAP_S else SMOOTH
        self._thermal_step(sample, mode)
        answer = self._answer
        if answer.material is not None and answer.material != self._told:
            self._told = answer.material
            events.append(TouchEvent("material", answer.probability, answer.material))
        conductivity, density, specific_heat = self._render(answer)
        return FingerTouch(
            mode=mode,
            contact=exploration.contact,
            contact_force_n=force_n,
            surface_z_m=self._stiffness.surface_z_m,
            stiffness_n_m=self._stiffness.stiffness_n_m,
            k_tap=TAP_SPEED_PER_M_S,
            b_tap_per_s=TAP_DECAY_PER_S,
            k_stroke_v=stroke.k_stroke_v,
            k_stroke_f=stroke.k_stroke_f,
            groove_rad_s=GROOVE_RAD_S,
            b_groove_per_s=GROOVE_DECAY_PER_S,
            conductivity_w_mk=conductivity,
            density_kg_m3=density,
            specific_heat_j_kgk=specific_heat,
            thermal=answer,
            heater_drive=self._drive,
            speed_m_s=speed_m_s,
            roughness_v=self._roughness_v,
            events=tuple(events),
        )

    def _follow_grooves(self, t_s: float, mode: ExplorationMode, speed_m_s: float) -> None:
        """Measure the way between impulse flags."""
        if mode is not ExplorationMode.STROKING:
            self._period.interrupt()
        elif self._before_s is not None:
            self._period.move(speed_m_s * (t_s - self._before_s))
        self._before_s = t_s

    def _texture(self, sample: FingerSample, mode: ExplorationMode, speed_m_s: float, events: list[TouchEvent]) -> None:
        """Take a chunk of the texture signal."""
        assert sample.texture_v is not None
        reading = self._roughness.step(sample.t_s, sample.texture_v, mode, speed_m_s, sample.force_n)
        if reading.impulse:
            self._period.flag()
            events.append(TouchEvent("groove", GROOVE_RAD_S))
        if reading.valid and mode is ExplorationMode.STROKING:
            self._roughness_v = reading.roughness_v
            ln_roughness = self._surfaces.ln_normal(reading.roughness_v, sample.force_n, speed_m_s)
            self._stroke = stroke_constants(self._surfaces, ln_roughness)

    def _thermal_step(self, sample: FingerSample, mode: ExplorationMode) -> None:
        """Start, feed and end the thermal touch, and run the heater while free."""
        t_s, exploration, thermal = sample.t_s, self._exploration, self.thermal
        if sample.ambient_c is not None:
            self._ambient_c = sample.ambient_c
        if exploration.began:
            self._land(sample)
        elif exploration.ended and t_s - self._contact_s > TAP_S:
            thermal.stop(CONTACT_LOST)
        elif mode is ExplorationMode.STROKING:
            thermal.stop(STROKED)
        if sample.sensor_fault is not None:
            thermal.stop(f"sensor fault: {sample.sensor_fault}")
        if exploration.contact:
            self._spot.press(t_s, sample.x_m, sample.y_m, exploration.began)
        elif thermal.touching and not thermal.running:
            self._end_touch()
        self._take_turn(sample.sensor_c is not None)
        if sample.sensor_c is not None:
            self._take_reading(sample, sample.sensor_c)
        elif t_s - self._sensor_s > READING_AGE_S:
            self._drive = 0.0
            thermal.stop("sensor fault: no reading")

    def _land(self, sample: FingerSample) -> None:
        """A plate meets an object: it bounces on, is back where it has just been, or begins a touch."""
        if self.thermal.running and self._spot.near(sample.x_m, sample.y_m):
            return
        self._told = None
        self.shared = self._waiting = None
        # Where nothing differed, nothing was warmed.
        differed = self._found.reason != NO_DIFFERENCE
        left = self._spot.left(sample.t_s, sample.x_m, sample.y_m) if differed else 0.0
        if left > WARM:
            self.thermal.again(self._found)
        else:
            self._begin_touch(sample)
            self.thermal.warmed = left > TRACES

    def _begin_touch(self, sample: FingerSample) -> None:
        self._contact_s, self._drive = sample.t_s, 0.0
        fresh = bool(self._free_c) and sample.t_s - self._sensor_s <= READING_AGE_S
        start_c, slope_k_s = reading_at_contact(list(self._free_c)) if fresh else (0.0, 0.0)
        self.thermal.start(sample.t_s, start_c, slope_k_s, self._ambient_c, (self._back.above_k, self._back.sd_k))
        if not fresh or sample.sensor_fault is not None:
            self.thermal.stop(f"sensor fault: {sample.sensor_fault or 'no reading before contact'}")

    def _end_touch(self) -> None:
        """The finger is free; what it has found holds for the spot, and chooses the pre-heat."""
        self._found = self.thermal.answer if self.shared is None else self.shared
        if self._found.reason == NO_DIFFERENCE and self._ambient_c is not None:
            self._heater.offset_k = next_offset_k(self._heater.offset_k, self._ambient_c)
        self.thermal.release()
        self.shared = self._waiting = None
        self._free_c.clear()

    def _take_reading(self, sample: FingerSample, sensor_c: float) -> None:
        """Keep a reading for the touch, or as one before it, and drive the heater by it."""
        t_s, contact, touched = sample.t_s, self._exploration.contact, self.thermal.running
        if self._ambient_c is not None and sample.sensor_fault is None:
            self._back.step(t_s - self._sensor_s, sample.heater_drive, sensor_c - self._ambient_c)
        self._sensor_s = t_s
        taken_s = t_s if sample.device_us is None else self._clock.step(t_s, sample.device_us)
        if not contact:
            self._free_c.append(sensor_c)
        if touched and taken_s > self._contact_s:  # one from just before contact may arrive just after
            self._waiting = (taken_s, sensor_c, sample.force_n)
            self._turn = self.finger
        self._drive = self._heater.step(t_s, sensor_c, self._ambient_c, contact or touched, fault=sample.sensor_fault)

    def _take_turn(self, another: bool) -> None:
        """Identify from the newest reading, some ticks after it came: fingers one after the other, not all at once.

        Args:
            another: the next reading is there already.
        """
        if self._waiting is None:
            return
        if self._turn == 0 or another:
            self.thermal.step(*self._waiting)
            self._waiting = None
        self._turn -= 1

    def _render(self, answer: ThermalAnswer) -> tuple[float, float, float]:
        """Conductivity, density and specific heat to render: mean in logarithms over the likely materials."""
        if self._shown[0] is not answer:
            self._shown = (answer, _rendered(answer))
        return self._shown[1]


def _rendered(answer: ThermalAnswer) -> tuple[float, float, float]:
    """Conductivity, density and specific heat to render; zeros where nothing may be rendered.

    An identified material's own; before that the mean (in logarithms) over the likely ones, made to have the effusivity
    that the running estimate has: the finger feels something from the first moment, and no jump when a name is found.
    """
    if answer.status not in _SHOWN or answer.effusivity is None or answer.effusivity_ln_sd is None:
        return 0.0, 0.0, 0.0
    known = materials()
    if answer.material is not None:
        entry = known.get(ALIASES.get(answer.material, answer.material))
        return (0.0, 0.0, 0.0) if entry is None else _constants(entry)
    if answer.effusivity_ln_sd > VAGUE_LN_SD:
        return 0.0, 0.0, 0.0
    rows, weights = [], []
    for name, probability in answer.candidates.items():
        entry = known.get(ALIASES.get(name, name))
        if entry is not None:
            rows.append(_constants(entry))
            weights.append(max(probability, 1e-6))
    if not rows:
        return 0.0, 0.0, 0.0
    conductivity, density, heat = np.exp(np.average(np.log(np.array(rows)), axis=0, weights=weights))
    wanted = answer.effusivity / float(np.sqrt(conductivity * density * heat))
    return float(conductivity) * wanted, float(density), float(heat) * wanted


def _constants(entry: Material) -> tuple[float, float, float]:
    return entry.conductivity_w_mk, entry.density_kg_m3, entry.specific_heat_j_kgk
