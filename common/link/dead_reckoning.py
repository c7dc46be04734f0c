"""Dead reckoning: extrapolates the hand's position between two packets, alike at both ends of the link.

The sender thus knows the receiver's estimate, and omits packets while the estimate is accurate enough.
"""

from collections import deque

import numpy as np
from numpy.typing import NDArray

from common.timing.timeouts import REFRESH_S

Floats = NDArray[np.float64]

APART_S = 0.008
"""Minimum time between two packets for a speed estimate, s: positions are rounded to 0.02 mm."""
TOGETHER_S = 0.05
"""Maximum time between two packets of one movement, s."""
ONWARDS_S = 2.0 * REFRESH_S
"""Maximum extrapolation, s. It bridges one lost or late refresh; after more, the position stays constant."""
_ROUNDING_S = 1e-6


class DeadReckoning:
    """Extrapolates from the last positions at the speed between them."""

    __slots__ = ("_last", "_last_s", "_pace", "_taken")

    def __init__(self) -> None:
        self._taken: deque[tuple[float, Floats]] = deque()
        self._last_s = 0.0
        self._last: Floats | None = None
        self._pace: Floats | None = None

    def take(self, t_s: float, place_m: NDArray[np.float32]) -> None:
        """Take a packet's positions (5, 3), m, and its source time, s. A clock that was set back starts over."""
        taken = self._taken
        if taken and t_s <= self._last_s:
            taken.clear()
        place: Floats = place_m.astype(np.float64)
        taken.append((t_s, place))
        while len(taken) > 2 and t_s - taken[1][0] >= APART_S - _ROUNDING_S:
            taken.popleft()
        before_s, before = taken[0]
        apart_s = t_s - before_s
        moving = APART_S - _ROUNDING_S <= apart_s <= TOGETHER_S
        self._pace = (place - before) / apart_s if moving else None
        self._last_s, self._last = t_s, place

    def at(self, t_s: float) -> Floats | None:
        """Return the positions (5, 3), m, at a time on the sender's clock, s; None before the first packet."""
        if self._last is None or self._pace is None:
            return self._last
        onwards_s = t_s - self._last_s
        if onwards_s <= 0.0:
            return self._last
        onwards_s = min(onwards_s, ONWARDS_S)
        place: Floats = self._last + onwards_s * self._pace
        return place
