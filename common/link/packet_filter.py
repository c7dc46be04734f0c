"""Accepts or refuses received packets by session, sequence, age and clock; counts each refusal."""

from collections import Counter
from dataclasses import dataclass, field
from typing import Protocol

FUTURE_TOLERANCE_NS = 5_000_000
"""Maximum time that a packet may lie in the future beyond the clock's own uncertainty, ns."""

MOST_AHEAD = 2**26
"""Maximum step of the sequence number: more than a day at 500 Hz. A larger step is a sender's error, or a number by
somebody who does not know the session's first one; after accepting it, all following packets would be refused."""


class Stamped(Protocol):
    """A packet with the common header."""

    @property
    def session(self) -> int:
        """Session of the packet."""

    @property
    def sequence(self) -> int:
        """Number of the packet in its stream."""

    @property
    def time_ns(self) -> int:
        """Source time on the sender's clock."""


@dataclass(slots=True)
class PacketFilter:
    """Filters the packets of one stream. Time is an argument: the receiver's monotonic clock, ns."""

    max_age_ns: int
    received: int = 0
    lost: int = 0
    """Number of sequence numbers without a packet: superseded on the way, or lost."""
    overtaken: int = 0
    """Number of packets that came after a newer one, as the copies on a second connection do; they are not refusals."""
    overtaken_ns: int | None = None
    """Time of the last such packet in this session, ns; None before the first."""
    refused: Counter[str] = field(default_factory=Counter)
    latest_refusal: str = ""
    """Reason for refusing the newest packet; empty when it was accepted."""
    refused_ns: int = 0
    """Time of the last refusal, ns."""
    last_ns: int | None = None
    """Time of the last accepted packet, ns; None before the first in this session."""
    age_ns: int = 0
    """Age of the last accepted packet at its acceptance, ns."""
    _first: int = 0
    """Lowest sequence number of the session."""
    _sequence: int = -1
    """The last accepted number, or the one before the first; negative where the first may be any."""

    def accept(self, packet: Stamped, session: int, now_ns: int, offset_ns: int, uncertainty_ns: int | None) -> bool:
        """Judge one decoded packet; return whether it is accepted.

        Args:
            packet: the received packet.
            session: this side's session.
            now_ns: this side's clock, ns.
            offset_ns: the sender's clock minus this side's, ns.
            uncertainty_ns: uncertainty of the offset, ns; None while it is unknown. All packets are refused until it is
                at most the maximum age.
        """
        ahead = packet.sequence - self._sequence
        age_ns = now_ns - (packet.time_ns - offset_ns)
        if packet.session != session:
            return self._refuse("session", now_ns)
        if packet.sequence < self._first or (self._sequence >= 0 and ahead > MOST_AHEAD):
            return self._refuse("sequence", now_ns)
        if ahead <= 0:
            self.overtaken += 1
            self.latest_refusal, self.refused_ns, self.overtaken_ns = "overtaken", now_ns, now_ns
            return False
        if uncertainty_ns is None or uncertainty_ns > self.max_age_ns:
            return self._refuse("clock", now_ns)
        if age_ns > self.max_age_ns:
            return self._refuse("age", now_ns)
        if age_ns < -(uncertainty_ns + FUTURE_TOLERANCE_NS):
            return self._refuse("future", now_ns)
        if self.last_ns is not None:
            self.lost += ahead - 1
        self._sequence = packet.sequence
        self.last_ns = now_ns
        self.age_ns = age_ns
        self.received += 1
        self.latest_refusal = ""
        return True

    def _refuse(self, reason: str, now_ns: int) -> bool:
        self.refused[reason] += 1
        self.latest_refusal, self.refused_ns = reason, now_ns
        return False

    def gap_ns(self, now_ns: int) -> int | None:
        """Return the time since the last accepted packet, ns; None without one in this session."""
        return None if self.last_ns is None else now_ns - self.last_ns

    def restart(self, first: int = 0) -> None:
        """Start a new session: no packet has been accepted.

        Args:
            first: sequence number of its first packet, positive; 0 where this side does not know it.
        """
        self._first, self._sequence = first, first - 1
        self.last_ns = self.overtaken_ns = None
        self.latest_refusal = ""
