"""Bounds the memory of a message without an end: the library keeps its parts until the last one has arrived.

Neither the size of a part nor the length of a queue bounds it. One trusted key made a remote site grow by 90 MiB a
second.
"""

import logging
from collections.abc import Iterable

from common.link.curve import Received
from common.link.tcp_connections import end_sockets, received_bytes, socket_of

log = logging.getLogger(__name__)

_MOST_BYTES = 1 << 20
"""Maximum number of bytes that a connection sends without a packet; a full queue of packets has 0.4 MB."""


class EndlessMessages:
    """Checks the connections of one bound socket.

    Attributes:
        ended: number of connections that were ended.
    """

    def __init__(self, local_port: int) -> None:
        """Check the socket that is bound to `local_port`."""
        self.ended = 0
        self._local_port = local_port
        self._heard: set[int] = set()
        self._received: dict[int, int] = {}
        """Bytes that each socket had received with its last packet."""

    def heard(self, packets: Iterable[Received]) -> None:
        """Note the connections of packets that were read."""
        self._heard.update(socket_of(sender.connection) for sender, _ in packets)

    def step(self) -> None:
        """End connections that have sent too much since their last packet; called about once a second."""
        received = received_bytes(self._local_port)
        before, heard = self._received, self._heard
        self._received = {each: sent if each in heard else before.get(each, 0) for each, sent in received.items()}
        self._heard = set()
        endless = {each for each, sent in received.items() if sent - self._received[each] > _MOST_BYTES}
        if endless:
            end_sockets(self._local_port, endless)
            if not self.ended:
                log.warning("ended a connection to port %d: its message has no end", self._local_port)
            self.ended += len(endless)
