"""A TCP connection that begins with lines, and then carries the bytes of another connection unchanged."""

import asyncio
import contextlib
import socket
from typing import cast

from teletaction.tunnel.greeting import LONGEST_LINE

_WAITING_BYTES = 16 * 1024
"""Number of bytes that wait to be sent before the sender has to wait: a newer packet is then sent in their place."""
_UNACKNOWLEDGED_MS = 2000
"""Time without an acknowledgement after which a connection ends, ms, as in the link itself."""
_OPTIONS = (
    (socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1),
    (socket.IPPROTO_TCP, socket.TCP_KEEPIDLE, 5),
    (socket.IPPROTO_TCP, socket.TCP_KEEPINTVL, 1),
    (socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, _UNACKNOWLEDGED_MS),
    (socket.IPPROTO_TCP, socket.TCP_NOTSENT_LOWAT, _WAITING_BYTES),
    (socket.IPPROTO_TCP, socket.TCP_NODELAY, 1),
)


class Connection(asyncio.Protocol):
    """One connection. Subclasses say what happens when it opens, with each line, and when it has closed.

    Attributes:
        transport: transport of the connection.
    """

    transport: asyncio.Transport

    def __init__(self, every: "set[Connection]") -> None:
        """Be one of `every` while it is open."""
        self._every = every
        self._head = b""
        self._lines_end = False
        self._peer: Connection | None = None

    @property
    def joined(self) -> bool:
        """Whether it carries the bytes of another connection."""
        return self._peer is not None

    @property
    def _reads_lines(self) -> bool:
        return self._peer is None and not self._lines_end

    def opened(self) -> None:
        """The connection is open."""

    def take_line(self, line: str) -> None:
        """A line has arrived."""

    def closed(self) -> None:
        """The connection has closed."""

    def end_lines(self) -> None:
        """Read no further line: what follows is for the peer, and waits until it is joined."""
        self._lines_end = True
        self.transport.pause_reading()

    def say(self, line: str) -> None:
        """Send a line."""
        self.transport.write(line.encode("ascii", "replace") + b"\n")

    def connection_made(self, transport: asyncio.BaseTransport) -> None:
        """Set the options of the socket."""
        self.transport = cast(asyncio.Transport, transport)
        self._every.add(self)
        self.transport.set_write_buffer_limits(high=_WAITING_BYTES, low=0)
        end: socket.socket = transport.get_extra_info("socket")
        with contextlib.suppress(OSError):  # the far side has already closed it
            for option in _OPTIONS:
                end.setsockopt(*option)
        self.opened()

    def data_received(self, data: bytes) -> None:
        """Carry bytes on; before, read lines."""
        if self._peer is not None:
            self._peer.transport.write(data)
            return
        self._head += data
        while self._reads_lines and b"\n" in self._head and not self.transport.is_closing():
            line, self._head = self._head.split(b"\n", 1)
            self.take_line(line.decode("ascii", "replace"))
        if self._reads_lines and len(self._head) > LONGEST_LINE:
            self.transport.abort()

    def pause_writing(self) -> None:
        """Let the peer's sender wait."""
        if self._peer is not None:
            self._peer.transport.pause_reading()

    def resume_writing(self) -> None:
        """Let it continue."""
        if self._peer is not None:
            self._peer.transport.resume_reading()

    def connection_lost(self, error: Exception | None) -> None:
        """Close the peer, too."""
        self._every.discard(self)
        peer, self._peer = self._peer, None
        if peer is not None:
            peer.transport.close()
        self.closed()

    @staticmethod
    def join(one: "Connection", other: "Connection") -> None:
        """Carry the bytes of each of two connections to the other, from the bytes after the last line on."""
        one._peer, other._peer = other, one
        for here, there in ((one, other), (other, one)):
            head, here._head = here._head, b""
            here.transport.resume_reading()
            there.transport.write(head)  # last: it may let the sender wait


async def close_all(every: set[Connection]) -> None:
    """End all connections at once."""
    while every:
        for connection in tuple(every):
            connection.transport.abort()
        await asyncio.sleep(0.0)
