"""Model one direction of a TCP connection on a network: bytes enter with a time and leave when they are due.

TCP never loses bytes and never changes their order, so the network's effect is delay. A lost segment holds back
everything behind it until it is retransmitted. Acknowledgements, congestion control and the handshake of a new
connection are not modelled.
"""

from collections import deque
from dataclasses import dataclass, field
from random import Random

from sim_sensors.network.conditions import Conditions
from sim_sensors.network.path import NetworkPath

SEGMENT_BYTES = 1448
"""Payload of a full TCP segment on Ethernet."""
WINDOW_BYTES = 1024 * 1024
"""Largest number of bytes of one connection in flight in one direction; at this number, the sender waits."""
JITTER_EVERY_S = 0.02
"""Interval between draws of the deviation from the mean delay, s; the deviation is linear in between. A burst on a
radio link lasts about as long."""


@dataclass(slots=True)
class _Segment:
    data: bytes
    sent_s: float
    due_s: float
    wait_s: float
    """Time until it is retransmitted if it is lost, s."""


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
        random: random numbers of this stream alone.
        carried: counts of the bytes that arrive.
        in_flight: number of bytes in flight.
        ended: whether the end of the stream has arrived behind its last byte.
    """

    path: NetworkPath
    random: Random
    carried: Carried = field(default_factory=Carried)
    in_flight: int = 0
    ended: bool = False
    _segments: deque[_Segment] = field(default_factory=deque)
    _jitter: tuple[int, float, float] = (-1, 0.0, 0.0)
    """Number of the present span of JITTER_EVERY_S, and the deviations (-1 to 1) at its start and end."""
    _vanishing: bool = False

    def push(self, data: bytes, now_s: float) -> None:
        """Send bytes; an empty `data` ends the stream."""
        if self._vanishing:
            return
        conditions = self.path.conditions(now_s)
        for start in range(0, max(1, len(data)), SEGMENT_BYTES):
            part = data[start : start + SEGMENT_BYTES]
            departure_s = self.path.departure_s(len(part), now_s)
            due_s = departure_s + self._delay_s(conditions, now_s)
            self._segments.append(_Segment(part, now_s, due_s, conditions.retransmission_s))
            self.in_flight += len(part)

    def take(self, now_s: float) -> bytes:
        """Return the bytes that have arrived since the last call."""
        arrived: list[bytes] = []
        while self._segments and (first := self._segments[0]).due_s <= now_s:
            stalled_until_s = self.path.stalls.end_s(first.due_s)
            if stalled_until_s is not None:
                first.due_s = stalled_until_s
            elif self._lost(first.due_s):
                first.due_s += first.wait_s
                first.wait_s *= 2.0
                self.carried.retransmitted += 1
            else:
                self._arrive(first.due_s, arrived)
        return b"".join(arrived)

    def vanish(self) -> None:
        """Silently lose all bytes in flight and all bytes still to come."""
        self._vanishing = True
        self._segments.clear()
        self.in_flight = 0

    def full(self, now_s: float) -> bool:
        """Return whether the sender has to wait."""
        return not self._vanishing and (self.in_flight >= WINDOW_BYTES or self.path.congested(now_s))

    def _arrive(self, arrival_s: float, arrived: list[bytes]) -> None:
        # The segments held back by the first one arrive with it: TCP has sent or retransmitted them by then.
        while self._segments and self._segments[0].due_s <= arrival_s:
            segment = self._segments.popleft()
            arrived.append(segment.data)
            self.in_flight -= len(segment.data)
            self.carried.bytes += len(segment.data)
            self.carried.longest_s = max(self.carried.longest_s, arrival_s - segment.sent_s)
            self.ended = not segment.data

    def _lost(self, time_s: float) -> bool:
        if self.path.partitions.end_s(time_s) is not None:
            return True
        loss = self.path.conditions(time_s).loss
        return loss > 0.0 and self.random.random() < loss

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
