"""Selects the connection of the session's operator, one for each stream, because a copy of its key may be in use.

Authority comes from the key that was admitted to the session. A second connection with that key is either a new
connection of the operator, or a peer with a copy of the key. It takes a stream over when the first connection is
closed, or is silent on a stream that never pauses. Until then its packets have no effect. If the first connection
sends a motion after the second one was received, two senders use the key.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from common.limits import GAP_S
from common.link.curve import Received, Sender
from common.wire.streams import STREAMS

SILENT_S: Mapping[str, float] = {"motion": GAP_S, "heartbeat": 5.0 / STREAMS["heartbeat"].rate_hz, "control": math.inf}
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
        self._rival: _Line | None = None

    def begin(self, hello: Sender, now_ns: int) -> None:
        """Begin a session; the connection of its hello's sender owns the stream of requests."""
        self._lines = {"control": _Line(hello, now_ns)}
        self._rival = None

    def end(self) -> None:
        """End the session."""
        self._lines.clear()
        self._rival = None

    @property
    def answers_to(self) -> bytes:
        """Routing identity for answers to the operator; empty without a session."""
        line = self._lines.get("control")
        return b"" if line is None else line.sender.who

    def own(self, stream: str, sender: Sender, now_ns: int) -> bool:
        """Return whether a packet with the operator's key came on the connection that owns this stream."""
        line = self._lines.get(stream)
        if line is None:
            self._lines[stream] = _Line(sender, now_ns)
            return True
        if line.sender.connection != sender.connection:
            silent = now_ns - line.heard_ns > SILENT_S[stream] * 1e9
            if not silent and self._is_open(stream, line.sender.connection):
                if stream == "motion" and (self._rival is None or self._rival.sender.connection != sender.connection):
                    self._rival = _Line(sender, now_ns)
                return False
            if stream == "motion":
                self._rival = None
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

    def used_twice(self, sent_ns: int) -> Sender | None:
        """Return the second sender with the operator's key, if a motion of the first proves a second sender.

        Args:
            sent_ns: earliest time at which the operator's own connection sent its motion, ns of this site's clock.
        """
        rival = self._rival
        if rival is None or sent_ns <= rival.heard_ns:
            return None
        self._rival = None
        return rival.sender
