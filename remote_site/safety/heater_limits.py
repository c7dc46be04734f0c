"""Limits of one thermal sensor's heater, part of the patient-side gate: this plate touches a person."""

import math

from common.limits import GAP_S, SENSOR_PLATE_C
from common.safety.repeated_fault import RepeatedFault
from common.safety.thermal_dose import ThermalDose

SENSOR_LOW_C = -5.0
SENSOR_HIGH_C = 60.0
"""Outside, it is the read-out that is wrong."""
LOOK_AHEAD_S = 0.5
RATE_LAG_S = 0.2
"""The silicon sensor is behind its plate, which is judged by where it will be, from a smoothed rate."""
HOLDING_DRIVE = 0.2
SILENT_WORK_S = 0.6
SILENT_K = 0.3
"""So much drive above what holds a temperature, in s of full drive, must have moved the reading so far."""
TEST_DRIVE = 0.15
TEST_LEAST_K = 0.12
"""Test pulse: its drive, and half of what the slowest sound sensor shows of it, K. The plate moves by 0.4 K."""


class HeaterLimits:
    """One plate's memory: dose, rate, and whether its reading answers to the drive.

    Attributes:
        known: whether the last reading is fresh and plausible.
        repeated: decides whether the heater gets no drive but a test pulse.
        spent: whether the dose is spent.
        too_hot: whether the plate is, or is about to be, above the limit.
    """

    def __init__(self) -> None:
        self.known = False
        self.spent = False
        self.too_hot = False
        self._plate_c = self._mark_c = math.nan
        self._rate_k_s = 0.0
        self._dose = ThermalDose()
        self._work_s = 0.0
        self.repeated = RepeatedFault(TEST_DRIVE, TEST_LEAST_K)
        self._implausible = False

    def step(self, t_s: float, dt_s: float, drive: float, plate_c: float, age_s: float) -> None:
        """Take the reading of this tick.

        Args:
            t_s, dt_s: time and time since the last tick, s.
            drive: what was given to the heater since then, -1..1.
            plate_c: last reading, C; NaN where it is implausible.
            age_s: its age, s.
        """
        fresh = 0.0 <= age_s <= GAP_S
        if not (fresh and SENSOR_LOW_C <= plate_c <= SENSOR_HIGH_C):
            self.known = False
            self._doubt(t_s, fresh)
            return
        if not self.known:
            self.known, self._implausible = True, False
            self._plate_c = self._mark_c = plate_c
            self._rate_k_s = self._work_s = 0.0
        if dt_s > 0.0:
            rate = (plate_c - self._plate_c) / dt_s
            self._rate_k_s += (rate - self._rate_k_s) * dt_s / (RATE_LAG_S + dt_s)
            self._plate_c = plate_c
        if not -SILENT_K < plate_c - self._mark_c < SILENT_K:
            self._mark_c, self._work_s = plate_c, 0.0
        if drive or self._work_s:
            self._work_s = max(0.0, self._work_s + (abs(drive) - HOLDING_DRIVE) * dt_s)
            if self._work_s > SILENT_WORK_S:
                self._work_s = 0.0
                self.repeated.demand_test()
        self.spent = self._dose.step(t_s, plate_c)
        rate_k_s = self._rate_k_s
        self.too_hot = plate_c + (LOOK_AHEAD_S * rate_k_s if rate_k_s > 0.0 else 0.0) > SENSOR_PLATE_C

    def _doubt(self, t_s: float, fresh: bool) -> None:
        """A fresh reading that is implausible is a fault of the sensor, once until it is plausible again."""
        if fresh and not self._implausible:
            self._implausible = True
            self.repeated.named(t_s)
