"""TCP port that takes fault commands for a simulation, one a line, from tests or from `nc`.

    client: unplug index tacttip     server: ok 81234567890123
    client: unplug nose              server: error unplug nose: ...

The number is the monotonic time, ns, at which the command was executed.
"""

import socket
from collections.abc import Callable

from sim_sensors.ports.select_loop import SelectLoop
from sim_sensors.ports.tcp_port import TcpPort, receive_tcp

LONGEST_LINE = 200
"""Longest command line, bytes; a client that sends more without a line end is disconnected."""
LOOPBACK = "127.0.0.1"
_BUFFER_BYTES = 16 * 1024


class FaultPort:
    """Take commands from any number of clients on this machine.

    Attributes:
        number: the TCP port's number.
    """

    def __init__(self, sockets: SelectLoop, port: int, apply: Callable[[str], str]) -> None:
        """Listen on loopback only, so that faults are accepted from this machine only.

        Args:
            sockets: event loop that watches the port; its clock gives the time in each answer.
            port: TCP port; 0: one that is free.
            apply: executes one command; its result follows the time in the answer. It raises ValueError
                for an invalid command.

        Raises:
            ValueError: the port is taken.
        """
        self._sockets = sockets
        self._apply = apply
        self._unread: dict[socket.socket, bytes] = {}
        self._port = TcpPort(sockets, LOOPBACK, port, "fault port", buffer_bytes=_BUFFER_BYTES, greet=self._greet)
        self.number = self._port.number

    def close(self) -> None:
        """Disconnect all clients and release the port."""
        for client in list(self._unread):
            self._hang_up(client)
        self._port.close()

    def _greet(self, client: socket.socket, _now_s: float) -> None:
        self._unread[client] = b""
        self._sockets.watch(client.fileno(), lambda _now_s: self._read(client))

    def _read(self, client: socket.socket) -> None:
        data = receive_tcp(client, LONGEST_LINE)
        if data is None:
            return
        if not data:
            self._hang_up(client)
            return
        *lines, unread = (self._unread[client] + data).split(b"\n")
        self._unread[client] = unread
        for line in lines:
            self._answer(client, self._obey(line.decode("utf-8", "replace").strip()))
        if len(unread) > LONGEST_LINE:
            self._answer(client, f"error a line is at most {LONGEST_LINE} bytes")
            self._hang_up(client)

    def _obey(self, line: str) -> str:
        time_ns = round(self._sockets.now() * 1e9)
        try:
            text = self._apply(line)
        except ValueError as error:
            return f"error {error}"
        return f"ok {time_ns} {text}"

    def _answer(self, client: socket.socket, text: str) -> None:
        answer = " ".join(text.split()).encode("utf-8") + b"\n"
        try:
            sent = client.send(answer)
        except OSError:
            sent = 0
        if sent < len(answer):  # the client has gone, or sends commands without reading the answers
            self._hang_up(client)

    def _hang_up(self, client: socket.socket) -> None:
        if self._unread.pop(client, None) is not None:
            self._sockets.forget(client.fileno())
            client.close()
