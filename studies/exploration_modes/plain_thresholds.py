"""Modes by thresholds on each sample alone: the baseline of the mode machine.

The thresholds and the rest time are those of the machine, but each force sample counts by itself. The speed is the
difference of two positions 16 ms apart. The approach speed is the mean over the 8 ms that end 8 ms before contact.
"""

import math
from collections import deque

from common.exploration.contact_detector import CONTACT_OFF_N, CONTACT_ON_N, TAP_S
from common.exploration.exploration_mode import REST_S, STROKE_DISTANCE_M, STROKE_OFF_M_S, STROKE_ON_M_S
from common.wire.messages import ExplorationMode

WINDOW_S = 0.0161
LONGEST_S = 0.1


class PlainThresholds:
    """Mode of one finger, with the interface of the mode machine."""

    def __init__(self) -> None:
        self.mode = ExplorationMode.FREE
        self.began = False
        self.approach_m_s = 0.0
        self._track: deque[tuple[float, float, float, float]] = deque()
        self._contact_s = self._slow_s = 0.0
        self._tap_m = (0.0, 0.0)

    def step(self, t_s: float, force_n: float, x_m: float, y_m: float, z_m: float) -> ExplorationMode:
        """Advance to `t_s` and return the mode."""
        track = self._track
        track.append((t_s, x_m, y_m, z_m))
        while t_s - track[0][0] > (WINDOW_S if len(track) > 3 else LONGEST_S):
            track.popleft()
        first, middle = track[0], track[len(track) // 2]
        speed = math.hypot(x_m - first[1], y_m - first[2]) / (t_s - first[0]) if len(track) > 2 else 0.0
        self.began = self.mode is ExplorationMode.FREE and force_n >= CONTACT_ON_N
        if self.began:
            self._contact_s, self._tap_m = t_s, (x_m, y_m)
            fell_s = middle[0] - first[0]
            self.approach_m_s = max(0.0, (first[3] - middle[3]) / fell_s) if fell_s else 0.0
        if speed >= STROKE_OFF_M_S:
            self._slow_s = t_s
        self.mode = self._next(t_s, force_n, speed, math.hypot(x_m - self._tap_m[0], y_m - self._tap_m[1]))
        return self.mode

    def _next(self, t_s: float, force_n: float, speed_m_s: float, away_m: float) -> ExplorationMode:
        if not self.began and (self.mode is ExplorationMode.FREE or not force_n >= CONTACT_OFF_N):
            return ExplorationMode.FREE
        if t_s - self._contact_s < TAP_S:
            return ExplorationMode.TAPPING
        if self.mode is ExplorationMode.STROKING and t_s - self._slow_s < REST_S:
            return self.mode
        fast = speed_m_s > STROKE_ON_M_S and away_m > STROKE_DISTANCE_M
        return ExplorationMode.STROKING if fast else ExplorationMode.QUIESCENT
