"""Sliding minimum and maximum of recent set-points: a servo that does not overshoot is between them."""

import math
from collections import deque

MEMORY_S = 0.25
"""A set-point older than this moves nothing any more: servo (settled after 0.1 s), bus, and a process that stalls."""

_Falling = deque[tuple[float, float]]
"""Times and values of the last MEMORY_S, without those that a later value exceeds (or undercuts): the first is the
highest (or the lowest)."""


class SlidingExtrema:
    """Values of the last MEMORY_S.

    Attributes:
        highest, lowest: of them; infinite before the first `add`.
    """

    __slots__ = ("_depth", "_high", "highest", "lowest")

    def __init__(self) -> None:
        self._high: _Falling = deque()
        self._depth: _Falling = deque()
        self.highest = -math.inf
        self.lowest = math.inf

    def add(self, t_s: float, value: float) -> None:
        """Take a value of the time `t_s`, s, which does not go back."""
        high, depth, before_s, entry = self._high, self._depth, t_s - MEMORY_S, (t_s, value)
        while high and high[-1][1] <= value:
            high.pop()
        high.append(entry)
        while high[0][0] < before_s:
            high.popleft()
        self.highest = high[0][1]
        while depth and depth[-1][1] >= value:
            depth.pop()
        depth.append(entry)
        while depth[0][0] < before_s:
            depth.popleft()
        self.lowest = depth[0][1]
