"""Is an encoder of the telemanipulator stuck, or the joint that it measures?

A finger on a servo of known stiffness goes where its set-point and the contact force take it. When that place has moved
further than friction and an unknown stiffness explain, and the reading is the same to the count, one of the two is
stuck. A joint that moves but not where it was sent is for `telemanipulator_follow`.
"""

from common.faults.fault import Fault, FaultCode
from remote_site.safety.servo import LONGEST_TICK_S, SERVO_N_M

FRICTION_M = 0.08e-3
"""A servo's dry friction may hold a finger against this, and set-points are rounded to 0.02 mm."""
STIFFNESS_SHARE = 0.25
"""The servo's stiffness may be another by this."""
SETTLE_S = 0.05
"""Place and force are smoothed with it, against noise and the servo's lag."""
PERSIST_S = 0.25


class StuckEncoder:
    """Watches one finger; `step` for each reading.

    Attributes:
        fault: what is wrong as of the last reading; None when nothing is.
    """

    __slots__ = ("_bent_m", "_from", "_height_m", "_same_s", "_set_m", "_wrong_s", "fault")

    def __init__(self) -> None:
        self.fault: Fault | None = None
        self._height_m: float | None = None
        self._set_m = self._bent_m = 0.0
        self._from: tuple[float, float] | None = None
        self._same_s = self._wrong_s = 0.0

    def step(self, dt_s: float, height_m: float, force_n: float, set_m: float | None) -> Fault | None:
        """Take a reading; returns what is wrong, None when nothing is.

        Args:
            dt_s: since the reading before, s; not above 0 where that is not known.
            height_m: of the finger, m, as it was read.
            force_n: contact force, N.
            set_m: set-point that it follows, m; None while it follows none.
        """
        if set_m is None or height_m != self._height_m:
            # What it stood at before it was sent anywhere is no reading of a finger that follows.
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
