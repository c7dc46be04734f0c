"""Serve a TCP port without blocking: pass new clients to a callback, and refuse clients while unplugged."""

import re
import select
import socket
from collections.abc import Callable

from sim_sensors.ports.select_loop import SelectLoop

Greet = Callable[[socket.socket, float], None]
_ADDRESS = re.compile(r"tcp:([^:]+):([0-9]{1,5})")


def tcp_address(address: str) -> tuple[str, int] | None:
    """Return host and port of an address `tcp:HOST:PORT`; None for one of another form."""
    match = _ADDRESS.fullmatch(address)
    return None if match is None else (match[1], int(match[2]))


def receive_tcp(client: socket.socket, most: int) -> bytes | None:
    """Return the bytes of a client: empty once it has gone, None if there are none yet.

    The device's next report acknowledges them, within 10 ms. A client with Nagle's algorithm holds its next message
    back until then.
    """
    try:
        return client.recv(most)
    except BlockingIOError:
        return None
    except OSError:
        return b""


def ended(connection: socket.socket) -> bool:
    """Return whether the other end has closed a connection; its bytes may still be unread."""
    poll = select.poll()
    poll.register(connection, select.POLLRDHUP)
    return bool(poll.poll(0))


class TcpPort:
    """Listener on one address.

    Attributes:
        number: the TCP port's number.
    """

    def __init__(self, loop: SelectLoop, host: str, port: int, what: str, *, buffer_bytes: int, greet: Greet) -> None:
        """Listen on `host`:`port` (0: one that is free).

        Args:
            loop: event loop that watches the port.
            host: name or address of one of this machine's interfaces.
            port: TCP port.
            what: name of the service, for the error.
            buffer_bytes: send buffer of a client in the kernel; a small one keeps old messages from a slow reader.
            greet: takes each new client, which does not block, and the time at which it came.

        Raises:
            ValueError: the address is taken or is not this machine's.
        """
        self._loop = loop
        self._buffer_bytes = buffer_bytes
        self._greet = greet
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            self._socket.bind((host, port))
            self._socket.listen()
        except (OSError, OverflowError) as error:
            self._socket.close()
            raise ValueError(f"{what}: cannot listen on {host}:{port}: {error}; choose another port") from None
        self._socket.setblocking(False)
        self._plugged = True
        self.number: int = self._socket.getsockname()[1]
        loop.watch(self._socket.fileno(), self._accept)

    def unplug(self) -> None:
        """Refuse new clients, but keep the port."""
        if not self._plugged:
            return
        self._plugged = False
        self._loop.forget(self._socket.fileno())
        address = self._socket.getsockname()
        self._socket.close()
        # A bound port without a listener refuses every connection. The system could assign a free port to the driver
        # that tries to connect to it, and the driver would then receive an echo.
        self._socket = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        self._socket.bind(address)

    def plug(self) -> None:
        """Listen again at the same address; raises ValueError where another listener has taken the address."""
        if self._plugged:
            return
        try:
            self._socket.listen()
        except OSError as error:
            raise ValueError(f"port {self.number}: cannot listen again: {error}") from None
        self._plugged = True
        self._socket.setblocking(False)
        self._loop.watch(self._socket.fileno(), self._accept)

    def close(self) -> None:
        """Release the port."""
        if self._plugged:
            self._loop.forget(self._socket.fileno())
        self._socket.close()

    def _accept(self, now_s: float) -> None:
        try:
            client, _ = self._socket.accept()
        except OSError:  # the client has already gone
            return
        client.setblocking(False)
        client.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        client.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, self._buffer_bytes)
        self._greet(client, now_s)
