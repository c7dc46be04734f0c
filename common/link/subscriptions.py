"""Bounds the memory that readers of a PUB socket can make it use: a proper reader subscribes once, to everything.

The library stores a node for every byte of every subscription, without a limit. A reader with a trusted key made a
remote site grow by 20 MiB a second. The number of bytes received on each connection identifies the reader.
"""

import logging
import math
import time
from dataclasses import dataclass

import zmq

from common.link.tcp_connections import end_talkers

log = logging.getLogger(__name__)

_TOPICS_COUNT = 116
"""Option ZMQ_TOPICS_COUNT of libzmq from 4.3.5 on, which pyzmq does not name."""
_MOST_OF_A_READER = 2048
"""Maximum number of bytes that a reader sends: a handshake of 700, a subscription to everything, and its end."""
_REST = 5.0
"""Pause after a search for such readers, as a multiple of its duration: a search costs 10 us for each descriptor."""


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
    _rests_s: float = -math.inf

    def step(self) -> None:
        """End connections of readers with excess subscriptions when the socket's number of subscriptions has grown."""
        count, begin_s = subscriptions(self.socket), time.monotonic()
        if count > self._known:
            if begin_s < self._rests_s:
                return
            ended = end_talkers(self.local_port, _MOST_OF_A_READER)
            end_s = time.monotonic()
            self._rests_s = end_s + _REST * (end_s - begin_s)
            if ended and not self.ended:
                log.warning("ended a connection to port %d: its reader subscribes repeatedly", self.local_port)
            self.ended += ended
        self._known = max(1, count)


def subscriptions(socket: "zmq.Socket[bytes]") -> int:
    """Return how many different subscriptions a PUB socket has received, those of closed connections included."""
    return int(socket.getsockopt(_TOPICS_COUNT))
