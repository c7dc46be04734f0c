"""Spread of the hand's positions over the last quarter of a second.

It distinguishes a stroke from tremor: an arm that shakes moves fast, but stays in one place.
"""

import math
from bisect import bisect_right

SPREAD_WINDOW_S = 0.25
"""Length of the window, s: two periods of an arm that shakes at 8 Hz."""
EVERY_S = 0.010
"""Minimum interval between two positions in the window, s."""


class PositionSpread:
    """Positions during the last SPREAD_WINDOW_S. Each finger chooses the time from which they count."""

    def __init__(self) -> None:
        self._t_s: list[float] = []
        self._x_m: list[float] = []
        self._y_m: list[float] = []
        self._found: dict[float, tuple[float, float, float]] = {}

    def step(self, t_s: float, x_m: float, y_m: float) -> None:
        """Take the position at `t_s`, s and m; a time that runs backwards clears the window."""
        times, xs, ys = self._t_s, self._x_m, self._y_m
        if times and 0.0 <= t_s - times[-1] < EVERY_S:
            return
        if times and t_s < times[-1]:
            del times[:], xs[:], ys[:]
        times.append(t_s)
        xs.append(x_m)
        ys.append(y_m)
        while t_s - times[0] > SPREAD_WINDOW_S:
            del times[0], xs[0], ys[0]
        self._found.clear()

    def away_m(self, x_m: float, y_m: float, since_s: float = -math.inf) -> float:
        """Return the distance of a position from the mean of the positions after `since_s`, m."""
        middle_x_m, middle_y_m, _ = self._look(since_s)
        return math.hypot(x_m - middle_x_m, y_m - middle_y_m)

    def reach_m(self, since_s: float = -math.inf) -> float:
        """Return the largest distance from that mean, m; infinite until the window is full."""
        return self._look(since_s)[2]

    def _look(self, since_s: float) -> tuple[float, float, float]:
        """Return mean and reach of the positions after `since_s`, at least of the newest; computed once for each."""
        if (found := self._found.get(since_s)) is not None:
            return found
        first = min(bisect_right(self._t_s, since_s), len(self._t_s) - 1)
        xs, ys = self._x_m[first:], self._y_m[first:]
        x_m, y_m = sum(xs) / len(xs), sum(ys) / len(ys)
        enough = self._t_s[-1] - self._t_s[first] > SPREAD_WINDOW_S - 2.0 * EVERY_S
        reach_m = max(math.hypot(x - x_m, y - y_m) for x, y in zip(xs, ys, strict=True)) if enough else math.inf
        self._found[since_s] = x_m, y_m, reach_m
        return self._found[since_s]
