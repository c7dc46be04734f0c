"""Serve a CAN bus over TCP with the public socketcand protocol (github.com/linux-can/socketcand).

The messages are ASCII:

    server: < hi >       client: < open can0 >       server: < ok >
    client: < rawmode >  server: < ok >
    client: < send 110 8 1 2 3 4 5 6 7 8 >           server: < frame 100 12.345678 0102030405060708 >

Every frame of one client or node goes to all other clients. Nodes hear the frames with 11-bit identifiers. Bit rate and
arbitration are not modelled. The only modelled bus error is bus-off: the gateway's controller leaves the bus
(`< error 040 12.345678 >`) and restarts (`100`).
"""

import math
import socket
from collections.abc import Iterable, Sequence

from common.buses.can_frames import SentFrame
from sim_sensors.ports.backlog import Backlog
from sim_sensors.ports.node_bus import Node, NodeBus
from sim_sensors.ports.select_loop import SelectLoop
from sim_sensors.ports.tcp_port import TcpPort, receive_tcp

_BACKLOG_BYTES = 64 * 1024
_CHUNK = _BACKLOG_BYTES
"""Size of a read, bytes; one read takes all waiting set-points, so a stalled process does not replay them in steps."""
_LONGEST_COMMAND = 200
_CHANNEL = "can0"
_BYTES = {text: byte for byte in range(256) for text in (f"{byte:02x}", f"{byte:02X}")}
MOST_CLIENTS = 32
"""Maximum number of connections; a further one takes the place of the oldest that has not begun to read frames."""
QUIET_S = 0.1
"""Pause after the answer to `rawmode`, s; a client expects this answer alone in one read, without frames behind it."""


class _Client:
    """One connection: its handshake, its unread input, its unsent output."""

    def __init__(self, connection: socket.socket) -> None:
        self.connection = connection
        self.backlog = Backlog(_BACKLOG_BYTES)
        self.pending = ""
        self.raw_from_s = math.inf


class SocketcandBus(NodeBus):
    """A bus with TCP clients.

    Attributes:
        port: TCP port that it is served at.
        not_understood: number of invalid or misplaced commands of clients.
    """

    def __init__(self, loop: SelectLoop, host: str, port: int, nodes: Sequence[Node] = ()) -> None:
        """Serve the bus at `host`:`port` (0: one that is free); raises ValueError where the address is taken."""
        super().__init__(nodes)
        self._loop = loop
        self._clients: dict[int, _Client] = {}
        self._port = TcpPort(loop, host, port, f"CAN bus {_CHANNEL}", buffer_bytes=_BACKLOG_BYTES, greet=self._greet)
        self.port = self._port.number
        self.not_understood = 0

    @property
    def clients(self) -> int:
        """Number of connections."""
        return len(self._clients)

    def unplug(self) -> None:
        """Take the gateway off the network: disconnect all clients and refuse new ones."""
        self._hang_up_on_all()
        self._port.unplug()

    def plug(self) -> None:
        """Serve the bus at the same port again."""
        self._port.plug()

    def close(self) -> None:
        """Disconnect all clients and release the port."""
        self._hang_up_on_all()
        self._port.close()

    def _greet(self, connection: socket.socket, _now_s: float) -> None:
        client = _Client(connection)
        self._clients[connection.fileno()] = client
        if len(self._clients) > MOST_CLIENTS:
            oldest = next(each for each in self._clients.values() if each.raw_from_s == math.inf)
            self._hang_up(oldest)
            if oldest is client:
                return
        self._loop.watch(connection.fileno(), lambda now: self._read(client, now))
        self._say(client, b"< hi >")

    def _read(self, client: _Client, now_s: float) -> None:
        data = receive_tcp(client.connection, _CHUNK)
        if data is None:
            return
        if not data:
            self._hang_up(client)
            return
        *commands, client.pending = (client.pending + data.decode("ascii", "replace")).split(">")
        for command in commands:
            words = command.strip().removeprefix("<").split()
            if len(words) > 2 and words[0] == "send":
                self._forward(client, words[1], words[2], words[3:], now_s)
            else:
                self._obey(client, words, now_s)
        if len(client.pending) > _LONGEST_COMMAND:
            client.pending = ""
            self.not_understood += 1

    def _obey(self, client: _Client, words: list[str], now_s: float) -> None:
        match words:
            case ["open", channel] if channel == _CHANNEL:
                self._say(client, b"< ok >")
            case ["open", _]:
                self._say(client, b"< error could not open bus >")
            case ["rawmode"]:
                self._say(client, b"< ok >")
                client.raw_from_s = now_s + QUIET_S
            case ["echo"]:
                self._say(client, b"< echo >")
            case _:
                # Clients in raw mode cannot read an error, so it is only counted.
                self.not_understood += 1

    def _forward(self, client: _Client, identifier: str, length: str, data: list[str], now_s: float) -> None:
        try:
            frame_id, payload = int(identifier, 16), _payload(data)
            extended = len(identifier) > 3
            sound = int(length, 16) == len(payload) <= 8 and 0 <= frame_id < (1 << 29 if extended else 1 << 11)
        except ValueError:
            sound = False
        if not sound:
            self.not_understood += 1
            return
        client.raw_from_s = min(client.raw_from_s, now_s)  # a client that sends has read the whole handshake
        if self.off:
            return
        if len(self._clients) > 1:
            identifier = f"{frame_id:08X}" if extended else f"{frame_id:03X}"
            self._say_to_others(client, f"< frame {identifier} {now_s:.6f} {payload.hex()} >", now_s)
        if not extended:
            self._received(frame_id, payload, now_s)

    def _send(self, frames: Sequence[SentFrame], now_s: float) -> None:
        if frames and self._clients:
            time = f"{now_s:.6f}"
            text = "".join([f"< frame {frame_id:03X} {time} {data.hex()} >" for frame_id, data in frames])
            self._say_to_others(None, text, now_s)

    def _send_error(self, error: int) -> None:
        now_s = self._loop.now()
        self._say_to_others(None, f"< error {error:03X} {now_s:.6f} >", now_s)

    def _say_to_others(self, sender: _Client | None, text: str, now_s: float) -> None:
        for client in list(self._clients.values()):
            if client is not sender and now_s >= client.raw_from_s:
                self._say(client, text.encode("ascii"))

    def _say(self, client: _Client, text: bytes) -> None:
        try:
            client.backlog.pass_on(text, client.connection.send)
        except OSError:
            self._hang_up(client)

    def _hang_up_on_all(self) -> None:
        for client in list(self._clients.values()):
            self._hang_up(client)

    def _hang_up(self, client: _Client) -> None:
        if client.connection.fileno() < 0:
            return
        self._loop.forget(client.connection.fileno())
        del self._clients[client.connection.fileno()]
        client.connection.close()


def _payload(data: Iterable[str]) -> bytes:
    """Return the bytes that hexadecimal words represent; raise ValueError for an invalid word."""
    try:
        return bytes(map(_BYTES.__getitem__, data))
    except KeyError:
        return bytes([int(byte, 16) for byte in data])
