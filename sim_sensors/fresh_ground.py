"""How fast a plate comes over ground that it has not warmed yet."""

import math

PLAY_M = 0.5e-3
"""A plate of 14 mm that trembles to and fro within this stays on the ground that it has warmed."""


class FreshGround:
    """Follows a plate along the bench: only what it moves beyond its play is new ground."""

    def __init__(self) -> None:
        """A plate at the origin."""
        self._x_m = self._y_m = 0.0
        self._come_m = 0.0

    def move(self, x_m: float, y_m: float) -> None:
        """The plate is here now."""
        x, y = x_m - self._x_m, y_m - self._y_m
        away = math.hypot(x, y)
        if away > PLAY_M:
            beyond = away - PLAY_M
            self._x_m += x * beyond / away
            self._y_m += y * beyond / away
            self._come_m += beyond

    def take_speed_m_s(self, dt_s: float) -> float:
        """Mean speed over new ground since the last call, `dt_s` ago."""
        come_m, self._come_m = self._come_m, 0.0
        return come_m / dt_s
