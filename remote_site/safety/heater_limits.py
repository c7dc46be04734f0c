"""Limits of one thermal sensor's heater, a part of the patient-side gate. The heated plate touches a person."""

import math

from common.limits import GAP_S, SENSOR_PLATE_C
from common.safety.repeated_fault import RepeatedFault
from common.safety.thermal_dose import ThermalDose
from remote_site.safety.holding_loss import HoldingLoss
from remote_site.safety.slow_heating import SlowHeating

SENSOR_LOW_C = -5.0
"""Lowest plausible reading, C; a lower one is a fault of the read-out."""
SENSOR_HIGH_C = 60.0
"""Highest plausible reading, C; a higher one is a fault of the read-out."""
LOOK_AHEAD_S = 0.5
"""Prediction horizon of the plate temperature, s; the silicon sensor lags behind its plate."""
RATE_LAG_S = 0.2
"""Time constant of the filter for the reading's rate of change, s."""
HOLDING_DRIVE = 0.2
"""Drive that may be needed to hold a temperature, 0..1; only more drive must change the reading."""
SILENT_WORK_S = 0.6
"""Drive above HOLDING_DRIVE after which the reading must have changed by SILENT_K, s of full drive."""
SILENT_K = 0.3
"""Smallest change of the reading that counts as an answer to the drive, K."""
AGAINST_WORK_S = 1.5
"""Drive above HOLDING_DRIVE after which the reading must have followed it by SILENT_K, s of full drive.

The slowest sensor still follows a cold object for up to 0.7 s when it is heated again."""
TEST_DRIVE = 0.15
"""Drive of the test pulse, 0..1."""
TEST_LEAST_K = 0.12
"""Smallest answer to a test pulse, K: half that of the slowest sound sensor. The plate itself changes by 0.4 K."""


class HeaterLimits:
    """State of one plate: dose, rate, and whether its reading answers to the drive.

    Attributes:
        known: whether the last reading is fresh and plausible.
        repeated: decides whether the heater gets only a test pulse.
        spent: whether the dose is spent.
        too_hot: whether the plate is above the limit, or soon will be.
    """

    def __init__(self) -> None:
        self.known = False
        self.spent = False
        self.too_hot = False
        self._plate_c = self._mark_c = math.nan
        self._rate_k_s = 0.0
        self._dose = ThermalDose()
        self._work_s = self._against_s = 0.0
        self._slow_heating, self._holding_loss = SlowHeating(), HoldingLoss()
        self.repeated = RepeatedFault(TEST_DRIVE, TEST_LEAST_K)
        self._implausible = False

    def step(self, t_s: float, dt_s: float, drive: float, plate_c: float, ambient_c: float, age_s: float) -> None:
        """Take the reading of this tick.

        Args:
            t_s, dt_s: time and time since the last tick, s; without a time, NaN, no reading is known.
            drive: drive of the heater since the last tick, -1..1.
            plate_c: last reading, C; NaN when it is implausible.
            ambient_c: last reading of the air, C; NaN when it is implausible.
            age_s: age of the reading, s.
        """
        fresh = 0.0 <= age_s <= GAP_S and not math.isnan(t_s)
        if not (fresh and SENSOR_LOW_C <= plate_c <= SENSOR_HIGH_C):
            self.known = False
            self._doubt(t_s, fresh)
            return
        if not self.known:
            self.known, self._implausible = True, False
            self._plate_c = self._mark_c = plate_c
            self._rate_k_s = self._work_s = self._against_s = 0.0
        if dt_s > 0.0:
            rate = (plate_c - self._plate_c) / dt_s
            self._rate_k_s += (rate - self._rate_k_s) * dt_s / (RATE_LAG_S + dt_s)
            self._plate_c = plate_c
        moved_k = plate_c - self._mark_c
        if not -SILENT_K < moved_k < SILENT_K:
            self._mark_c, self._work_s = plate_c, 0.0
            if moved_k * drive >= 0.0:
                self._against_s = 0.0
        if drive or self._work_s or self._against_s:
            work_s = (abs(drive) - HOLDING_DRIVE) * dt_s
            self._work_s, self._against_s = max(0.0, self._work_s + work_s), max(0.0, self._against_s + work_s)
            if self._work_s > SILENT_WORK_S or self._against_s > AGAINST_WORK_S:
                self._work_s = self._against_s = 0.0
                self.repeated.demand_test()
        slow = self._slow_heating.step(dt_s, drive, self._rate_k_s)
        # A test drives the plate without holding a temperature.
        held_drive = 0.0 if self.repeated.needs_test else drive
        if self._holding_loss.step(dt_s, held_drive, plate_c - ambient_c) or slow:
            self.repeated.demand_test()
        self.spent = self._dose.step(t_s, plate_c)
        rate_k_s = self._rate_k_s
        self.too_hot = plate_c + (LOOK_AHEAD_S * rate_k_s if rate_k_s > 0.0 else 0.0) > SENSOR_PLATE_C

    def _doubt(self, t_s: float, fresh: bool) -> None:
        """Count a fresh but implausible reading as one sensor fault, until a reading is plausible again."""
        if fresh and not self._implausible:
            self._implausible = True
            self.repeated.named(t_s)
