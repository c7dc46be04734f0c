"""Where the operator's hand was, and when: the way that the telemanipulator follows.

A groove belongs to the moment at which the operator's hand was over it. The telemanipulator is late by the network's
delay, by its jitter and by its own lag; by the place alone that moment is found whatever they are.
"""

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from common.recording.recorded_row import Whole

Floats = NDArray[np.float64]

KEPT_S = 0.6
"""Longer than a link may be late."""
MOST = 1024
"""Places that are kept: more than the fastest loop takes in KEPT_S, whatever times an operator states."""
NEAR_M = 0.5e-3
"""The hand was at a place when its way passes it at this distance or less: the telemanipulator cuts corners."""


class HandPlace(NamedTuple):
    """What a motion packet says of the hand: its source time on the operator's clock, and the place, m."""

    time_ns: Whole
    x_m: float
    y_m: float


class HandPath:
    """The way of the last KEPT_S, MOST places of it at most."""

    def __init__(self) -> None:
        self._rows: Floats = np.empty((2 * MOST, 3))
        """Time, ns, and place, m, oldest first; those before `_first` have been given up."""
        self._first = self._count = 0
        self._newest: HandPlace | None = None
        self._late_ns = 0.0

    def step(self, hand: HandPlace | None) -> None:
        """Take what is followed now, the same for as long as there is nothing newer; None where nothing is."""
        newest = self._newest
        if hand is None or (newest is not None and hand.time_ns < newest.time_ns):
            self._first = self._count = 0
            self._newest, self._late_ns = None, 0.0
        if hand is None or (newest is not None and hand.time_ns == newest.time_ns):
            return
        rows = self._rows
        if self._count == len(rows):
            rows[:MOST] = rows[MOST:]
            self._first, self._count = max(0, self._first - MOST), MOST
        rows[self._count] = self._newest = hand
        self._count += 1
        self._first = max(self._first, self._count - MOST)
        while hand.time_ns - rows[self._first, 0] > KEPT_S * 1e9:
            self._first += 1

    def when_ns(self, x_m: float, y_m: float) -> int:
        """When the hand was at this place, on the operator's clock; 0 where nothing is followed.

        Where it passed the place more than once, the time counts that is as late as the one before; where it was never
        near, the newest.
        """
        if self._newest is None:
            return 0
        way = self._rows[self._first : self._count]
        times_ns, away_m = _nearest(way, x_m, y_m)
        before, after = np.concatenate(([np.inf], away_m[:-1])), np.concatenate((away_m[1:], [np.inf]))
        passes_ns = times_ns[(away_m <= NEAR_M) & (away_m <= before) & (away_m < after)]
        newest_ns = self._newest.time_ns
        if not passes_ns.size:
            return newest_ns
        late_ns = newest_ns - way[0, 0] - passes_ns
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
