"""Serves an emulated serial module at an address: a pseudo terminal or a TCP port (`socket://` for pyserial)."""

import os
import pty
import re
import socket
import tty
from abc import ABC, abstractmethod
from collections.abc import Mapping
from typing import Protocol, TypeVar

from sim_sensors.backlog import Backlog
from sim_sensors.listener import accept_tcp, listen_tcp, receive_tcp
from sim_sensors.select_loop import SelectLoop

_CHUNK = 4096
_BACKLOG_BYTES = 16 * 1024
"""A third of a second of the fastest module."""
_TCP_ADDRESS = re.compile(r"tcp:(?P<host>[^:]+):(?P<port>\d{1,5})")


Finger = TypeVar("Finger", bound=str)


class Device(Protocol):
    """A machine of bytes and times, as in `sim_sensors.serial_module`."""

    def feed(self, data: bytes, now_s: float) -> None:
        """Take bytes from the host."""

    def take_output(self, now_s: float) -> bytes:
        """Return bytes for the host."""


class SerialServer(ABC):
    """One module at one address.

    Attributes:
        address: what a driver opens: a tty path or `socket://HOST:PORT`.
        backlog: bytes waiting for the driver to read them.
    """

    address: str

    def __init__(self, device: Device, loop: SelectLoop) -> None:
        self.backlog = Backlog(_BACKLOG_BYTES)
        self._device = device
        self._loop = loop

    def pump(self, now_s: float) -> None:
        """Let the module's clock reach `now_s` and send what it has to say."""
        output = self._device.take_output(now_s)
        if output:
            self._send(output)

    @abstractmethod
    def close(self) -> None:
        """Hang up and give the address back."""

    @abstractmethod
    def _send(self, output: bytes) -> None:
        """Send without waiting."""

    def _received(self, data: bytes, now_s: float) -> None:
        self._device.feed(data, now_s)
        self.pump(now_s)


class PtyServer(SerialServer):
    """A module at a pseudo terminal of its own, in raw mode."""

    def __init__(self, device: Device, loop: SelectLoop) -> None:
        super().__init__(device, loop)
        self._master, self._slave = pty.openpty()
        # The slave end stays open here, so that the line survives drivers that come and go.
        tty.setraw(self._slave)
        os.set_blocking(self._master, False)
        self.address = os.ttyname(self._slave)
        loop.watch(self._master, self._read)

    def close(self) -> None:
        """Hang up and give the terminal back."""
        self._loop.forget(self._master)
        os.close(self._master)
        os.close(self._slave)

    def _send(self, output: bytes) -> None:
        self.backlog.push(output)
        self.backlog.write(lambda data: os.write(self._master, data))

    def _read(self, now_s: float) -> None:
        try:
            data = os.read(self._master, _CHUNK)
        except BlockingIOError:
            return
        self._received(data, now_s)


class TcpServer(SerialServer):
    """A module at a TCP port. A new client takes the line over from the one before, which may be half dead."""

    def __init__(self, device: Device, loop: SelectLoop, host: str, port: int, what: str) -> None:
        super().__init__(device, loop)
        self._listener = listen_tcp(host, port, what)
        self._client: socket.socket | None = None
        self.address = f"socket://{host}:{self._listener.getsockname()[1]}"
        loop.watch(self._listener.fileno(), self._accept)

    def close(self) -> None:
        """Hang up and give the port back."""
        self._hang_up()
        self._loop.forget(self._listener.fileno())
        self._listener.close()

    def _accept(self, now_s: float) -> None:
        client = accept_tcp(self._listener, _BACKLOG_BYTES)
        if client is None:
            return
        self._hang_up()
        self._client = client
        self.backlog = Backlog(_BACKLOG_BYTES)
        # Whatever the client before left half sent ends here.
        self._device.feed(b"\0", now_s)
        self._loop.watch(client.fileno(), self._read)

    def _send(self, output: bytes) -> None:
        if self._client is None:
            return
        self.backlog.push(output)
        try:
            self.backlog.write(self._client.send)
        except OSError:
            self._hang_up()

    def _read(self, now_s: float) -> None:
        if self._client is None:
            return
        data = receive_tcp(self._client, _CHUNK)
        if data is None:
            return
        if data:
            self._received(data, now_s)
        else:
            self._hang_up()

    def _hang_up(self) -> None:
        if self._client is not None:
            self._loop.forget(self._client.fileno())
            self._client.close()
            self._client = None


def serve_serial(device: Device, loop: SelectLoop, address: str, what: str) -> SerialServer:
    """Serve a module at `address`: `pty` or `tcp:HOST:PORT` (port 0: one that is free).

    Raises:
        ValueError: the address has another form, or is taken; `what` names the module in the message.
    """
    if address == "pty":
        return PtyServer(device, loop)
    match = _TCP_ADDRESS.fullmatch(address)
    if match is None or int(match["port"]) > 65535:
        raise ValueError(f"{what}: address {address!r} is neither 'pty' nor 'tcp:HOST:PORT'")
    return TcpServer(device, loop, match["host"], int(match["port"]), what)


def serve_fingers(
    devices: Mapping[Finger, Device], loop: SelectLoop, addresses: Mapping[Finger, str], kind: str
) -> dict[Finger, SerialServer]:
    """Serve one kind of module for each finger, all of them or none.

    Raises:
        ValueError: fingers and addresses do not match, or an address cannot be served.
    """
    if set(devices) != set(addresses):
        given = ", ".join(addresses) or "no finger"
        raise ValueError(f"{kind}: has addresses for {given}, fingers says {', '.join(devices)}")
    servers: dict[Finger, SerialServer] = {}
    try:
        for finger, device in devices.items():
            servers[finger] = serve_serial(device, loop, addresses[finger], f"{kind} {finger}")
    except ValueError:
        for server in servers.values():
            server.close()
        raise
    return servers
