"""The set-point of one remote finger's height: it follows the operator's finger and presses no harder than it may."""

import math

from common.faults.fault import Fault
from common.limits import APPROACH_DOWN_M_S
from common.safety.oscillation_detector import OscillationDetector
from remote_site.safety.approach_limiter import ApproachLimiter
from remote_site.safety.limit_flags import APPROACH, ENERGY, FORCE, HEIGHT_RANGE, HEIGHT_SPEED
from remote_site.safety.residual_work import ResidualWork
from remote_site.safety.servo import SERVO_N_M

HEIGHT_LOW_M = -0.0100
HEIGHT_HIGH_M = 0.01046
"""What the telemanipulator's frames can say."""
HEIGHT_SPEED_M_S = 0.10
RETREAT_SPEED_M_S = 0.020
CLEAR_HEIGHT_M = 0.006
"""A retreating finger stops here: hovering height."""
STOP_S = 0.100
"""Between stopping and retreating: a short gap of the network only pauses the hand."""
REACTION_S = 0.030
"""Measurement, tick, bus and servo: what a finger still does after it is told otherwise."""
BRAKE_SHARE = 0.9
"""At this share of the force limit a set-point goes no deeper; approaching it, ever slower."""
TOUCHING_N = 0.15
"""More force than this is contact for the heater, whatever the mode says."""
ROUNDING_M = 1e-9
"""A set-point that misses by rounding only is not reported as limited."""
_BRAKE_N_S_M = SERVO_N_M * REACTION_S


class HeightSetpoint:
    """Each tick `observe` what the finger does, then `follow` or `retreat`.

    Attributes:
        z_m: the set-point.
        left: work that the finger has left in what it touches.
    """

    def __init__(self, force_limit_n: float) -> None:
        """A finger that presses with no more than this, N."""
        self._force_limit_n = force_limit_n
        self._brake_n = BRAKE_SHARE * force_limit_n
        self._reach_m = force_limit_n / SERVO_N_M
        self._approach = ApproachLimiter(APPROACH_DOWN_M_S, HEIGHT_SPEED_M_S)
        self._oscillation = OscillationDetector()
        self._drained = False
        self.left = ResidualWork()
        self.z_m = CLEAR_HEIGHT_M

    def let_go(self, z_m: float) -> None:
        """Begin from where the finger is, m."""
        self.z_m = min(HEIGHT_HIGH_M, max(HEIGHT_LOW_M, z_m))
        self._approach.let_go()

    def believe_again(self) -> None:
        """A person has cleared the fault: what swung before counts no more."""
        self._oscillation.restart()

    def observe(self, t_s: float, dt_s: float, measured_m: float, pressed_n: float, live: bool) -> Fault | None:
        """Return what the finger does that it must not, or None.

        Args:
            t_s: time, s.
            dt_s: since the last step, s.
            measured_m: height of the finger, m; NaN where it is not known.
            pressed_n: its contact force, N.
            live: whether it has followed since the last step.
        """
        self.left.step(dt_s, measured_m, pressed_n)
        if not live:
            self._oscillation.restart()
            return None
        if math.isnan(measured_m):
            return None
        return self._oscillation.step(t_s, pressed_n, self._drained)

    def retreat(self, tick_s: float, pressed_n: float, stopped_s: float) -> None:
        """Stop where the finger is told to be; then, or at once when it presses too hard, up until it is clear."""
        if stopped_s >= STOP_S or pressed_n > self._force_limit_n:
            self.z_m = max(self.z_m, min(CLEAR_HEIGHT_M, self.z_m + RETREAT_SPEED_M_S * tick_s))

    def follow(self, tick_s: float, wanted_m: float, measured_m: float, pressed_n: float, hand_met: bool) -> int:
        """Follow the operator's finger, slower the harder it presses and the more work it has left.

        Args:
            tick_s: how long to move, s.
            wanted_m: where the operator's finger is, m.
            measured_m: where this finger is, m.
            pressed_n: its contact force, N.
            hand_met: whether the hand is over the place that is meant; no finger is lowered before.

        Returns:
            `Limit` bits of what acted.
        """
        acted, before_m, target_m, approach = 0, self.z_m, wanted_m, self._approach
        self._drained = False
        if not HEIGHT_LOW_M <= wanted_m <= HEIGHT_HIGH_M:
            target_m = HEIGHT_HIGH_M if wanted_m > HEIGHT_HIGH_M else HEIGHT_LOW_M
            acted = HEIGHT_RANGE
        up_m = HEIGHT_SPEED_M_S * tick_s
        if pressed_n > self._force_limit_n:
            self.z_m = min(HEIGHT_HIGH_M, before_m + up_m)
            return acted | FORCE
        free_m_s = approach.limit_m_s if hand_met else 0.0
        step_m, held, drained = target_m - before_m, False, False
        if step_m > 0.0:
            z_m = before_m + (step_m if step_m < up_m else up_m)
        else:
            brake_m_s = max(0.0, self._brake_n - pressed_n) / _BRAKE_N_S_M
            drain_m_s = self.left.room_j / (REACTION_S * max(TOUCHING_N, pressed_n))
            drained = drain_m_s < brake_m_s
            down_m_s = drain_m_s if drained else brake_m_s
            held = down_m_s < free_m_s
            down_m = (down_m_s if held else free_m_s) * tick_s
            z_m = before_m + (step_m if step_m > -down_m else -down_m)
        missed_m = z_m - target_m
        if not approach.settled:
            approach.step(tick_s, abs(missed_m))
            if not approach.met:
                acted |= APPROACH
        if held and missed_m > ROUNDING_M:
            self._drained = drained
            acted |= ENERGY if drained else FORCE
        elif not -ROUNDING_M <= missed_m <= ROUNDING_M:
            acted |= HEIGHT_SPEED
        deepest_m = measured_m - self._reach_m
        if z_m < deepest_m:
            acted |= FORCE
            z_m = min(deepest_m, before_m + up_m)
        self.z_m = z_m if z_m < HEIGHT_HIGH_M else HEIGHT_HIGH_M
        return acted
