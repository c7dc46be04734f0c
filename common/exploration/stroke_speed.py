"""Estimates the stroke speed of the hand from noisy, quantised positions."""

import math

from common.exploration.sample_window import SampleWindow

WINDOW_S = 0.024
"""Length of the window over which the speed is averaged, s."""


class HandSpeed:
    """Tangential speed of the hand.

    The estimate is the difference between the mean positions in the first and the last third of the window. Its
    efficiency is 8/9 of that of a fitted straight line (Bartlett 1949), at a fraction of the cost. Samples outside the
    window have no effect.

    Attributes:
        speed_m_s: tangential speed half a window ago, m/s, >= 0.
    """

    def __init__(self) -> None:
        self._recent = SampleWindow(WINDOW_S)
        self.speed_m_s = 0.0

    def step(self, t_s: float, x_m: float, y_m: float) -> None:
        """Take the position at `t_s`, s and m; a time that does not advance clears the window."""
        self._recent.take(t_s, x_m, y_m)
        self.speed_m_s = 0.0
        if self._recent.enough:
            passed_s, gone_x_m, gone_y_m = self._recent.rise()
            self.speed_m_s = math.hypot(gone_x_m, gone_y_m) / passed_s
