"""Bounds what the readers of a PUB socket can make it remember: an honest reader subscribes once, to everything.

The library keeps a node for every byte of every subscription, and asks nobody. A reader with a trusted key made a
remote site grow by 20 MiB a second. Which reader it was, the bytes of its connection say.
"""

import logging
from dataclasses import dataclass

import zmq

from common.link.curve import end_strange_readers, subscriptions

log = logging.getLogger(__name__)


@dataclass(slots=True)
class Subscriptions:
    """Belongs to one bound PUB socket.

    Attributes:
        socket: what is watched.
        local_port: port that it is bound to.
        ended: connections that were ended.
    """

    socket: "zmq.Socket[bytes]"
    local_port: int
    ended: int = 0
    _known: int = 1

    def step(self) -> None:
        """End the connections of readers that subscribed to more, where the socket remembers more than before."""
        count = subscriptions(self.socket)
        if count > self._known and (ended := end_strange_readers(self.local_port)):
            if not self.ended:
                log.warning("ended a connection to port %d: its reader subscribes again and again", self.local_port)
            self.ended += ended
        self._known = max(1, count)
