"""Measure the speed of a plate over ground that it has not warmed yet."""

import math

PLAY_M = 0.5e-3
"""Play of a plate, m: a plate of 14 mm that trembles within it stays on the ground that it has warmed."""


class PlateTravel:
    """Follow a plate along the bench; only movement beyond the play reaches new ground."""

    def __init__(self) -> None:
        """Start with the plate at the origin."""
        self._x_m = self._y_m = 0.0
        self._come_m = 0.0

    def move(self, x_m: float, y_m: float) -> None:
        """Move the plate to a position, m."""
        x, y = x_m - self._x_m, y_m - self._y_m
        away = math.hypot(x, y)
        if away > PLAY_M:
            beyond = away - PLAY_M
            self._x_m += x * beyond / away
            self._y_m += y * beyond / away
            self._come_m += beyond

    def take_speed_m_s(self, dt_s: float) -> float:
        """Return the mean speed over new ground since the last call, `dt_s` ago, m/s."""
        come_m, self._come_m = self._come_m, 0.0
        return come_m / dt_s
