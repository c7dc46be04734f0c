"""Where a finger has been lately, and how far it got: whether its motion leads anywhere.

An arm that shakes is fast at every moment and goes nowhere; a stroke is somewhere else a quarter of a second later.
"""

import math
from bisect import bisect_right

LATELY_S = 0.25
"""Two periods of an arm that shakes at 8 Hz."""
EVERY_S = 0.010


class Whereabouts:
    """Places of one finger during the last LATELY_S.

    Attributes:
        reach_m: largest distance from their middle, m; infinite until there are enough of them.
    """

    __slots__ = ("_middle_x_m", "_middle_y_m", "_t_s", "_x_m", "_y_m", "reach_m")

    def __init__(self) -> None:
        self._t_s: list[float] = []
        self._x_m: list[float] = []
        self._y_m: list[float] = []
        self._middle_x_m = self._middle_y_m = 0.0
        self.reach_m = math.inf

    def step(self, t_s: float, x_m: float, y_m: float) -> None:
        """Take the place at `t_s`; a time that goes back starts over."""
        times, xs, ys = self._t_s, self._x_m, self._y_m
        if times and 0.0 <= t_s - times[-1] < EVERY_S:
            return
        if times and t_s < times[-1]:
            del times[:], xs[:], ys[:]
        times.append(t_s)
        xs.append(x_m)
        ys.append(y_m)
        while t_s - times[0] > LATELY_S:
            del times[0], xs[0], ys[0]
        self._look()

    def forget(self, until_s: float) -> None:
        """Leave out where it was until `until_s`: what it does since then has a place of its own."""
        first = bisect_right(self._t_s, until_s)
        for track in (self._t_s, self._x_m, self._y_m):
            del track[: min(first, len(track) - 1)]
        self._look()

    def away_m(self, x_m: float, y_m: float) -> float:
        """Distance of a place from the middle of where it has been, m."""
        return math.hypot(x_m - self._middle_x_m, y_m - self._middle_y_m)

    def _look(self) -> None:
        xs, ys = self._x_m, self._y_m
        self._middle_x_m, self._middle_y_m = sum(xs) / len(xs), sum(ys) / len(ys)
        enough = self._t_s[-1] - self._t_s[0] > LATELY_S - 2.0 * EVERY_S
        self.reach_m = max(map(self.away_m, xs, ys)) if enough else math.inf
