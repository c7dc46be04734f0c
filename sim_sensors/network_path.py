"""One direction of a network, shared by all connections through it."""

import math
from collections.abc import Callable
from dataclasses import dataclass, field

from sim_sensors.network_conditions import Conditions

QUEUE_BYTES = 64 * 1024
"""What may wait for a slow line to carry it; after that the senders are held back."""


@dataclass(slots=True)
class Outages:
    """Spans of time in which something does not work."""

    _spans: list[tuple[float, float]] = field(default_factory=list)

    def add(self, start_s: float, seconds: float) -> None:
        """Let it not work from `start_s` on."""
        self._spans.append((start_s, start_s + seconds))

    def end_s(self, time_s: float) -> float | None:
        """When what does not work at `time_s` works again; None when it works then."""
        return max((end for start, end in self._spans if start <= time_s < end), default=None)

    def end_all(self, now_s: float) -> None:
        """Let it work again from now on."""
        self._spans = [(start, min(end, now_s)) for start, end in self._spans if start < now_s]


class NetworkPath:
    """What bytes of all connections meet on their way. Time is an argument, s, and never runs backwards.

    Attributes:
        conditions: what it is like at a time.
        stalls: while one lasts everything is late.
        partitions: while one lasts nothing arrives.
    """

    def __init__(self, conditions: Callable[[float], Conditions]) -> None:
        self.conditions = conditions
        self.stalls = Outages()
        self.partitions = Outages()
        self._rate_bit_s = math.inf
        self._free_s = -math.inf

    def departure_s(self, size: int, now_s: float) -> float:
        """When the last of `size` bytes that are sent now has left, behind all that is waiting already."""
        self._rate_bit_s = self.conditions(now_s).rate_bit_s
        self._free_s = max(now_s, self._free_s) + 8.0 * size / self._rate_bit_s
        return self._free_s

    def congested(self, now_s: float) -> bool:
        """Whether so much is waiting to leave that nobody may send more."""
        waiting_s = self._free_s - now_s
        return waiting_s > 0.0 and waiting_s * self._rate_bit_s > 8.0 * QUEUE_BYTES
