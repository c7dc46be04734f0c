"""Tracks the spot that a plate has warmed, because the model of a touch assumes an object of uniform temperature.

A steady flux for a time T warms a half space's surface like sqrt(T). After a pause P, sqrt(T + P) - sqrt(P) of that is
left (Carslaw & Jaeger 1959, section 2.9). Heat leaves as slowly as it came, for every material.
"""

import math

SPOT_M = 0.010
"""Maximum distance of two touches on the same spot, m; a plate has 14 mm, so that beyond it they share little area."""
LONGEST_S = 10.0
"""Maximum duration of a touch that warms the spot further, s; by then the plate has given its heat away."""
WARM = 0.27
"""Share of the warming above which a touch gives no new information.

It is left after three times the touch's duration.
"""
TRACES = 0.09
"""Share of the warming above which each finger's spot has its own temperature.

It is left after thirty times the touch's duration.
"""


class WarmedSpot:
    """Last spot under one finger's plate; step it with each tick of contact."""

    def __init__(self) -> None:
        self._x_m = self._y_m = 0.0
        self._pressed_s = 0.0
        self._before_s = -math.inf

    def press(self, t_s: float, x_m: float, y_m: float, began: bool) -> None:
        """Take a tick of contact at a place of the hand on the bench, m; `began` if it has just begun."""
        if not self.near(x_m, y_m) or (began and self.left(t_s, x_m, y_m) <= WARM):
            self._x_m, self._y_m, self._pressed_s = x_m, y_m, 0.0
        elif not began:
            self._pressed_s = min(self._pressed_s + t_s - self._before_s, LONGEST_S)
        self._before_s = t_s

    def near(self, x_m: float, y_m: float) -> bool:
        """Return whether a place is on the spot."""
        return math.hypot(x_m - self._x_m, y_m - self._y_m) <= SPOT_M

    def left(self, t_s: float, x_m: float, y_m: float) -> float:
        """Return the share of the spot's warming that is left below a plate that lands here, 0..1."""
        if self._pressed_s == 0.0 or not self.near(x_m, y_m):
            return 0.0
        pause = max(t_s - self._before_s, 0.0) / self._pressed_s
        return math.sqrt(1.0 + pause) - math.sqrt(pause)
