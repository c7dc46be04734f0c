"""Finds a faulty force sensor of a fingertip by comparing its reading with the deflection of the finger's servo.

    frozen    the reading under load is constant for FROZEN_S
    dead      the reading is constant while the finger is held above all recent set-points
    biased    the reading shows a force, but the servo is not deflected

A finger on a servo of known stiffness rests at its set-point plus the deflection by the force. While set-points move,
it is at a mean of the recent ones. So it is compared with the highest and the lowest of these.
"""

from common.faults.fault import Fault, FaultCode
from remote_site.safety.servo import LONGEST_TICK_S, SERVO_N_M
from remote_site.safety.sliding_extrema import MEMORY_S, SlidingExtrema

LOADED_N = 0.15
"""Force below which a sensor may stay at 0, N, because its noise is cut off there."""
FROZEN_S = 0.25
"""Duration of a constant reading that is frozen, s; with noise of about a count it changes many times in this time."""
HELD_M = 0.0008
"""Distance above its set-points from which on a finger is held by an object, m; it is 0.8 N."""
BIAS_N, BIAS_SHARE = 0.25, 0.25
"""Force, N, that the servo's deflection may lack, and relative error of the servo's stiffness."""
PERSIST_S = 0.10
"""Duration of the disagreement that is a fault, s; the swing after a hard touch is shorter."""


class ForceSensorFault:
    """Watches one finger: `step` for each reading, `commanded` for each set-point."""

    def __init__(self) -> None:
        self._set_m = SlidingExtrema()
        self._following_s: float | None = None
        self._t_s = 0.0
        self._force_n = -1.0
        self._same_s = self._wrong_s = 0.0

    def commanded(self, t_s: float, set_m: float, released: bool) -> None:
        """Take a set-point, m, sent at `t_s`, s; when released, the finger moves by itself."""
        self._t_s = t_s
        if released:
            self._following_s = None
        elif self._following_s is None:
            self._following_s = t_s
        self._set_m.add(t_s, set_m)

    def step(self, dt_s: float, force_n: float, height_m: float) -> Fault | None:
        """Take a reading; return the fault, None without one. `dt_s` is 0 or less where it is not known."""
        passed_s = dt_s if 0.0 <= dt_s <= LONGEST_TICK_S else LONGEST_TICK_S if dt_s > 0.0 else 0.0
        if force_n == self._force_n:
            self._same_s += passed_s
        else:
            self._force_n, self._same_s = force_n, 0.0
        frozen = self._same_s >= FROZEN_S
        wrong = self._servo_disagrees(force_n, height_m, frozen)
        self._wrong_s = self._wrong_s + passed_s if wrong else 0.0
        if frozen and force_n >= LOADED_N:
            return Fault(FaultCode.FORCE_SENSOR_FROZEN, value=force_n)
        return wrong if self._wrong_s >= PERSIST_S else None

    def _servo_disagrees(self, force_n: float, height_m: float, frozen: bool) -> Fault | None:
        """Compare with the servo once the finger has followed all set-points that still act."""
        if self._following_s is None or self._t_s - self._following_s < MEMORY_S:
            return None
        if frozen and (held_m := height_m - self._set_m.highest) > HELD_M:
            reading = f"{force_n:.2f} N"
            return Fault(FaultCode.FORCE_SENSOR_DEAD, value=held_m * 1e3, limit=HELD_M * 1e3, detail=reading)
        bent_n = SERVO_N_M * (height_m - self._set_m.lowest)
        if force_n * (1.0 - BIAS_SHARE) - BIAS_N > bent_n:
            return Fault(FaultCode.FORCE_SENSOR_BIASED, value=force_n, limit=max(0.0, bent_n))
        return None
