"""Measures by the camera's own time stamps how late its pictures come."""

import math

DRIFT = 1e-3
"""Drift of the camera's clock that is no lag, s/s; a quartz has less."""


class PictureLag:
    """Lag of the pictures behind the earliest ones. Pure: times are arguments, s.

    A machine that decodes more slowly than the camera sends, or a network that stalls, gives old pictures.
    """

    def __init__(self) -> None:
        self._least_s = math.inf
        """Least time from a time stamp to its picture's arrival; it holds a constant that nobody knows."""
        self._now_s = self._stamp_s = -math.inf

    def take(self, now_s: float, stamp_s: float) -> float:
        """Return the lag, s, of a picture that came at `now_s` of this machine's clock, by its own time stamp, s."""
        came_s = now_s - stamp_s
        if stamp_s < self._stamp_s:  # the camera's clock has begun again
            self._least_s = came_s
        self._least_s = min(came_s, self._least_s + DRIFT * (now_s - self._now_s))
        self._now_s, self._stamp_s = now_s, stamp_s
        return came_s - self._least_s
