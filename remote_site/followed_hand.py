"""Where the operator's hand was, and when: the way that the telemanipulator follows.

A groove belongs to the moment at which the operator's hand was over it. The telemanipulator is late by the network's
delay, by its jitter and by its own lag; by the place alone that moment is found whatever they are.
"""

from collections import deque
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

KEPT_S = 0.6
"""Longer than a link may be late."""
NEAR_M = 0.5e-3
"""The hand was at a place when its way passes it at this distance or less: the telemanipulator cuts corners."""


class HandPlace(NamedTuple):
    """What a motion packet says of the hand: its source time on the operator's clock, and the place, m."""

    time_ns: int
    x_m: float
    y_m: float


class FollowedHand:
    """The way of the last KEPT_S."""

    def __init__(self) -> None:
        self._way: deque[HandPlace] = deque()
        self._late_ns = 0.0

    def step(self, hand: HandPlace | None) -> None:
        """Take what is followed now, the same for as long as there is nothing newer; None where nothing is."""
        way = self._way
        if hand is None or (way and hand.time_ns < way[-1].time_ns):
            way.clear()
            self._late_ns = 0.0
        if hand is None or (way and hand.time_ns == way[-1].time_ns):
            return
        way.append(hand)
        while hand.time_ns - way[0].time_ns > KEPT_S * 1e9:
            way.popleft()

    def when_ns(self, x_m: float, y_m: float) -> int:
        """When the hand was at this place, on the operator's clock; 0 where nothing is followed.

        Where it passed the place more than once, the time counts that is as late as the one before; where it was never
        near, the newest.
        """
        way = self._way
        if not way:
            return 0
        times_ns, away_m = _nearest(np.array(way), x_m, y_m)
        before, after = np.concatenate(([np.inf], away_m[:-1])), np.concatenate((away_m[1:], [np.inf]))
        passes_ns = times_ns[(away_m <= NEAR_M) & (away_m <= before) & (away_m < after)]
        newest_ns = way[-1].time_ns
        if not passes_ns.size:
            return newest_ns
        late_ns = newest_ns - way[0].time_ns - passes_ns
        found = int(np.argmin(np.abs(late_ns - self._late_ns)))
        self._late_ns = float(late_ns[found])
        return newest_ns - round(self._late_ns)


def _nearest(way: Floats, x_m: float, y_m: float) -> tuple[Floats, Floats]:
    """Each piece of the way: when it is nearest to the place, ns since its start, and how near that is, m."""
    times_ns = way[:, 0] - way[0, 0]
    if len(way) == 1:
        return times_ns, np.hypot(way[:, 1] - x_m, way[:, 2] - y_m)
    step = np.diff(way[:, 1:], axis=0)
    to_place = (x_m, y_m) - way[:-1, 1:]
    square = (step * step).sum(axis=1)
    part = np.clip((to_place * step).sum(axis=1) / np.maximum(square, 1e-18), 0.0, 1.0)
    missed = to_place - part[:, None] * step
    return times_ns[:-1] + part * np.diff(times_ns), np.hypot(missed[:, 0], missed[:, 1])
