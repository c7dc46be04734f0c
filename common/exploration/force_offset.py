"""Finds the offset of a fingertip's force sensor: its reading while the finger moves up or down in the air.

An object changes the force of a finger that moves into it or out of it. So a finger whose force stays the same over a
vertical way touches nothing.
"""

import math

WAY_M = 2.5e-3
"""Vertical way with the same force that shows a finger in the air, m; in the softest object the force changes by 0.1 N.

A finger that goes further sideways is on a slope, perhaps.
"""
LONGEST_S = 0.3
"""Longest time for this way, s: a slower finger may follow the breathing of soft tissue."""
SAME_N = 0.04
"""Largest difference of the same force from its mean, N: four times the noise of one reading."""
LEAST_N, MOST_N = 0.025, 0.35
"""Range of an offset, N. Noise that is cut off at 0 has a smaller mean; a larger offset is a fault of the sensor."""


class ForceOffset:
    """Offset of one sensor; step it with each reading.

    Attributes:
        offset_n: offset, N; 0 until the finger has moved in the air.
    """

    def __init__(self) -> None:
        self.offset_n = 0.0
        self._at_m = (0.0, 0.0, 0.0)
        self._mean_n = self._from_s = 0.0
        self._count = 0

    def step(self, t_s: float, force_n: float, x_m: float, y_m: float, z_m: float) -> None:
        """Take a reading, N, and the place of the fingertip, m, at `t_s`, s."""
        same = abs(force_n - self._mean_n) <= SAME_N
        if not (same and self._count and 0.0 <= t_s - self._from_s <= LONGEST_S):
            self._begin(t_s, force_n, x_m, y_m, z_m)
            return
        self._count += 1
        self._mean_n += (force_n - self._mean_n) / self._count
        from_x_m, from_y_m, from_z_m = self._at_m
        if abs(z_m - from_z_m) >= WAY_M:
            if self._mean_n <= MOST_N:
                self.offset_n = self._mean_n if self._mean_n >= LEAST_N else 0.0
            self._begin(t_s, self._mean_n, x_m, y_m, z_m)
        elif abs(x_m - from_x_m) > WAY_M or abs(y_m - from_y_m) > WAY_M:
            self._begin(t_s, self._mean_n, x_m, y_m, z_m)

    def _begin(self, t_s: float, force_n: float, x_m: float, y_m: float, z_m: float) -> None:
        """Begin a way with this force."""
        self._from_s = t_s
        self._count = 1 if math.isfinite(force_n + x_m + y_m + z_m) else 0
        self._mean_n, self._at_m = force_n, (x_m, y_m, z_m)
