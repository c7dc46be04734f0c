"""One direction of one TCP connection on a network: bytes in with a time, bytes out when they are due.

TCP never loses bytes and never changes their order. What a network does to its segments shows itself as time: a lost
segment holds back everything behind it until it is sent again. Acknowledgements, congestion control and the handshake
of a new connection are not modelled.
"""

from collections import deque
from dataclasses import dataclass, field
from random import Random

from sim_sensors.network_conditions import Conditions
from sim_sensors.network_path import NetworkPath

SEGMENT_BYTES = 1448
"""Payload of a full TCP segment on Ethernet."""
WINDOW_BYTES = 1024 * 1024
"""What one connection may have on its way in one direction; then its sender is held back."""
JITTER_EVERY_S = 0.02
"""The deviation from the mean delay is drawn anew this often and changes linearly in between: a burst on a radio link
lasts about as long."""


@dataclass(slots=True)
class _Segment:
    data: bytes
    sent_s: float
    due_s: float
    wait_s: float
    """Until it is sent again, if it does not arrive."""


@dataclass(slots=True)
class Carried:
    """What was carried so far, by any number of streams.

    Attributes:
        bytes: delivered.
        retransmitted: how often a segment had to be sent again.
        longest_s: the longest time that a segment took.
    """

    bytes: int = 0
    retransmitted: int = 0
    longest_s: float = 0.0


@dataclass(slots=True)
class TcpStream:
    """Bytes on their way. Seeded, and exact in whatever steps time is given; time never runs backwards.

    Attributes:
        path: what the bytes go through.
        random: of this stream alone.
        carried: counts what arrives.
        in_flight: bytes on their way.
        ended: the end of the stream has arrived behind its last byte.
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
        """Return what has arrived by now."""
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
        """Lose everything on the way and everything still to come, and tell nobody."""
        self._vanishing = True
        self._segments.clear()
        self.in_flight = 0

    def full(self, now_s: float) -> bool:
        """Whether the sender has to wait."""
        return not self._vanishing and (self.in_flight >= WINDOW_BYTES or self.path.congested(now_s))

    def _arrive(self, arrival_s: float, arrived: list[bytes]) -> None:
        # What was held back by the first segment comes with it: TCP has sent it by then, again if need be.
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
