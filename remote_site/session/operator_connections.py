"""Selects the operator's connection to each stream of requests, because a copy of its key may be in use.

Authority comes from the key that was admitted to the session. A second connection with that key is either a new
connection of the operator, or a peer with a copy of the key. It takes a stream over when the first connection is
closed, or is silent on a stream that never pauses. Until then its packets have no effect. Motion needs no such rule:
only the operator knows the session's first sequence number.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from common.link.curve import Received, Sender
from common.wire.streams import STREAMS

SILENT_S: Mapping[str, float] = {"heartbeat": 5.0 / STREAMS["heartbeat"].rate_hz, "control": math.inf}
"""Silence after which another connection of the operator's key takes a stream over, s; requests may pause forever."""


@dataclass(slots=True)
class _Line:
    """The connection that owns a stream."""

    sender: Sender
    heard_ns: int


class OperatorConnections:
    """Operator connections of one session server. Time is an argument, ns of this site's monotonic clock."""

    def __init__(self, is_open: Callable[[str, int], bool]):
        """Begin without an operator.

        Args:
            is_open: returns whether a connection, given by stream and number, is still open.
        """
        self._is_open = is_open
        self._lines: dict[str, _Line] = {}

    def begin(self, hello: Sender, now_ns: int) -> None:
        """Begin a session; the connection of its hello's sender owns the stream of requests."""
        self._lines = {"control": _Line(hello, now_ns)}

    @property
    def answers_to(self) -> bytes:
        """Routing identity for answers to the session's operator."""
        return self._lines["control"].sender.who

    def own(self, stream: str, sender: Sender, now_ns: int) -> bool:
        """Return whether a packet with the operator's key came on the connection that owns this stream."""
        line = self._lines.get(stream)
        if line is None:
            self._lines[stream] = _Line(sender, now_ns)
            return True
        if line.sender.connection != sender.connection:
            silent = now_ns - line.heard_ns > SILENT_S[stream] * 1e9
            if not silent and self._is_open(stream, line.sender.connection):
                return False
        line.sender, line.heard_ns = sender, now_ns
        return True

    def own_first(self, stream: str, packets: list[Received]) -> list[Received]:
        """Sort packets so that those of the connection that owns the stream come first, each group in its order.

        After a pause of this site, this keeps another connection from taking the owner for silent.
        """
        line = self._lines.get(stream)
        if line is None or len(packets) < 2:
            return packets
        own = line.sender.connection
        return sorted(packets, key=lambda received: received[0].connection != own)
