"""Which received packets may be acted on: session, sequence, age and future, each refusal counted."""

from collections import Counter
from dataclasses import dataclass, field
from typing import Protocol

FUTURE_TOLERANCE_NS = 5_000_000
"""A packet may seem this much younger than now, beyond the clock's own uncertainty, ns."""

MOST_AHEAD = 10_000
"""A session does not outlive the silence in which so many packets could be lost: a sequence number further ahead is a
sender's error, and believing it would refuse all that follow."""


class Stamped(Protocol):
    """A packet with the common header."""

    @property
    def session(self) -> int:
        """Session that the packet belongs to."""

    @property
    def sequence(self) -> int:
        """Number of the packet in its stream."""

    @property
    def time_ns(self) -> int:
        """Source time on the sender's clock."""


@dataclass(slots=True)
class PacketFilter:
    """Judges the packets of one stream. Time is an argument: the receiver's monotonic clock, ns."""

    max_age_ns: int
    received: int = 0
    lost: int = 0
    """Sequence numbers that never came: superseded on the way, or lost."""
    refused: Counter[str] = field(default_factory=Counter)
    latest_refusal: str = ""
    """Why the newest packet that was judged was refused; empty when it was accepted."""
    last_ns: int | None = None
    """When the last packet was accepted."""
    age_ns: int = 0
    """Age of the last accepted packet when it was accepted."""
    _sequence: int = -1

    def accept(self, packet: Stamped, session: int, now_ns: int, offset_ns: int, uncertainty_ns: int | None) -> bool:
        """Judge one decoded packet.

        Args:
            packet: what arrived.
            session: the session that this side is in.
            now_ns: this side's clock.
            offset_ns: the sender's clock minus this side's.
            uncertainty_ns: of the offset; None while it is unknown. Until the clocks have been compared well enough to
                tell a packet of the allowed age from a fresh one, nothing is accepted.
        """
        ahead = packet.sequence - self._sequence
        age_ns = now_ns - (packet.time_ns - offset_ns)
        if packet.session != session:
            return self._refuse("session")
        if ahead <= 0 or (self._sequence >= 0 and ahead > MOST_AHEAD):  # who joins late begins anywhere
            return self._refuse("sequence")
        if uncertainty_ns is None or uncertainty_ns > self.max_age_ns:
            return self._refuse("clock")
        if age_ns > self.max_age_ns:
            return self._refuse("age")
        if age_ns < -(uncertainty_ns + FUTURE_TOLERANCE_NS):
            return self._refuse("future")
        if self._sequence >= 0:
            self.lost += ahead - 1
        self._sequence = packet.sequence
        self.last_ns = now_ns
        self.age_ns = age_ns
        self.received += 1
        self.latest_refusal = ""
        return True

    def _refuse(self, reason: str) -> bool:
        self.refused[reason] += 1
        self.latest_refusal = reason
        return False

    def gap_ns(self, now_ns: int) -> int | None:
        """Time since the last accepted packet; None when there was none in this session."""
        return None if self.last_ns is None else now_ns - self.last_ns

    def restart(self) -> None:
        """Begin a new session: the sequence starts again, nothing was accepted yet."""
        self._sequence = -1
        self.last_ns = None
        self.latest_refusal = ""
