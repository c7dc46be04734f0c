"""Set-points of the remote hand and fingers, which follow the operator's within range, speed and force limits.

After a release a set-point starts at the measured place and approaches slowly. No finger is lowered before the hand is
over the wanted place. A finger presses no harder than it may.
"""

import math
from dataclasses import dataclass

from common.faults.fault import Fault
from common.limits import APPROACH_DOWN_M_S, APPROACH_PLANE_M_S, REMOTE_LOW_M, REMOTE_PLANE_M, RETREAT_M_S
from common.safety.oscillation_detector import OscillationDetector
from remote_site.safety.limit_flags import (
    APPROACH,
    ENERGY,
    FORCE,
    HEIGHT_RANGE,
    HEIGHT_SPEED,
    PLANE_RANGE,
    PLANE_SPEED,
)
from remote_site.safety.residual_work import ResidualWork
from remote_site.safety.servo import SERVO_N_M

PLANE_RANGE_M = REMOTE_PLANE_M
"""Largest coordinate of the hand along the bench that the telemanipulator's frames can hold, m."""
PLANE_SPEED_M_S = 0.30
"""Speed limit of the hand along the bench, m/s."""
HEIGHT_LOW_M = REMOTE_LOW_M
"""Lowest set-point of a finger, m; the telemanipulator's frames hold no lower one."""
HEIGHT_HIGH_M = 0.01022
"""Highest set-point of a finger, m; the telemanipulator's frames hold no higher one."""
HEIGHT_SPEED_M_S = 0.10
"""Speed limit of a finger up and down, m/s."""
CLEAR_HEIGHT_M = 0.006
"""Height at which a retreating finger that touches nothing stops, m."""
STOP_S = 0.100
"""Time between stopping and retreating, s: a short gap of the network only pauses the hand."""
REACTION_S = 0.030
"""Time until a finger obeys a new set-point, s: measurement, tick, bus and servo."""
BRAKE_SHARE = 0.9
"""Share of the force limit at which a finger is lowered no further; near it the finger is lowered more slowly."""
TOUCHING_N = 0.15
"""Force above which heater and retreat count a finger as touching in every exploration mode, N."""
ROUNDING_M = 1e-9
"""Largest difference between set-point and wanted value that is not reported as limited, m."""
WIDEN_M_S2 = 1.0
"""Growth rate of the speed limit after the set-point has met the wanted value, m/s2."""
MET_M = 1e-6
"""Maximum distance at which a set-point counts as having met the wanted value, m."""
_BRAKE_N_S_M = SERVO_N_M * REACTION_S
"""Damping of the approach to the force limit, N s/m."""


@dataclass(slots=True)
class GatedCommand:
    """Set-points and heater drives that have passed the patient gate.

    Attributes:
        ready: whether the telemanipulator's place was measured once; no set-point may be sent before.
        released: whether the telemanipulator must stop and retreat: it holds the hand, and fingers only rise.
        x_m, y_m, z_m: set-points of the hand and of the five fingertips' heights, m.
        heater_drive: drive of each thermal sensor's heater, -1..1, positive heats.
        limited: `Limit` bits of each finger.
        fault: the latched fault; None without one.
    """

    ready: bool
    released: bool
    x_m: float
    y_m: float
    z_m: list[float]
    heater_drive: list[float]
    limited: list[int]
    fault: Fault | None


class ApproachLimiter:
    """The speed limit of one set-point after its release.

    The operator's hand may have moved anywhere while the outputs were stopped. The set-point closes the distance at
    the approach speed. Once it has met its wanted value, the limit grows to the full speed.

    Attributes:
        limit_m_s: present speed limit, m/s.
        met: whether the set-point has met the wanted value since its release.
        settled: whether it has met and the limit is the full speed; then a step changes nothing.
    """

    def __init__(self, approach_m_s: float, full_m_s: float) -> None:
        """Begin with an approach.

        Args:
            approach_m_s: speed limit until the set-point has met the wanted value, m/s.
            full_m_s: final speed limit, m/s.
        """
        self._approach_m_s, self._full_m_s = approach_m_s, full_m_s
        self.let_go()

    def let_go(self) -> None:
        """Begin an approach."""
        self.limit_m_s, self.met, self.settled = self._approach_m_s, False, False

    def step(self, dt_s: float, left_m: float) -> None:
        """Take the distance that is left to the wanted value after this tick, m."""
        self.met = self.met or left_m <= MET_M
        if self.met:
            self.limit_m_s = min(self._full_m_s, self.limit_m_s + WIDEN_M_S2 * dt_s)
            self.settled = self.limit_m_s == self._full_m_s


class PlaneSetpoint:
    """Set-point of the hand along the bench.

    Attributes:
        x_m, y_m: the set-point, m.
    """

    def __init__(self) -> None:
        self.x_m = self.y_m = 0.0
        self._approach = ApproachLimiter(APPROACH_PLANE_M_S, PLANE_SPEED_M_S)

    @property
    def met(self) -> bool:
        """Whether the set-point has met the operator's hand since its release."""
        return self._approach.met

    def let_go(self, x_m: float, y_m: float) -> None:
        """Start at the hand's measured place, m."""
        self.x_m, self.y_m = _within(x_m, PLANE_RANGE_M), _within(y_m, PLANE_RANGE_M)
        self._approach.let_go()

    def follow(self, tick_s: float, wanted_x_m: float, wanted_y_m: float) -> int:
        """Follow the operator's hand, m, for one tick, s; return `Limit` bits of what acted."""
        target_x_m, target_y_m = _within(wanted_x_m, PLANE_RANGE_M), _within(wanted_y_m, PLANE_RANGE_M)
        reach_m = self._approach.limit_m_s * tick_s
        x_m, y_m = target_x_m - self.x_m, target_y_m - self.y_m
        away_m = math.hypot(x_m, y_m)
        if away_m > reach_m:
            self.x_m += x_m * (reach_m / away_m)
            self.y_m += y_m * (reach_m / away_m)
        else:
            self.x_m, self.y_m = target_x_m, target_y_m
        left_m = away_m - reach_m
        self._approach.step(tick_s, left_m)
        acted = PLANE_RANGE if target_x_m != wanted_x_m or target_y_m != wanted_y_m else 0
        return acted | PLANE_SPEED if left_m > ROUNDING_M else acted


class HeightSetpoint:
    """Set-point of a finger's height: each tick `observe` what the finger does, then `follow` or `retreat`.

    Attributes:
        z_m: the set-point, m.
        left: work that the finger has left in the touched object.
    """

    def __init__(self, force_limit_n: float) -> None:
        """Start clear of the object, with a force limit, N."""
        self.limit_force(force_limit_n)
        self._approach = ApproachLimiter(APPROACH_DOWN_M_S, HEIGHT_SPEED_M_S)
        self._oscillation = OscillationDetector()
        self._drained = False
        self.left = ResidualWork()
        self.z_m = CLEAR_HEIGHT_M

    def limit_force(self, force_limit_n: float) -> None:
        """Use a force limit, N, from the next step on."""
        self._force_limit_n = force_limit_n
        self._brake_n = BRAKE_SHARE * force_limit_n
        self._reach_m = force_limit_n / SERVO_N_M

    def let_go(self, z_m: float) -> None:
        """Start at the finger's measured height, m."""
        self.z_m = min(HEIGHT_HIGH_M, max(HEIGHT_LOW_M, z_m))
        self._approach.let_go()

    def lower_slowly(self) -> None:
        """Lower the finger at the approach speed until it has met the operator's again."""
        self._approach.let_go()

    def observe(self, t_s: float, dt_s: float, measured_m: float, pressed_n: float, live: bool) -> Fault | None:
        """Return the fault of a finger that oscillates; None without one.

        Args:
            t_s: time, s.
            dt_s: time since the last step, s.
            measured_m: height of the finger, m; NaN where it is not known.
            pressed_n: its contact force, N.
            live: whether it has followed since the last step, and its measurements are known.
        """
        self.left.step(dt_s, measured_m, pressed_n)
        if not live:
            self._oscillation.restart()
            return None
        return self._oscillation.step(t_s, pressed_n, self._drained)

    def retreat(self, tick_s: float, pressed_n: float, stopped_s: float) -> None:
        """Stay at the set-point; then, or at once when the finger presses too hard, rise until it is clear.

        A finger that still touches rises further, because the object is higher than usual.
        """
        if stopped_s >= STOP_S or pressed_n > self._force_limit_n:
            clear_m = HEIGHT_HIGH_M if pressed_n > TOUCHING_N else CLEAR_HEIGHT_M
            self.z_m = max(self.z_m, min(clear_m, self.z_m + RETREAT_M_S * tick_s))

    def follow(self, tick_s: float, wanted_m: float, measured_m: float, pressed_n: float, hand_met: bool) -> int:
        """Follow the operator's finger, slower the harder it presses and the more work it has left.

        Args:
            tick_s: duration of the movement, s.
            wanted_m: height of the operator's finger, m.
            measured_m: height of this finger, m.
            pressed_n: its contact force, N.
            hand_met: whether the hand is over the wanted place; no finger is lowered before.

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
            if hand_met:  # a height that agrees elsewhere is no agreement at the wanted place
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


def _within(value: float, reach: float) -> float:
    if -reach <= value <= reach:
        return value
    return reach if value > reach else -reach
