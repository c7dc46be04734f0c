"""Carry one TCP connection through the simulated network: two sockets, and a flow of bytes in each direction."""

import contextlib
import errno
import socket
import struct

from sim_sensors.network.fault import WAYS, Fault, Way
from sim_sensors.network.stream import TcpStream
from sim_sensors.ports.select_loop import SelectLoop
from sim_sensors.ports.tcp_port import ended, receive_tcp

_CHUNK = 64 * 1024
BUFFER_BYTES = 64 * 1024
"""Size of each kernel buffer of a connection, bytes; it is small, so that bytes wait in the model."""
_RESET = struct.pack("ii", 1, 0)


class _Flow:
    """Bytes on their way from one socket to the other."""

    def __init__(self, source: socket.socket, target: socket.socket, stream: TcpStream, sockets: SelectLoop) -> None:
        self.stream = stream
        self.done = False
        self._source = source
        self._target = target
        self._sockets = sockets
        self._unsent = bytearray()
        self._source_ended = False
        self._watched = False

    def step(self, now_s: float) -> None:
        """Deliver the bytes that are due, and let the sender continue or wait."""
        self._deliver(now_s)
        room = not self._source_ended and len(self._unsent) < BUFFER_BYTES and not self.stream.full(now_s)
        if room and not self._watched:
            self._sockets.watch(self._source.fileno(), self._read)
        elif self._watched and not room:
            self._sockets.forget(self._source.fileno())
        self._watched = room

    def _read(self, now_s: float) -> None:
        data = receive_tcp(self._source, _CHUNK)
        if data is None:
            return
        self._source_ended = not data
        self.stream.push(data, now_s)
        self.step(now_s)

    def _deliver(self, now_s: float) -> None:
        self._unsent += self.stream.take(now_s)
        if self.done:
            return
        try:
            if self._unsent:
                del self._unsent[: self._target.send(self._unsent)]
            if self.stream.ended and not self._unsent:
                self._target.shutdown(socket.SHUT_WR)
                self.done = True
        except BlockingIOError:
            return
        except OSError:  # the receiver has gone
            self.stream.vanish()
            self._unsent.clear()
            self.done = True


class Connection:
    """A client of the proxy and its connection to the far side."""

    def __init__(self, client: socket.socket, streams: dict[Way, TcpStream], sockets: SelectLoop) -> None:
        """Take a client; its bytes are not read until the connection to the far side is made."""
        self.streams = streams
        self.closed = False
        self._client = client
        self._server: socket.socket | None = None
        self._sockets = sockets
        self._flows: list[_Flow] = []
        self._reset_s = float("inf")

    def connect(self, host: str, port: int) -> None:
        """Begin to connect to the far side; only the first call does anything."""
        if self._server is not None:
            return
        self._server = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        self._server.setblocking(False)
        self._server.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        for option in (socket.SO_SNDBUF, socket.SO_RCVBUF):
            self._server.setsockopt(socket.SOL_SOCKET, option, BUFFER_BYTES)
        try:
            error = self._server.connect_ex((host, port))
        except OSError:  # the host name is unknown
            self.reset()
            return
        if error not in (0, errno.EINPROGRESS):
            self.reset()

    def step(self, now_s: float) -> None:
        """Move bytes; close the connection once both ends have ended it, and reset it when that is due."""
        if self.closed:
            return
        if self._server is None:
            if ended(self._client):  # it has given up
                self._close()
            return
        if now_s >= self._reset_s:
            self.reset()
            return
        if not self._flows and not self._begin():
            return
        for flow in self._flows:
            flow.step(now_s)
        if all(flow.done for flow in self._flows):
            self._close()

    def begin_fault(self, fault: Fault, begin_s: float) -> None:
        """Apply a fault of connections (`cut`, `half_open`); faults of paths have no effect here."""
        if fault.kind == "cut":
            self.reset()
        elif fault.kind == "half_open" and fault.seconds is not None:
            self._reset_s = begin_s + fault.seconds
            for way in fault.ways:
                self.streams[way].vanish()

    def reset(self) -> None:
        """End the connection at once with a TCP reset at both ends."""
        for end in (self._client, self._server):
            if end is not None and end.fileno() >= 0:
                with contextlib.suppress(OSError):
                    end.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, _RESET)
        self._close()

    def _begin(self) -> bool:
        """Start the flows once the far side has answered; return whether it has."""
        assert self._server is not None
        if self._server.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR):
            self.reset()
            return False
        try:
            self._server.getpeername()
        except OSError:
            return False
        to_remote, to_operator = (self.streams[way] for way in WAYS)
        self._flows = [
            _Flow(self._client, self._server, to_remote, self._sockets),
            _Flow(self._server, self._client, to_operator, self._sockets),
        ]
        return True

    def _close(self) -> None:
        if self.closed:
            return
        self.closed = True
        for end in (self._client, self._server):
            if end is not None:
                self._sockets.forget(end.fileno())
                end.close()
