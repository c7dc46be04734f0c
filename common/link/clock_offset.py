"""Estimates the offset between two hosts' monotonic clocks, with its uncertainty, from four timestamps."""

import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field

WINDOW = 64
DRIFT = 100e-6
"""Maximum relative drift of two quartz clocks, s/s; it widens the uncertainty of an old measurement."""

ReadClock = Callable[[], int]
"""Reads a site's clock, ns, to stamp heartbeats when they are read. A tick may begin long before a packet that it reads
arrives, and only a time after the arrival bounds the offset. Without it, the tick's own time is used."""


@dataclass(slots=True)
class ClockOffset:
    """Estimates (far clock - own clock) in ns; the true offset is within `uncertainty_ns` of the estimate.

    A round trip t1 -> t2, t3 -> t4 bounds the offset by half its network time on either side. This holds for any
    asymmetry of the two ways. The tightest recent bound is kept and widened by the drift since.
    """

    offset_ns: int = 0
    uncertainty_ns: int | None = None
    round_trip_ns: int = 0
    steps: int = 0
    """Number of clock steps found: measurements that contradict all earlier ones."""
    _samples: deque[tuple[int, int, int]] = field(default_factory=lambda: deque(maxlen=WINDOW))

    def add(self, t1_ns: int, t2_ns: int, t3_ns: int, t4_ns: int) -> None:
        """Take one round trip: sent and received here (t1, t4), received and answered there (t2, t3), ns.

        Raises:
            ValueError: the times run backwards.
        """
        round_trip = (t4_ns - t1_ns) - (t3_ns - t2_ns)
        if t4_ns < t1_ns or t3_ns < t2_ns or round_trip < 0:
            raise ValueError(f"impossible round trip {t1_ns}, {t2_ns}, {t3_ns}, {t4_ns}")
        self.round_trip_ns = round_trip
        sample = (t1_ns, ((t2_ns - t1_ns) + (t3_ns - t4_ns)) // 2, round_trip // 2)
        if self._contradicts(sample, t4_ns):
            # Both bounds hold for one pair of clocks, so one clock was stepped: earlier samples are invalid.
            self._samples.clear()
            self.steps += 1
        self._samples.append(sample)
        sent_ns, self.offset_ns, bound = min(self._samples, key=lambda s: s[2] + DRIFT * (t4_ns - s[0]))
        self.uncertainty_ns = bound + math.ceil(DRIFT * (t4_ns - sent_ns)) + 1

    def _contradicts(self, sample: tuple[int, int, int], now_ns: int) -> bool:
        """Return whether a clock was stepped: the ranges of this and the best measurement do not overlap."""
        if self.uncertainty_ns is None or not self._samples:
            return False
        _, offset_ns, bound_ns = sample
        since_ns = now_ns - self._samples[-1][0]
        drifted_ns = math.ceil(DRIFT * since_ns) + 2
        return since_ns < 0 or abs(offset_ns - self.offset_ns) > bound_ns + self.uncertainty_ns + drifted_ns
