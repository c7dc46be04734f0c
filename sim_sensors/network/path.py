"""Model one direction of a network, shared by all connections through it."""

import math
from dataclasses import dataclass, field

from sim_sensors.network.conditions import ConditionsOverTime

QUEUE_BYTES = 64 * 1024
"""Largest queue in front of a slow line, bytes; a longer queue makes the senders wait."""


@dataclass(slots=True)
class Outages:
    """Spans of time with an outage."""

    _spans: list[tuple[float, float]] = field(default_factory=list)

    def add(self, start_s: float, seconds: float) -> None:
        """Add an outage of `seconds` from `start_s` on."""
        self._spans.append((start_s, start_s + seconds))

    def end_s(self, time_s: float) -> float | None:
        """Return the end of the outage at `time_s`, s; None without an outage."""
        return max((end for start, end in self._spans if start <= time_s < end), default=None)

    def end_all(self, now_s: float) -> None:
        """End all outages at `now_s`."""
        self._spans = [(start, min(end, now_s)) for start, end in self._spans if start < now_s]


class NetworkPath:
    """Path of the bytes of all connections. Time is an argument, s, and never runs backwards.

    Attributes:
        conditions: conditions as a function of time.
        stalls: outages that delay everything.
        partitions: outages in which nothing arrives.
    """

    def __init__(self, conditions: ConditionsOverTime) -> None:
        self.conditions = conditions
        self.stalls = Outages()
        self.partitions = Outages()
        self._rate_bit_s = math.inf
        self._free_s = -math.inf

    def departure_s(self, size: int, now_s: float) -> float:
        """Queue `size` bytes behind all that wait already; return the time at which the last byte has left, s."""
        self._rate_bit_s = self.conditions(now_s).rate_bit_s
        self._free_s = max(now_s, self._free_s) + 8.0 * size / self._rate_bit_s
        return self._free_s

    def congested(self, now_s: float) -> bool:
        """Return whether the queue is full, so that senders must wait."""
        waiting_s = self._free_s - now_s
        return waiting_s > 0.0 and waiting_s * self._rate_bit_s > 8.0 * QUEUE_BYTES
