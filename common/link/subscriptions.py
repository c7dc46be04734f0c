"""Bounds the memory that readers of a PUB socket can make it use: a proper reader subscribes once, to everything.

The library stores a node for every byte of every subscription, without a limit. A reader with a trusted key made a
remote site grow by 20 MiB a second. The number of bytes received on each connection identifies the reader.
"""

import logging
from dataclasses import dataclass

import zmq

from common.link.curve import end_strange_readers, subscriptions

log = logging.getLogger(__name__)


@dataclass(slots=True)
class Subscriptions:
    """Checks one bound PUB socket.

    Attributes:
        socket: the socket.
        local_port: port that the socket is bound to.
        ended: number of connections that were ended.
    """

    socket: "zmq.Socket[bytes]"
    local_port: int
    ended: int = 0
    _known: int = 1

    def step(self) -> None:
        """End connections of readers with excess subscriptions when the socket's number of subscriptions has grown."""
        count = subscriptions(self.socket)
        if count > self._known and (ended := end_strange_readers(self.local_port)):
            if not self.ended:
                log.warning("ended a connection to port %d: its reader subscribes repeatedly", self.local_port)
            self.ended += ended
        self._known = max(1, count)
