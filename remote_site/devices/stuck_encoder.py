"""Finds a stuck encoder of the telemanipulator, or a stuck joint.

A finger on a servo of known stiffness is where its set-point and the contact force move it. If that place has moved
further than friction and an error of the stiffness explain, and the reading is the same count, encoder or joint is
stuck. A joint that moves to a wrong place is a following error.
"""

from common.faults.fault import Fault, FaultCode
from remote_site.safety.servo import LONGEST_TICK_S, SERVO_N_M

FRICTION_M = 0.08e-3
"""Distance that a servo's dry friction may hold, m; set-points are rounded to 0.02 mm."""
STIFFNESS_SHARE = 0.25
"""Relative error of the servo's stiffness."""
SETTLE_S = 0.05
"""Time constant of the filter of place and force, s, against noise and the servo's lag."""
PERSIST_S = 0.25
"""Duration of the disagreement that is a fault, s."""


class StuckEncoder:
    """Watches one finger; `step` for each reading.

    Attributes:
        fault: fault as of the last reading; None without one.
    """

    def __init__(self) -> None:
        self.fault: Fault | None = None
        self._height_m: float | None = None
        self._set_m = self._bent_m = 0.0
        self._from: tuple[float, float] | None = None
        self._same_s = self._wrong_s = 0.0

    def step(self, dt_s: float, height_m: float, force_n: float, set_m: float | None) -> Fault | None:
        """Take a reading; return the fault, None without one. `dt_s` is 0 or less where it is not known.

        `set_m` is the set-point that the finger follows, m; None while it follows none.
        """
        if set_m is None or height_m != self._height_m:
            # A reading before the first set-point is not of a finger that follows.
            self._height_m = None if set_m is None else height_m
            self._set_m, self._bent_m = set_m or 0.0, force_n / SERVO_N_M
            if self._same_s:
                self._from = self.fault = None
                self._same_s = self._wrong_s = 0.0
            return None
        passed_s = min(LONGEST_TICK_S, max(0.0, dt_s))
        share = passed_s / (SETTLE_S + passed_s)
        self._set_m += share * (set_m - self._set_m)
        self._bent_m += share * (force_n / SERVO_N_M - self._bent_m)
        self._same_s += passed_s
        if self._same_s < 4.0 * SETTLE_S:
            return None
        if self._from is None:
            self._from = self._set_m, self._bent_m
        bent_m = self._bent_m - self._from[1]
        moved_m = abs(self._set_m - self._from[0] + bent_m)
        wrong = moved_m > FRICTION_M + STIFFNESS_SHARE * abs(bent_m)
        self._wrong_s = self._wrong_s + passed_s if wrong else 0.0
        if self._wrong_s >= PERSIST_S:
            self.fault = Fault(FaultCode.ENCODER_STUCK, value=moved_m * 1e3)
        return self.fault
