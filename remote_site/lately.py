"""The highest and the lowest of what was told lately: a servo that does not overshoot is somewhere between them."""

from collections import deque

MEMORY_S = 0.25
"""A set-point older than this moves nothing any more: servo (settled after 0.1 s), bus, and a process that stalls."""

_Falling = deque[tuple[float, float]]
"""Times and values of the last MEMORY_S, without those that a later value exceeds (or undercuts): the first is the
highest (or the lowest)."""


class Lately:
    """Values of the last MEMORY_S; `add` one before anything is asked."""

    __slots__ = ("_depth", "_high")

    def __init__(self) -> None:
        self._high: _Falling = deque()
        self._depth: _Falling = deque()

    def add(self, t_s: float, value: float) -> None:
        """Take a value of the time `t_s`, s, which does not go back."""
        high, depth, before_s, now = self._high, self._depth, t_s - MEMORY_S, (t_s, value)
        while high and high[-1][1] <= value:
            high.pop()
        high.append(now)
        while high[0][0] < before_s:
            high.popleft()
        while depth and depth[-1][1] >= value:
            depth.pop()
        depth.append(now)
        while depth[0][0] < before_s:
            depth.popleft()

    @property
    def highest(self) -> float:
        """The highest of them."""
        return self._high[0][1]

    @property
    def lowest(self) -> float:
        """The lowest of them."""
        return self._depth[0][1]
