"""Sliding minimum and maximum of recent set-points. A servo without overshoot stays between them."""

import math
from collections import deque

MEMORY_S = 0.25
"""Maximum time for which a set-point can move a finger, s: servo (settled after 0.1 s), bus and a process stall."""

_Falling = deque[tuple[float, float]]
"""Times, s, and values of the last MEMORY_S, without values that a later one exceeds (for the minimum: undercuts).

The first entry is the maximum (or the minimum).
"""


class SlidingExtrema:
    """Sliding extrema of the last MEMORY_S.

    Attributes:
        highest, lowest: the extrema; infinite before the first `add`.
    """

    def __init__(self) -> None:
        self._high: _Falling = deque()
        self._depth: _Falling = deque()
        self.highest = -math.inf
        self.lowest = math.inf

    def add(self, t_s: float, value: float) -> None:
        """Take a value of the time `t_s`, s, which never decreases."""
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
