"""Serve an emulated serial module at an address: a pseudo terminal or a TCP port (`socket://` for pyserial)."""

import math
import os
import pty
import socket
import tempfile
import tty
from abc import ABC, abstractmethod
from pathlib import Path
from typing import Protocol

from sim_sensors.devices.breakable_parts import Babble
from sim_sensors.ports.backlog import Backlog
from sim_sensors.ports.line_client import LineClient
from sim_sensors.ports.select_loop import SelectLoop
from sim_sensors.ports.tcp_port import TcpPort, receive_tcp, tcp_address

_CHUNK = 4096
_BACKLOG_BYTES = 16 * 1024
"""Largest backlog of a module, bytes; it holds a third of a second of the fastest module."""
_LOOK_S = 0.010
"""Time between two checks that the client is live, s."""
_KNOCK_S = 1.0
"""Time for which a connection that has sent nothing is kept, s."""
_MOST_KNOCKING = 4
"""Largest number of connections that have sent nothing yet."""


class Device(Protocol):
    """A serial device with bytes and times as its only interface, as in `sim_sensors.devices.serial_module`."""

    def feed(self, data: bytes, now_s: float) -> None:
        """Take bytes from the host."""

    def take_output(self, now_s: float) -> bytes:
        """Return bytes for the host."""


class SerialServer(ABC):
    """One module at one address.

    Attributes:
        address: address for the driver, a tty path or `socket://HOST:PORT`. It stays the same when the cable is pulled.
        backlog: bytes that the driver has not read yet.
        silent: the module neither sends nor receives, although its line stays open and its own time-outs act.
        deaf: the module receives nothing.
        babble: noise that fills the line; None for a sound module.
    """

    address: str

    def __init__(self, device: Device) -> None:
        self.backlog = Backlog(_BACKLOG_BYTES)
        self.silent = False
        self.deaf = False
        self.babble: Babble | None = None
        self._device = device

    def pump(self, now_s: float) -> None:
        """Advance the module to `now_s` and send its output."""
        output = self._device.take_output(now_s)
        if self.babble is not None:
            output = self.babble.mix(now_s, output)
        if output and not self.silent:
            self.send(output)

    @abstractmethod
    def unplug(self) -> None:
        """Pull the cable: the connection ends, and the address does not answer."""

    @abstractmethod
    def plug(self) -> None:
        """Put the cable back: the same address answers again."""

    @abstractmethod
    def close(self) -> None:
        """Disconnect and release the address."""

    @abstractmethod
    def send(self, output: bytes) -> None:
        """Send bytes to the driver without blocking."""

    def _received(self, data: bytes, now_s: float) -> None:
        if not (self.silent or self.deaf):
            self._device.feed(data, now_s)
        self.pump(now_s)


class PtyServer(SerialServer):
    """A module at its own pseudo terminal, in raw mode.

    Its address is a link, like those of hardware in `/dev/serial/by-id`, because each new terminal has another number.
    """

    def __init__(self, device: Device, loop: SelectLoop, what: str) -> None:
        super().__init__(device)
        self._loop = loop
        self._folder = tempfile.TemporaryDirectory(prefix="serial-")
        self._link = Path(self._folder.name, what.replace(" ", "-"))
        self._ends: tuple[int, int] | None = None
        self.address = str(self._link)
        self.plug()

    def unplug(self) -> None:
        """Remove the terminal and its name, even while a driver has it open."""
        if self._ends is None:
            return
        self._link.unlink()
        self._loop.forget(self._ends[0])
        for end in self._ends:
            os.close(end)
        self._ends = None

    def plug(self) -> None:
        """Open a terminal under the same name."""
        if self._ends is not None:
            return
        # The slave end stays open here, so that the line stays up when a driver closes it.
        master, slave = self._ends = pty.openpty()
        tty.setraw(slave)
        os.set_blocking(master, False)
        self.backlog = Backlog(_BACKLOG_BYTES)
        self._loop.watch(master, self._read)
        self._link.symlink_to(os.ttyname(slave))

    def close(self) -> None:
        """Disconnect and remove the terminal."""
        self.unplug()
        self._folder.cleanup()

    def send(self, output: bytes) -> None:
        """As `SerialServer.send`."""
        if self._ends is None:
            return
        master, _ = self._ends
        self.backlog.pass_on(output, lambda data: os.write(master, data))

    def _read(self, now_s: float) -> None:
        if self._ends is None:
            return
        try:
            data = os.read(self._ends[0], _CHUNK)
        except BlockingIOError:
            return
        self._received(data, now_s)


class TcpServer(SerialServer):
    """A module at a TCP port, with one client at a time.

    A client must begin with a zero byte, as drivers do. Until then it receives nothing. A client that begins with
    another byte is disconnected. A second client is disconnected while the first is live, and replaces it otherwise.
    """

    def __init__(self, device: Device, loop: SelectLoop, host: str, port: int, what: str) -> None:
        super().__init__(device)
        self._loop = loop
        self._client: LineClient | None = None
        self._knocking: dict[socket.socket, float] = {}
        self._looked_s = -math.inf
        self._port = TcpPort(loop, host, port, what, buffer_bytes=_BACKLOG_BYTES, greet=self._greet)
        self.address = f"socket://{host}:{self._port.number}"

    def pump(self, now_s: float) -> None:
        """Advance the module to `now_s` and send its output; drop connections that stay silent."""
        if not 0.0 <= now_s - self._looked_s < _LOOK_S:
            self._looked_s = now_s
            if self._client is not None:
                self._client.live(now_s)
            for connection in [each for each, came_s in self._knocking.items() if now_s - came_s > _KNOCK_S]:
                self._send_away(connection)
        super().pump(now_s)

    def unplug(self) -> None:
        """Disconnect all clients and refuse new ones."""
        self._hang_up_on_all()
        self._port.unplug()

    def plug(self) -> None:
        """Listen at the same port again."""
        self._port.plug()

    def close(self) -> None:
        """Disconnect all clients and release the port."""
        self._hang_up_on_all()
        self._port.close()

    def _greet(self, connection: socket.socket, now_s: float) -> None:
        if len(self._knocking) >= _MOST_KNOCKING:
            self._send_away(next(iter(self._knocking)))
        self._knocking[connection] = now_s
        self._loop.watch(connection.fileno(), lambda now_s: self._knock(connection, now_s))

    def _knock(self, connection: socket.socket, now_s: float) -> None:
        """Take the first bytes of a new connection; accept it as the client if they are a driver's."""
        data = receive_tcp(connection, _CHUNK)
        if data is None:
            return
        if not data.startswith(b"\0") or (self._client is not None and self._client.live(now_s)):
            self._send_away(connection)
            return
        self._hang_up()
        del self._knocking[connection]
        self._client = LineClient(connection, now_s)
        self.backlog = Backlog(_BACKLOG_BYTES)
        self._loop.watch(connection.fileno(), self._read)
        self._received(data, now_s)  # its zero byte ends a frame that the last client left incomplete

    def send(self, output: bytes) -> None:
        """As `SerialServer.send`."""
        if self._client is None:
            return
        try:
            self.backlog.pass_on(output, self._client.send)
        except OSError:
            self._hang_up()

    def _read(self, now_s: float) -> None:
        if self._client is None:
            return
        data = receive_tcp(self._client.connection, _CHUNK)
        if data is None:
            return
        if data:
            self._client.heard(now_s)
            self._received(data, now_s)
        else:
            self._hang_up()

    def _hang_up(self) -> None:
        if self._client is not None:
            self._loop.forget(self._client.connection.fileno())
            self._client.connection.close()
            self._client = None

    def _send_away(self, connection: socket.socket) -> None:
        del self._knocking[connection]
        self._loop.forget(connection.fileno())
        connection.close()

    def _hang_up_on_all(self) -> None:
        self._hang_up()
        for connection in list(self._knocking):
            self._send_away(connection)


def serve_serial(device: Device, loop: SelectLoop, address: str, what: str) -> SerialServer:
    """Serve a module at `address`: `pty` or `tcp:HOST:PORT` (port 0: one that is free).

    Raises:
        ValueError: the address has another form, or is taken; `what` names the module in the message.
    """
    if address == "pty":
        return PtyServer(device, loop, what)
    place = tcp_address(address)
    if place is None:
        raise ValueError(f"{what}: address {address!r} is neither 'pty' nor 'tcp:HOST:PORT'")
    return TcpServer(device, loop, *place, what)
