"""Publishes the site's recorded streams to consoles on this machine, about thirty times a second.

The feed is on loopback with Curve, and accepts only the owner of the site's secret key, as the desk does. A console
that is slow, asleep or gone loses messages and delays no other, because a publisher never waits.
"""

from collections.abc import Iterator
from typing import NamedTuple, Protocol

import msgpack
import zmq

from common.link.curve import prepare_publisher, prepare_socket, use_curve
from common.link.keys import KeyPair
from common.link.local_control import HOST, OwnerSocket
from common.link.subscriptions import Subscriptions

STREAMS = frozenset(
    f"operator/{stream}"
    for stream in ("touch", "rendered", "skin", "clock", "session", "played", "figures", "coupling")
)
"""Streams that consoles receive."""
BATCH_S = 1.0 / 30.0
"""Interval between two messages, s."""
_LARGEST = 1 << 20
"""Largest message, bytes; one tick adds about 1.5 kB."""
_WAITING = 8
"""Messages that are queued for a console that does not read; it loses further ones."""


class Fed(NamedTuple):
    """One message of a stream, with its source time, ns of the site's monotonic clock."""

    stream: str
    time_ns: int
    payload: bytes


class ConsoleFeed(Protocol):
    """The site's end of a feed."""

    def write(self, stream: str, time_ns: int, payload: bytes) -> None:
        """Add one message to the next batch, if its stream is in STREAMS."""

    def step(self, now_ns: int) -> None:
        """Send the batch when it is due."""


class FeedSource(Protocol):
    """A console's end of a feed."""

    def receive(self) -> Iterator[Fed]:
        """Yield the messages since the last call, oldest first."""


class ConsoleFeedSocket(OwnerSocket):
    """The site's end."""

    def __init__(self, port: int, keys: KeyPair):
        """Bind the port; raises LinkProblem."""
        self._batch: list[Fed] = []
        self._sent_ns = 0
        super().__init__(zmq.PUB, port, keys, "feed")

    def _prepare(self, port: int) -> None:
        prepare_publisher(self._socket)
        self._socket.setsockopt(zmq.SNDHWM, _WAITING)
        self._subscribers = Subscriptions(self._socket, port)

    def write(self, stream: str, time_ns: int, payload: bytes) -> None:
        """Add one message to the next batch, if its stream is in STREAMS."""
        if stream in STREAMS:
            self._batch.append(Fed(stream, time_ns, payload))

    def step(self, now_ns: int) -> None:
        """Send the batch when it is due; after a clock was set back, at once."""
        if 0 <= now_ns - self._sent_ns < BATCH_S * 1e9 or not self._batch:
            return
        self._sent_ns = now_ns
        self._socket.send(msgpack.packb(self._batch))
        self._subscribers.step()
        self._batch = []


class FeedReader:
    """A console's end: receives the feed, and reconnects after each interruption."""

    def __init__(self, port: int, keys: KeyPair):
        """Connect in the background."""
        self._context = zmq.Context()
        self.socket = self._context.socket(zmq.SUB)
        """Socket to poll; read it with `receive` only."""
        prepare_socket(self.socket)
        self.socket.setsockopt(zmq.MAXMSGSIZE, _LARGEST)
        self.socket.setsockopt(zmq.RCVHWM, _WAITING)
        use_curve(self.socket, keys, keys.public)
        self.socket.subscribe(b"")
        self.socket.connect(f"tcp://{HOST}:{port}")

    def receive(self) -> Iterator[Fed]:
        """Yield the messages since the last call, oldest first."""
        for _ in range(_WAITING):
            try:
                packed = self.socket.recv(zmq.DONTWAIT)
            except zmq.Again:
                return
            for stream, time_ns, payload in msgpack.unpackb(packed):
                yield Fed(stream, time_ns, payload)

    def close(self) -> None:
        """Disconnect."""
        self._context.destroy(linger=0)
