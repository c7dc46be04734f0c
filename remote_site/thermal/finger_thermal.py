"""One remote finger's thermal touches, from the readings of its sensor and where it has been.

Thermal readings come at their own rate, None in between.
"""

from collections import deque

from common.exploration.contact_detector import TAP_S
from common.exploration.exploration_mode import ModeDetector
from common.wire.messages import ExplorationMode, ThermalReason
from remote_site.devices.sensor_clock import SensorClock
from remote_site.finger_sample import FingerSample
from remote_site.thermal.peltier_backside import PeltierBackside
from remote_site.thermal.thermal_identification import ThermalIdentification, ThermalKnowledge
from remote_site.thermal.thermal_result import NO_CONTACT, ThermalResult
from remote_site.thermal.touch_start import WARMING, reading_at_contact
from remote_site.thermal.warmed_spot import TRACES, WARM, WarmedSpot

READING_AGE_S = 0.10
"""A thermal reading older than this is none, s."""


class FingerThermal:
    """Thermal touches of one finger; step it in every tick.

    Attributes:
        thermal: identification by this finger alone. The caller does its slow work, with `thermal.work()`.
        answer: what is known now.
        measuring: whether a touch that began, or the last reading, uses the plate: it must not be heated.
        no_differences: touches so far that ended because plate and object were equally warm.
    """

    def __init__(self, knowledge: ThermalKnowledge) -> None:
        """A free finger."""
        self._back = PeltierBackside()
        self._spot = WarmedSpot()
        self._clock = SensorClock()
        self.thermal = ThermalIdentification(knowledge)
        self.answer = NO_CONTACT
        self.measuring = False
        self.no_differences = 0
        self._shared: ThermalResult | None = None
        """Answer of all fingers on its object; None where it speaks for itself."""
        self._found = NO_CONTACT
        """What the last touch came to."""
        self._told: str | None = None
        self._contact_s = 0.0
        self._free_c: deque[float] = deque(maxlen=WARMING)
        self._sensor_s = -1.0
        self._ambient_c: float | None = None

    def share(self, answer: ThermalResult | None) -> None:
        """Take the joint answer of all fingers on its object, for the next step; None: it speaks for itself."""
        self._shared = answer
        self.thermal.alone = answer is None

    def step(self, sample: FingerSample, exploration: ModeDetector) -> str | None:
        """Advance to `sample.t_s`; returns a material when it is named first in a touch.

        Args:
            sample: this tick's input.
            exploration: what the finger is doing, stepped already.
        """
        self._follow(sample, exploration)
        self.answer = NO_CONTACT
        if exploration.contact:
            self.answer = self._joint
        material = self.answer.material
        if material is None or material == self._told:
            return None
        self._told = material
        return material

    @property
    def _joint(self) -> ThermalResult:
        """The shared answer where there is one, else this finger's own."""
        return self.thermal.answer if self._shared is None else self._shared

    def _follow(self, sample: FingerSample, exploration: ModeDetector) -> None:
        """Start, feed and end the thermal touch."""
        t_s, thermal = sample.t_s, self.thermal
        if sample.ambient_c is not None:
            self._ambient_c = sample.ambient_c
        if exploration.began:
            self._land(sample)
        elif exploration.ended and t_s - self._contact_s > TAP_S:
            thermal.stop(ThermalReason.CONTACT_LOST)
        elif exploration.mode is ExplorationMode.STROKING:
            thermal.stop(ThermalReason.STROKED)
        if sample.sensor_fault:
            thermal.stop(sample.sensor_fault)
        if exploration.contact:
            self._spot.press(t_s, sample.x_m, sample.y_m, exploration.began)
        elif thermal.touching and not thermal.running:
            self._end_touch()
        if sample.sensor_c is not None:
            self._take_reading(sample, sample.sensor_c, exploration.contact)
        elif t_s - self._sensor_s > READING_AGE_S:
            thermal.stop(ThermalReason.NO_READING)

    def _land(self, sample: FingerSample) -> None:
        """A plate meets an object: it bounces on, is back where it has just been, or begins a touch."""
        if self.thermal.running and self._spot.near(sample.x_m, sample.y_m):
            return
        self._told = None
        self._shared = None
        # Where nothing differed, nothing was warmed.
        differed = self._found.reason is not ThermalReason.NO_DIFFERENCE
        left = self._spot.left(sample.t_s, sample.x_m, sample.y_m) if differed else 0.0
        if left > WARM:
            self.thermal.again(self._found)
        else:
            self._begin_touch(sample)
            self.thermal.warmed = left > TRACES

    def _begin_touch(self, sample: FingerSample) -> None:
        self._contact_s, self.measuring = sample.t_s, True
        fresh = bool(self._free_c) and sample.t_s - self._sensor_s <= READING_AGE_S
        start_c, slope_k_s = reading_at_contact(list(self._free_c)) if fresh else (0.0, 0.0)
        self.thermal.start(sample.t_s, start_c, slope_k_s, self._ambient_c, (self._back.above_k, self._back.sd_k))
        if not fresh or sample.sensor_fault:
            self.thermal.stop(sample.sensor_fault or ThermalReason.NO_READING)

    def _end_touch(self) -> None:
        """The finger is free; what it has found holds for the spot."""
        self._found = self._joint
        self.no_differences += self._found.reason is ThermalReason.NO_DIFFERENCE
        self.thermal.release()
        self._shared = None
        self._free_c.clear()

    def _take_reading(self, sample: FingerSample, sensor_c: float, contact: bool) -> None:
        """Keep a reading for the touch, or as one before it."""
        t_s = sample.t_s
        if self._ambient_c is not None and not sample.sensor_fault:
            self._back.step(t_s - self._sensor_s, sample.heater_drive, sensor_c - self._ambient_c)
        self._sensor_s = t_s
        taken_s = t_s if sample.device_us is None else self._clock.step(t_s, sample.device_us)
        if not contact:
            self._free_c.append(sensor_c)
        self.measuring = contact or self.thermal.running
        if self.thermal.running and taken_s > self._contact_s:  # one from just before contact may arrive just after
            self.thermal.take(taken_s, sensor_c, sample.force_n)
