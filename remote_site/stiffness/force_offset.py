"""Estimates the offset of a fingertip's force sensor: its mean reading while the finger touches nothing."""

import math

SETTLES_S = 1.0
"""Time constant of the mean, s: a slow press is over sooner, and the offset of a sensor changes more slowly.

The first readings form a plain mean.
"""
LEAST_N = 0.015
"""Smallest offset, N; noise that is cut off at 0 has a smaller mean."""
LONGEST_STEP_S = 0.1
"""Longest time between two readings that counts, s."""


class ForceOffset:
    """Offset of one sensor; step it with each reading."""

    __slots__ = ("_free_s", "_mean_n", "_t_s")

    def __init__(self) -> None:
        self._t_s = math.nan
        self._mean_n = self._free_s = 0.0

    def step(self, t_s: float, force_n: float, touching: bool) -> float:
        """Take a reading, N, at `t_s`, s; return the offset, N. A reading in contact or not finite does not count."""
        passed_s, self._t_s = t_s - self._t_s, t_s
        if not touching and 0.0 < passed_s <= LONGEST_STEP_S and math.isfinite(force_n):
            self._mean_n += (force_n - self._mean_n) * passed_s / (self._free_s + passed_s)
            self._free_s = min(SETTLES_S, self._free_s + passed_s)
        return self._mean_n if self._mean_n >= LEAST_N else 0.0
