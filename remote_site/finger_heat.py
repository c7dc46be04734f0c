"""One remote finger's thermal sensor: its heater while it is free, its touches, and where it has been.

Thermal readings come at their own rate, None in between.
"""

from collections import deque

from common.contact import TAP_S
from common.exploration import Exploration
from common.messages import ExplorationMode
from remote_site.finger_touch import FingerSample, TouchEvent
from remote_site.heater_control import OFFSETS_K, HeaterControl, next_offset_k
from remote_site.peltier_back import PeltierBack
from remote_site.reading_clock import ReadingClock
from remote_site.thermal_answer import NO_CONTACT, NO_DIFFERENCE, ThermalAnswer
from remote_site.thermal_identification import CONTACT_LOST, ThermalIdentification, ThermalKnowledge
from remote_site.thermal_touches import WARMING, reading_at_contact
from remote_site.warmed_spot import TRACES, WARM, WarmedSpot

STROKED = "stroked: the touch did not rest"
READING_AGE_S = 0.10
"""A thermal reading older than this is none, s."""


class FingerHeat:
    """Thermal touches of one finger; step it in every tick.

    Attributes:
        thermal: identification by this finger alone. The caller does its slow work, with `thermal.work()`.
        shared: what all fingers on its object say together; None where it speaks for itself.
        answer: what is known now.
        drive: of the heater, -1..1.
    """

    def __init__(self, knowledge: ThermalKnowledge, preheat_k: float = OFFSETS_K[0]) -> None:
        """A free finger, whose plate waits at ambient + `preheat_k`."""
        self._heater = HeaterControl(preheat_k)
        self._back = PeltierBack()
        self._spot = WarmedSpot()
        self._clock = ReadingClock()
        self.thermal = ThermalIdentification(knowledge)
        self.shared: ThermalAnswer | None = None
        self.answer = NO_CONTACT
        self.drive = 0.0
        self._found = NO_CONTACT
        """What the last touch came to."""
        self._told: str | None = None
        self._contact_s = 0.0
        self._free_c: deque[float] = deque(maxlen=WARMING)
        self._sensor_s = -1.0
        self._ambient_c: float | None = None

    @property
    def preheat_k(self) -> float:
        """Offset of the sensor's set-point above ambient, K."""
        return self._heater.offset_k

    def step(self, sample: FingerSample, exploration: Exploration) -> TouchEvent | None:
        """Advance to `sample.t_s`; tells a material when it is named first in a touch.

        Args:
            sample: this tick's input.
            exploration: what the finger is doing, stepped already.
        """
        self._follow(sample, exploration)
        self.answer = NO_CONTACT
        if exploration.contact:
            self.answer = self.thermal.answer if self.shared is None else self.shared
        material = self.answer.material
        if material is None or material == self._told:
            return None
        self._told = material
        return TouchEvent("material", self.answer.probability, material)

    def _follow(self, sample: FingerSample, exploration: Exploration) -> None:
        """Start, feed and end the thermal touch, and run the heater while free."""
        t_s, thermal = sample.t_s, self.thermal
        if sample.ambient_c is not None:
            self._ambient_c = sample.ambient_c
        if exploration.began:
            self._land(sample)
        elif exploration.ended and t_s - self._contact_s > TAP_S:
            thermal.stop(CONTACT_LOST)
        elif exploration.mode is ExplorationMode.STROKING:
            thermal.stop(STROKED)
        if sample.sensor_fault is not None:
            thermal.stop(f"sensor fault: {sample.sensor_fault}")
        if exploration.contact:
            self._spot.press(t_s, sample.x_m, sample.y_m, exploration.began)
        elif thermal.touching and not thermal.running:
            self._end_touch()
        if sample.sensor_c is not None:
            self._take_reading(sample, sample.sensor_c, exploration.contact)
        elif t_s - self._sensor_s > READING_AGE_S:
            self.drive = 0.0
            thermal.stop("sensor fault: no reading")

    def _land(self, sample: FingerSample) -> None:
        """A plate meets an object: it bounces on, is back where it has just been, or begins a touch."""
        if self.thermal.running and self._spot.near(sample.x_m, sample.y_m):
            return
        self._told = None
        self.shared = None
        # Where nothing differed, nothing was warmed.
        differed = self._found.reason != NO_DIFFERENCE
        left = self._spot.left(sample.t_s, sample.x_m, sample.y_m) if differed else 0.0
        if left > WARM:
            self.thermal.again(self._found)
        else:
            self._begin_touch(sample)
            self.thermal.warmed = left > TRACES

    def _begin_touch(self, sample: FingerSample) -> None:
        self._contact_s, self.drive = sample.t_s, 0.0
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
        self.shared = None
        self._free_c.clear()

    def _take_reading(self, sample: FingerSample, sensor_c: float, contact: bool) -> None:
        """Keep a reading for the touch, or as one before it, and drive the heater by it."""
        t_s, touched = sample.t_s, self.thermal.running
        if self._ambient_c is not None and sample.sensor_fault is None:
            self._back.step(t_s - self._sensor_s, sample.heater_drive, sensor_c - self._ambient_c)
        self._sensor_s = t_s
        taken_s = t_s if sample.device_us is None else self._clock.step(t_s, sample.device_us)
        if not contact:
            self._free_c.append(sensor_c)
        if touched and taken_s > self._contact_s:  # one from just before contact may arrive just after
            self.thermal.take(taken_s, sensor_c, sample.force_n)
        self.drive = self._heater.step(t_s, sensor_c, self._ambient_c, contact or touched, fault=sample.sensor_fault)
