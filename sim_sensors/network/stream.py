"""Model one direction of a TCP connection on a network: bytes enter with a time and leave when they are due.

TCP never loses bytes and never changes their order, so the network's effect is delay. A lost segment holds back
everything behind it until it is retransmitted. The sender retransmits when acknowledgements of later segments show the
loss (RFC 8985, section 6.2), or after a time-out (RFC 6298). Lost acknowledgements, congestion control and the
handshake of a new connection are not modelled.
"""

import math
from collections import deque
from dataclasses import dataclass, field
from itertools import islice
from random import Random

from sim_sensors.network.conditions import Conditions
from sim_sensors.network.path import NetworkPath

SEGMENT_BYTES = 1448
"""Payload of a full TCP segment on Ethernet."""
WINDOW_BYTES = 1024 * 1024
"""Largest number of bytes of one connection in flight in one direction; at this number, the sender waits."""
LATER_SEGMENTS = 3
"""Number of acknowledged later segments at which the sender retransmits at once."""
REORDERING = 0.25
"""Share of a round trip for which the sender waits after the first of them, because order may have changed."""
JITTER_EVERY_S = 0.02
"""Interval between draws of the deviation from the mean delay, s; the deviation is linear in between. A burst on a
radio link lasts about as long."""


@dataclass(slots=True)
class _Segment:
    """A segment.

    Attributes:
        data: its bytes.
        sent_s: time at which it was first sent, s.
        tried_s: time of the last try, s.
        due_s: arrival of the last try, s.
        luck: random number of the last try, 0 to 1; below the share of losses, the segment is lost.
        timeout_s: time-out of the last try, s.
        missing: whether the last try was lost.
        timed_out: whether the last try came after a time-out.
    """

    data: bytes
    sent_s: float
    tried_s: float
    due_s: float
    luck: float
    timeout_s: float
    missing: bool = False
    timed_out: bool = False


@dataclass(slots=True)
class Carried:
    """Traffic so far, of any number of streams.

    Attributes:
        bytes: bytes delivered.
        retransmitted: number of retransmissions.
        longest_s: longest time that a segment took, s.
    """

    bytes: int = 0
    retransmitted: int = 0
    longest_s: float = 0.0


@dataclass(slots=True)
class TcpStream:
    """Bytes in flight. The result is seeded and independent of the time steps; time never runs backwards.

    Attributes:
        path: network path of the bytes.
        random: random numbers of this stream alone. A further generator decides on retransmissions, so that they change
            no other number.
        carried: counts of the bytes that arrive.
        in_flight: number of bytes in flight.
        ended: whether the end of the stream has arrived behind its last byte.
    """

    path: NetworkPath
    random: Random
    carried: Carried = field(default_factory=Carried)
    in_flight: int = 0
    ended: bool = False
    _arrived_s: float = -math.inf
    """Time of the last arrival, s."""
    _resent_s: float = -math.inf
    """Time of the last arrival after a time-out, s."""
    _segments: deque[_Segment] = field(default_factory=deque)
    _jitter: tuple[int, float, float] = (-1, 0.0, 0.0)
    """Number of the present span of JITTER_EVERY_S, and the deviations (-1 to 1) at its start and end."""
    _vanishing: bool = False
    _again: Random = field(init=False)

    def __post_init__(self) -> None:
        self._again = Random(self.random.random())

    def push(self, data: bytes, now_s: float) -> None:
        """Send bytes; an empty `data` ends the stream."""
        if self._vanishing:
            return
        conditions = self.path.conditions(now_s)
        for start in range(0, max(1, len(data)), SEGMENT_BYTES):
            part = data[start : start + SEGMENT_BYTES]
            departure_s = self.path.departure_s(len(part), now_s)
            due_s = departure_s + self._delay_s(conditions, now_s)
            luck = self.random.random()
            self._segments.append(_Segment(part, now_s, now_s, due_s, luck, conditions.retransmission_s))
            self.in_flight += len(part)

    def take(self, now_s: float) -> bytes:
        """Return the bytes that have arrived since the last call."""
        arrived: list[bytes] = []
        while self._segments:
            first = self._segments[0]
            if first.due_s > now_s or (first.missing and not self._retransmitted(first, now_s)):
                break
            stalled_until_s = self.path.stalls.end_s(first.due_s)
            if stalled_until_s is not None:
                first.due_s = stalled_until_s
            elif self._lost(first):
                first.missing = True
            else:
                self._arrive(first, arrived)
        return b"".join(arrived)

    def vanish(self) -> None:
        """Silently lose all bytes in flight and all bytes still to come."""
        self._vanishing = True
        self._segments.clear()
        self.in_flight = 0

    def full(self, now_s: float) -> bool:
        """Return whether the sender has to wait."""
        return not self._vanishing and (self.in_flight >= WINDOW_BYTES or self.path.congested(now_s))

    def _arrive(self, segment: _Segment, arrived: list[bytes]) -> None:
        self._segments.popleft()
        self._arrived_s = max(self._arrived_s, segment.due_s)
        if segment.timed_out:
            self._resent_s = self._arrived_s
        arrived.append(segment.data)
        self.in_flight -= len(segment.data)
        self.carried.bytes += len(segment.data)
        self.carried.longest_s = max(self.carried.longest_s, self._arrived_s - segment.sent_s)
        self.ended = not segment.data

    def _lost(self, segment: _Segment) -> bool:
        """Return whether the last try does not arrive.

        When a segment arrives after a time-out, everything behind it has been retransmitted.
        """
        if segment.due_s <= self._resent_s:
            return False
        if self.path.partitions.end_s(segment.due_s) is not None:
            return True
        return segment.luck < self.path.conditions(segment.due_s).loss

    def _retransmitted(self, segment: _Segment, now_s: float) -> bool:
        """Try a missing segment again; return False if that try cannot arrive by now."""
        shown_s, timeout_s = self._shown_s(segment), segment.tried_s + segment.timeout_s
        tried_s = min(shown_s, timeout_s)
        due_s = tried_s + self.path.conditions(segment.due_s).delay_s
        if due_s > now_s:
            return False
        segment.timed_out = timeout_s <= shown_s
        if segment.timed_out:
            segment.timeout_s *= 2.0
        segment.tried_s, segment.due_s = tried_s, due_s
        segment.luck, segment.missing = self._again.random(), False
        self.carried.retransmitted += 1
        return True

    def _shown_s(self, segment: _Segment) -> float:
        """Return when acknowledgements of later segments show a loss, s; infinity if there are none yet.

        After a time-out, the sender sends nothing new before the missing segment has arrived.
        """
        if segment.timed_out:
            return math.inf
        delay_s = self.path.conditions(segment.due_s).delay_s
        later = (s for s in islice(self._segments, 1, None) if s.sent_s >= segment.tried_s and not self._lost(s))
        known_s = [each.due_s + delay_s for each in islice(later, LATER_SEGMENTS)]
        if not known_s:
            return math.inf
        shown_s = max(known_s[0], segment.tried_s + (1.0 + REORDERING) * 2.0 * delay_s)
        return min(shown_s, known_s[-1]) if len(known_s) == LATER_SEGMENTS else shown_s

    def _delay_s(self, conditions: Conditions, now_s: float) -> float:
        if not conditions.jitter_s:
            return conditions.delay_s
        span, fraction = divmod(now_s / JITTER_EVERY_S, 1.0)
        number, start, end = self._jitter
        if int(span) != number:
            start = end if int(span) == number + 1 else self.random.uniform(-1.0, 1.0)
            end = self.random.uniform(-1.0, 1.0)
            self._jitter = (int(span), start, end)
        return conditions.delay_s + conditions.jitter_s * (start + fraction * (end - start))
