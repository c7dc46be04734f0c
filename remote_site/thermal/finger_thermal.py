"""One remote finger's thermal touches, from the readings of its sensor and its places.

Thermal readings come at their own rate, None in between. The sensor's own clock dates them, because their transport
delay varies.
"""

from collections import deque

from common.buses.serial_messages import DRIVE_FULL
from common.exploration.contact_detector import TAP_S
from common.exploration.exploration_mode import ModeDetector
from common.limits import SENSOR_PLATE_C
from common.wire.messages import ExplorationMode, ThermalReason
from remote_site.devices.sensor_frame import PlateReading, SensorFrame
from remote_site.thermal.peltier_backside import PeltierBackside
from remote_site.thermal.thermal_identification import ThermalIdentification, ThermalKnowledge
from remote_site.thermal.thermal_result import NO_CONTACT, ThermalResult
from remote_site.thermal.touch_start import READING_S, WARMING, reading_at_contact
from remote_site.thermal.warmed_spot import TRACES, WARM, WarmedSpot

READING_AGE_S = 0.10
"""Maximum age of a thermal reading, s."""
FOLLOWS = 0.05
"""Fraction of each reading's change of delay that corrects the estimated delay."""
MOST_LATE_S = 0.005
"""Limit of the change of delay that one reading contributes, s; a busy machine holds readings up for longer."""
STEP_S = 0.001
"""Minimum error of the applied delay before it is corrected, s; in between, readings keep the sensor's intervals."""
LOST_S = 1.0
"""Maximum change of delay, s; a larger one means that the sensor's clock has restarted."""
_WRAPS = 1 << 32


class FingerThermal:
    """Thermal touches of one finger; step it in every tick.

    Attributes:
        own: identification by this finger alone. The caller runs its slow work with `own.work()`.
        answer: present estimate of the object's material and temperature.
        measuring: whether a touch that began, or the last reading, uses the plate; the plate must not be heated then.
        no_differences: number of touches that ended because plate and object had equal temperatures.
    """

    def __init__(self, finger: int, knowledge: ThermalKnowledge) -> None:
        """Begin with a free finger, 0..4."""
        self._finger = finger
        self._back = PeltierBackside()
        self._spot = WarmedSpot()
        self._clock = SensorClock()
        self.own = ThermalIdentification(knowledge)
        self.answer = NO_CONTACT
        self.measuring = False
        self.no_differences = 0
        self._shared: ThermalResult | None = None
        """Joint answer of all fingers on its object; None if the finger answers for itself."""
        self._found = NO_CONTACT
        """Result of the last touch."""
        self._named: str | None = None
        """Last material that was named in this touch."""
        self._contact_s = 0.0
        self._free: deque[tuple[float, float]] = deque(maxlen=WARMING)
        """Times, s, and temperatures, C, of the newest readings of the free sensor."""
        self._sensor_s = -1.0
        self._ambient_c: float | None = None
        self._fault = ThermalReason.NONE
        """Why the last reading is implausible."""

    def share(self, answer: ThermalResult | None) -> None:
        """Take the joint answer of all fingers on its object, for the next step; None if it answers for itself."""
        self._shared = answer
        self.own.alone = answer is None

    def step(self, sensed: SensorFrame, exploration: ModeDetector) -> str | None:
        """Advance to `sensed.time_s`; return a material when first named in a touch. Step `exploration` before."""
        self._follow(sensed, exploration)
        self.answer = self._joint if exploration.contact else NO_CONTACT
        material = self.answer.material
        if material is None or material == self._named:
            return None
        self._named = material
        return material

    @property
    def _joint(self) -> ThermalResult:
        """The joint answer if there is one, else this finger's own."""
        return self.own.answer if self._shared is None else self._shared

    def _follow(self, sensed: SensorFrame, exploration: ModeDetector) -> None:
        """Start, feed and end the thermal touch."""
        t_s, own, reading = sensed.time_s, self.own, sensed.plates[self._finger]
        if reading is not None:
            self._ambient_c, self._fault = reading.ambient_c, reason_of(reading)
        elif t_s - self._sensor_s > READING_AGE_S:
            self._fault = ThermalReason.NONE
        fault = self._fault
        if exploration.began:
            self._land(sensed, fault)
        elif exploration.ended and t_s - self._contact_s > TAP_S:
            own.stop(ThermalReason.CONTACT_LOST)
        elif exploration.mode is ExplorationMode.STROKING:
            own.stop(ThermalReason.STROKED)
        if fault:
            own.stop(fault)
        if exploration.contact:
            self._spot.press(t_s, sensed.x_m, sensed.y_m, exploration.began)
        elif own.touching and not own.running:
            self._end_touch()
        if reading is not None:
            self._take_reading(t_s, reading, sensed.force_n[self._finger], exploration.contact, not fault)
        elif t_s - self._sensor_s > READING_AGE_S:
            own.stop(ThermalReason.NO_READING)

    def _land(self, sensed: SensorFrame, fault: ThermalReason) -> None:
        """Continue a touch after a bounce, hold the answer of a warm spot, or begin a touch."""
        t_s, x_m, y_m = sensed.time_s, sensed.x_m, sensed.y_m
        if self.own.running and self._spot.near(x_m, y_m):
            return
        self._named = None
        self._shared = None
        # A touch without a temperature difference has not warmed its spot.
        differed = self._found.reason is not ThermalReason.NO_DIFFERENCE
        left = self._spot.left(t_s, x_m, y_m) if differed else 0.0
        if left > WARM:
            self.own.again(self._found)
        else:
            self._begin_touch(t_s, fault)
            self.own.warmed = left > TRACES

    def _begin_touch(self, t_s: float, fault: ThermalReason) -> None:
        self._contact_s, self.measuring = t_s, True
        fresh = bool(self._free) and t_s - self._sensor_s <= READING_AGE_S
        # The sensor reads every READING_S, and some readings are overtaken; rounding removes the jitter of the dates.
        before_s = [READING_S * round((taken_s - self._free[-1][0]) / READING_S) for taken_s, _ in self._free]
        before_c = [sensor_c for _, sensor_c in self._free]
        start_c, slope_k_s = reading_at_contact(before_s, before_c) if fresh else (0.0, 0.0)
        self.own.start(t_s, start_c, slope_k_s, self._ambient_c, (self._back.above_k, self._back.sd_k))
        if not fresh or fault:
            self.own.stop(fault or ThermalReason.NO_READING)

    def _end_touch(self) -> None:
        """Free the finger; its result holds for the spot."""
        self._found = self._joint
        self.no_differences += self._found.reason is ThermalReason.NO_DIFFERENCE
        self.own.release()
        self._shared = None
        self._free.clear()

    def _take_reading(self, t_s: float, reading: PlateReading, force_n: float, contact: bool, plausible: bool) -> None:
        """Keep a reading for the touch, or as one before it."""
        if plausible:
            drive = reading.heater_permille / DRIVE_FULL
            self._back.step(t_s - self._sensor_s, drive, reading.sensor_c - reading.ambient_c)
        # A touch starts from sound readings of the free sensor without a gap.
        if contact or not plausible or t_s - self._sensor_s > READING_AGE_S:
            self._free.clear()
        self._sensor_s = t_s
        taken_s = self._clock.step(t_s, reading.device_us)
        if not contact and plausible:
            self._free.append((taken_s, reading.sensor_c))
        self.measuring = contact or self.own.running
        if self.own.running and taken_s > self._contact_s:  # a reading from before contact may arrive after it
            self.own.take(taken_s, reading.sensor_c, force_n)


def reason_of(reading: PlateReading) -> ThermalReason:
    """Return why a reading is implausible: that of its plate, or an ambient thermometer that is shorted or open."""
    if reading.reason or 0.0 < reading.ambient_c < SENSOR_PLATE_C:
        return reading.reason
    return ThermalReason.SENSOR_SHORTED if reading.ambient_c <= 0.0 else ThermalReason.SENSOR_OPEN


class SensorClock:
    """Converts the sensor's times of readings to the receiver's time."""

    def __init__(self) -> None:
        self._device_us = 0
        self._first_s: float | None = None
        self._delay_s = self._held_s = 0.0

    def step(self, arrived_s: float, device_us: int) -> float:
        """Return the time of a reading, s, with the usual transport delay, from its device time, us modulo 2^32."""
        if self._first_s is not None:
            since_us = (device_us - self._device_us + _WRAPS // 2) % _WRAPS - _WRAPS // 2
            on_time_s = self._first_s + since_us * 1e-6
            late_s = arrived_s - on_time_s - self._delay_s
            if abs(late_s) <= LOST_S:
                self._delay_s += FOLLOWS * max(-MOST_LATE_S, min(MOST_LATE_S, late_s))
                if abs(self._delay_s - self._held_s) > STEP_S:
                    self._held_s = self._delay_s
                self._device_us, self._first_s = device_us, on_time_s
                return on_time_s + self._held_s
        self._device_us, self._first_s = device_us, arrived_s
        self._delay_s = self._held_s = 0.0
        return arrived_s
