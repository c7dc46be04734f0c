"""Stroke speed of the hand from noisy, quantised positions."""

import math

from common.recent_samples import RecentSamples

WINDOW_S = 0.024
"""The speed is the mean over so long, s."""


class MotionEstimate:
    """Tangential speed.

    From the mean positions in the first and the last third of the window: nearly as quiet as the slope of a straight
    line (8/9 of its efficiency, Bartlett 1949), at a fraction of its cost, and forgetting completely.

    Attributes:
        speed_m_s: tangential speed, m/s, >= 0; that of half a window ago.
    """

    __slots__ = ("_recent", "speed_m_s")

    def __init__(self) -> None:
        self._recent = RecentSamples(WINDOW_S)
        self.speed_m_s = 0.0

    def step(self, t_s: float, x_m: float, y_m: float) -> None:
        """Take the position at `t_s`; a time that does not advance starts over."""
        self._recent.take(t_s, x_m, y_m)
        if not self._recent.enough:
            self.speed_m_s = 0.0
            return
        passed_s, x_m, y_m = self._recent.rise()
        self.speed_m_s = math.hypot(x_m, y_m) / passed_s
