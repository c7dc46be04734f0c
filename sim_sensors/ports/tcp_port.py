"""Listen on a TCP port, pass new clients to a callback, and refuse clients while unplugged."""

import socket
from collections.abc import Callable

from sim_sensors.ports.listener import accept_tcp, listen_tcp
from sim_sensors.ports.select_loop import SelectLoop

Greet = Callable[[socket.socket, float], None]


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
            buffer_bytes: largest send buffer of a client in the kernel.
            greet: takes each new client, which does not block, and the time at which it came.

        Raises:
            ValueError: the address is taken or is not this machine's.
        """
        self._loop = loop
        self._buffer_bytes = buffer_bytes
        self._greet = greet
        self._socket = listen_tcp(host, port, what)
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
        """Listen again at the same address.

        Raises:
            ValueError: another listener has taken the address.
        """
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
        client = accept_tcp(self._socket, self._buffer_bytes)
        if client is not None:
            self._greet(client, now_s)
