"""Finger velocity from quantised positions."""

import math
from collections import deque

WINDOW_S = 0.016
"""Length of the differencing window, s: one step of 0.02 mm of the hand's position is 1.25 mm/s over it."""
LEAST = 3
LONGEST_S = 0.1
"""Samples that a speed needs at least, and how far back they may lie when the loop was late, s."""


class MotionEstimate:
    """Tangential and approach speed of one finger, as the mean over the last WINDOW_S.

    A difference over a window suppresses the quantisation of positions better than a first-order
    low-pass of the same delay (8 ms) and forgets completely.

    Attributes:
        speed_m_s: tangential speed, m/s, >= 0.
        approach_m_s: downward speed in the older half of the window, m/s: at the instant of
            contact that is the approach just before it.
    """

    __slots__ = ("_track", "approach_m_s", "speed_m_s")

    def __init__(self) -> None:
        self._track: deque[tuple[float, float, float, float]] = deque()
        self.speed_m_s = 0.0
        self.approach_m_s = 0.0

    def step(self, t_s: float, x_m: float, y_m: float, z_m: float) -> None:
        """Take the position at `t_s`; a time that does not advance starts over."""
        track = self._track
        if track and not t_s > track[-1][0]:
            track.clear()
        track.append((t_s, x_m, y_m, z_m))
        # A late tick must not leave the window empty: three samples say more than none, unless they are old.
        while t_s - track[0][0] > (WINDOW_S if len(track) > LEAST else LONGEST_S) + 1e-4:
            track.popleft()
        if len(track) < LEAST:
            self.speed_m_s = self.approach_m_s = 0.0
            return
        old_t, old_x, old_y, old_z = track[0]
        middle_t, _, _, middle_z = track[len(track) // 2]
        self.speed_m_s = math.hypot(x_m - old_x, y_m - old_y) / (t_s - old_t)
        self.approach_m_s = (old_z - middle_z) / (middle_t - old_t)
