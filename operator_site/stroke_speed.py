"""How fast the operator's hand strokes, from the exoskeleton's quantised pose."""

import math
from collections import deque

WINDOW_S = 0.020
"""The pose steps by 0.02 mm: over this window one step is 1 mm/s."""


class StrokeSpeed:
    """Speed in the bench plane as the mean over the last WINDOW_S."""

    def __init__(self) -> None:
        self._track: deque[tuple[float, float, float]] = deque()

    def step(self, t_s: float, x_m: float, y_m: float) -> float:
        """Take the pose at `t_s` and return the speed, m/s, >= 0; a time that does not advance starts over."""
        track = self._track
        if track and not t_s > track[-1][0]:
            track.clear()
        track.append((t_s, x_m, y_m))
        while t_s - track[0][0] > WINDOW_S + 1e-4:
            track.popleft()
        old_s, old_x, old_y = track[0]
        return math.hypot(x_m - old_x, y_m - old_y) / (t_s - old_s) if t_s > old_s else 0.0
