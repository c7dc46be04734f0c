"""Residual work: the energy that a remote finger leaves in the object it touches.

A passivity observer at the patient detects nothing, because the object is passive and the work on it is the operator's
own. The residual work is nevertheless bounded in normal use. A finger that presses, or taps as hard and fast as a hand
can, leaves little work, because the object returns most of it. An oscillating coupling adds in each cycle the energy
that the object dissipates. The work is computed from the measured position of the finger. With the set-point, the
phase lag of servo and bus would change even the sign of the work. The sum drains at LEFT_W, the power that a finger
may leave permanently.
"""

import math

from common.limits import LEFT_J, LEFT_W


class ResidualWork:
    """Residual work of one finger; `left_j` is the work left beyond the permitted permanent power, J."""

    def __init__(self) -> None:
        self._z_m = self._force_n = math.nan
        self.left_j = 0.0

    @property
    def room_j(self) -> float:
        """Work that the finger may still leave, J."""
        return max(0.0, LEFT_J - self.left_j)

    def step(self, dt_s: float, z_m: float, force_n: float) -> None:
        """Take a finger's measured height and contact force; values that are not finite reset the sum to zero.

        Args:
            dt_s: time since the last step, s.
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
