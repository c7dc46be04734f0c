"""Motion of the hand over the bench, which all of its fingers share."""

import math

from common.exploration.position_spread import PositionSpread
from common.exploration.sample_window import SampleWindow

WINDOW_S = 0.024
"""Length of the window over which the speed is averaged, s."""


class HandMotion:
    """Position, speed and position spread of one hand; step it before its fingers.

    The speed is the difference between the mean positions in the first and the last third of the window. Its
    efficiency is 8/9 of that of a fitted straight line (Bartlett 1949), at a fraction of the cost. Samples outside the
    window have no effect.

    Attributes:
        x_m, y_m: position along the bench and across it, m.
        speed_m_s: tangential speed half a window ago, m/s, >= 0.
        spread: spread of the positions in the last quarter of a second.
    """

    def __init__(self) -> None:
        self.x_m = self.y_m = self.speed_m_s = 0.0
        self.spread = PositionSpread()
        self._recent = SampleWindow(WINDOW_S)

    def step(self, t_s: float, x_m: float, y_m: float) -> None:
        """Take the position at `t_s`, s and m; a time that does not advance clears the window."""
        self.x_m, self.y_m = x_m, y_m
        self._recent.take(t_s, x_m, y_m)
        self.speed_m_s = 0.0
        if self._recent.enough:
            passed_s, gone_x_m, gone_y_m = self._recent.rise()
            self.speed_m_s = math.hypot(gone_x_m, gone_y_m) / passed_s
        self.spread.step(t_s, x_m, y_m)
