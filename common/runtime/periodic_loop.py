"""A periodic loop on absolute monotonic deadlines, with statistics of its lateness."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np

_BUCKETS_US = np.concatenate(([0.0], np.geomspace(1.0, 1e6, 241)))


@dataclass(slots=True)
class PeriodicLoop:
    """Sleeps until the next deadline; after a stall it skips the missed ticks.

    The clock and the sleep are arguments, so that tests run without waiting.
    """

    period_s: float
    now: Callable[[], float] = time.monotonic
    sleep: Callable[[float], None] = time.sleep
    ticks: int = 0
    overruns: int = 0
    """Number of ticks that came more than one period late."""
    missed: int = 0
    """Number of deadlines that passed without a tick."""
    late_max_s: float = 0.0
    _deadline: float = field(init=False)
    _histogram: np.ndarray[tuple[int], np.dtype[np.int64]] = field(init=False)

    def __post_init__(self) -> None:
        self._deadline = self.now() + self.period_s
        self._histogram = np.zeros(len(_BUCKETS_US), dtype=np.int64)

    def wait(self) -> float:
        """Sleep until the next deadline; return how late this tick is, s."""
        remaining = self._deadline - self.now()
        if remaining > 0.0:
            self.sleep(remaining)
        now = self.now()
        late = max(0.0, now - self._deadline)
        gone = int(late / self.period_s)
        if gone:
            self.overruns += 1
            self.missed += gone
        # Missed ticks are skipped. The grid of deadlines stays, so that devices and sites keep their phases.
        self._deadline += (1 + gone) * self.period_s
        self.ticks += 1
        self.late_max_s = max(self.late_max_s, late)
        self._histogram[int(np.searchsorted(_BUCKETS_US, late * 1e6, side="right")) - 1] += 1
        return late

    def late_us(self, quantile: float) -> float:
        """Return lateness at a quantile (0..1), us, within the histogram's 6 % buckets; 0 before the first tick."""
        if not self.ticks:
            return 0.0
        bucket = int(np.searchsorted(np.cumsum(self._histogram), quantile * self.ticks))
        return float(_BUCKETS_US[min(bucket, len(_BUCKETS_US) - 1)])
