"""Keeps the last ten seconds of 25 signals as minimum and maximum of each bin, so that every peak is visible."""

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from common.fingers import FINGERS

SIGNALS = ("force_n", "contact_n", "motor_hz", "plate_c", "skin_c")
"""Signals of each finger."""
SPAN_S = 1.0 / 30.0
"""Time that one bin covers, s; bin n begins at n SPAN_S."""
BINS = 300
"""Number of bins that are kept."""
LATE_S = 0.2
"""Longest wait for a silent feed, s; later the bins advance without it."""

Block = NDArray[np.float32]


class Signals:
    """A ring of bins. Pure: time is an argument, s."""

    def __init__(self) -> None:
        self._low: Block = np.full((BINS, len(SIGNALS), len(FINGERS)), np.nan, dtype=np.float32)
        self._high = self._low.copy()
        self._bin: int | None = None
        self._newest_s = -math.inf

    def take(self, t_s: float, first: str, values: Sequence[Sequence[float]]) -> None:
        """Take the values of all fingers for consecutive signals from `first` on; NaN stands for no value."""
        number = math.floor(t_s / SPAN_S)
        self._advance(number)
        self._newest_s = t_s
        at = SIGNALS.index(first)
        block = np.array(values, dtype=np.float32)
        slot = number % BINS, slice(at, at + len(block))
        np.fmin(self._low[slot], block, out=self._low[slot])
        np.fmax(self._high[slot], block, out=self._high[slot])

    def newest_bin(self, now_s: float) -> int:
        """Return the newest complete bin: it has ended, and later values have followed or the feed is silent."""
        ended = math.floor(now_s / SPAN_S) - 1
        if now_s - self._newest_s > LATE_S:
            return ended
        return min(ended, math.floor(self._newest_s / SPAN_S) - 1)

    def bins(self, newest: int, count: int) -> Block:
        """Return minimum and maximum of the bins up to `newest`, (count, 25, 2), fingers major; NaN without values."""
        numbers = np.arange(newest - count + 1, newest + 1)
        found = np.full((count, len(FINGERS) * len(SIGNALS), 2), np.nan, dtype=np.float32)
        if self._bin is not None:
            kept = (numbers <= self._bin) & (numbers > self._bin - BINS)
            slots = numbers[kept] % BINS
            for side, ring in enumerate((self._low, self._high)):
                found[kept, :, side] = ring[slots].transpose(0, 2, 1).reshape(len(slots), found.shape[1])
        return found

    def _advance(self, number: int) -> None:
        """Make room up to a bin; a clock that was set back or far ahead empties all bins."""
        if self._bin is None or not -1 <= number - self._bin <= BINS:
            self._low[:] = self._high[:] = np.nan
            self._bin = number
        for empty in range(self._bin + 1, number + 1):
            self._low[empty % BINS] = self._high[empty % BINS] = np.nan
        self._bin = max(self._bin, number)
