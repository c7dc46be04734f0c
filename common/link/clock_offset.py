"""Offset between two hosts' monotonic clocks, with its uncertainty, from four timestamps."""

import math
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field

WINDOW = 64
DRIFT = 100e-6
"""Two quartz clocks drift apart by at most this much, s/s: an old measurement is worth less."""

ReadClock = Callable[[], int]
"""A site's clock at the moment of asking, ns, to stamp heartbeats when they are read. A tick may begin long before a
packet that it finds came in: only a time read after that bounds the offset. Without, the tick's own time is taken."""


@dataclass(slots=True)
class ClockOffset:
    """Estimates (far clock - own clock) in ns; the true offset lies within `uncertainty_ns` of it.

    A round trip t1 -> t2, t3 -> t4 bounds the offset by half its network time on either side,
    whatever the asymmetry of the two ways. The tightest recent bound is kept, widened by the drift since.
    """

    offset_ns: int = 0
    uncertainty_ns: int | None = None
    round_trip_ns: int = 0
    steps: int = 0
    """How often a clock was stepped: a measurement contradicted all that was known."""
    _samples: deque[tuple[int, int, int]] = field(default_factory=lambda: deque(maxlen=WINDOW))

    def add(self, t1_ns: int, t2_ns: int, t3_ns: int, t4_ns: int) -> None:
        """Take one round trip: sent and received here (t1, t4), received and answered there (t2, t3).

        Raises:
            ValueError: the times run backwards, so they are no round trip.
        """
        round_trip = (t4_ns - t1_ns) - (t3_ns - t2_ns)
        if t4_ns < t1_ns or t3_ns < t2_ns or round_trip < 0:
            raise ValueError(f"impossible round trip {t1_ns}, {t2_ns}, {t3_ns}, {t4_ns}")
        self.round_trip_ns = round_trip
        sample = (t1_ns, ((t2_ns - t1_ns) + (t3_ns - t4_ns)) // 2, round_trip // 2)
        if self._contradicts(sample, t4_ns):
            # Both bounds hold for one pair of clocks, so one was stepped: what came before is worth nothing.
            self._samples.clear()
            self.steps += 1
        self._samples.append(sample)
        sent_ns, self.offset_ns, bound = min(self._samples, key=lambda s: s[2] + DRIFT * (t4_ns - s[0]))
        self.uncertainty_ns = bound + math.ceil(DRIFT * (t4_ns - sent_ns)) + 1

    def _contradicts(self, sample: tuple[int, int, int], now_ns: int) -> bool:
        """Whether the ranges that this measurement and the best known one allow do not even touch."""
        if self.uncertainty_ns is None or not self._samples:
            return False
        _, offset_ns, bound_ns = sample
        drifted_ns = math.ceil(DRIFT * abs(now_ns - self._samples[-1][0])) + 2
        return abs(offset_ns - self.offset_ns) > bound_ns + self.uncertainty_ns + drifted_ns
