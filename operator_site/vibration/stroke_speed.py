"""Estimates the stroke speed of the operator's hand from the exoskeleton's quantised pose."""

import math
from collections import deque

from common.limits import GAP_S

WINDOW_S = 0.020
"""Window of the mean speed, s; one pose step of 0.02 mm over it is 1 mm/s."""
LEAST_S = 0.009
"""Shortest part of the window that gives a speed, s."""
SILENCE_S = 0.025
"""Gap after which poses count as delayed, s; they come in a burst with new times, which would look like a leap."""
SETTLE_S = 0.010
"""Time after such a gap for which poses are ignored, s; the former speed holds until new poses give another."""


class StrokeSpeed:
    """Mean speed in the bench plane over the last WINDOW_S."""

    def __init__(self) -> None:
        self._track: deque[tuple[float, float, float]] = deque()
        self._t_s = -math.inf
        self._trusted_s = -math.inf
        self._speed_m_s = 0.0

    def step(self, t_s: float, x_m: float, y_m: float) -> float:
        """Take the pose at `t_s`; return the speed, m/s, >= 0, which restarts at 0 after GAP_S or a clock set back."""
        since_s = t_s - self._t_s
        if since_s == 0.0:
            return self._speed_m_s
        self._t_s = t_s
        if not 0.0 < since_s <= GAP_S:
            self._track.clear()
            self._trusted_s, self._speed_m_s = -math.inf, 0.0
        elif since_s > SILENCE_S:
            self._track.clear()
            self._trusted_s = t_s + SETTLE_S
        if t_s < self._trusted_s:
            return self._speed_m_s
        track = self._track
        track.append((t_s, x_m, y_m))
        while t_s - track[0][0] > WINDOW_S + 1e-4:
            track.popleft()
        old_s, old_x, old_y = track[0]
        if t_s - old_s >= LEAST_S:
            self._speed_m_s = math.hypot(x_m - old_x, y_m - old_y) / (t_s - old_s)
        return self._speed_m_s
