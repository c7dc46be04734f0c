"""Where a plate has just been it has warmed the spot; the model of a touch begins with an object of one temperature.

A steady flux for a time T warms a half space's surface like sqrt(T); after a pause P, sqrt(T + P) - sqrt(P) of that is
left (Carslaw & Jaeger 1959, section 2.9). Heat goes as slowly as it came, whatever the material.
"""

import math

SPOT_M = 0.010
"""Places of a plate of 14 mm that are farther apart have little ground in common, m."""
LONGEST_S = 10.0
"""By then a plate has given away what it had: a longer touch warms no further, s."""
WARM = 0.27
"""Where more than this is left, a touch tells nothing new: three times the touch's time after it."""
TRACES = 0.09
"""Where more than this is left, each finger's spot has a temperature of its own: thirty times the touch's time after
it."""


class WarmedSpot:
    """The last spot that one finger's plate pressed on; step it with each tick of contact."""

    def __init__(self) -> None:
        """No spot yet."""
        self._x_m = self._y_m = 0.0
        self._pressed_s = 0.0
        self._before_s = -math.inf

    def press(self, t_s: float, x_m: float, y_m: float, began: bool) -> None:
        """The plate is in contact.

        Args:
            t_s: time, s.
            x_m: hand along the bench, m.
            y_m: hand across it, m.
            began: whether the contact began just now.
        """
        if not self.near(x_m, y_m) or (began and self.left(t_s, x_m, y_m) <= WARM):
            self._x_m, self._y_m, self._pressed_s = x_m, y_m, 0.0
        elif not began:
            self._pressed_s = min(self._pressed_s + t_s - self._before_s, LONGEST_S)
        self._before_s = t_s

    def near(self, x_m: float, y_m: float) -> bool:
        """Whether a place is on the spot."""
        return math.hypot(x_m - self._x_m, y_m - self._y_m) <= SPOT_M

    def left(self, t_s: float, x_m: float, y_m: float) -> float:
        """How much of the spot's warming is left below a plate that lands here, 0..1."""
        if self._pressed_s == 0.0 or not self.near(x_m, y_m):
            return 0.0
        pause = max(t_s - self._before_s, 0.0) / self._pressed_s
        return math.sqrt(1.0 + pause) - math.sqrt(pause)
