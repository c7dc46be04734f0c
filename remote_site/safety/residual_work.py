"""How much work a remote finger has left in what it touches.

At the patient a passivity observer has nothing to find: what is touched is passive, and the work on it is the
operator's own. But it is bounded: a finger that presses, and taps as hard and as fast as a hand can, leaves little of
what it puts in, for the object gives it back. A coupling that swings pumps, cycle by cycle, what the object loses in
each. The work is counted at the finger's own measured place and not at the set-point, against which servo and bus turn
the force by so much that even its sign is lost; and it drains at the power that a finger may lastingly leave.
"""

import math

from common.limits import LEFT_J, LEFT_W


class ResidualWork:
    """Of one finger; `left_j` is what it has left beyond what may be left lastingly, J."""

    __slots__ = ("_force_n", "_z_m", "left_j")

    def __init__(self) -> None:
        self._z_m = self._force_n = math.nan
        self.left_j = 0.0

    @property
    def room_j(self) -> float:
        """What may still be left, J."""
        return max(0.0, LEFT_J - self.left_j)

    def step(self, dt_s: float, z_m: float, force_n: float) -> None:
        """Take a finger's measured height and contact force; where they are not numbers it begins anew.

        Args:
            dt_s: since the last step, s.
            z_m: height of the finger, m.
            force_n: contact force, N.
        """
        if force_n == 0.0 == self._force_n and not self.left_j:  # a finger in the air
            self._z_m = z_m
            return
        work_j = 0.5 * (self._force_n + force_n) * (self._z_m - z_m)
        self._z_m, self._force_n = z_m, force_n
        left_j = self.left_j + work_j - LEFT_W * dt_s
        self.left_j = left_j if 0.0 < left_j < math.inf else 0.0  # a comparison with NaN is false
