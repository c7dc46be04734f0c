"""One serial device on a tty or a `socket://` address: opened, asked who it is, read in chunks, re-opened."""

import errno
import fcntl
import logging
import os
import select
import socket
import struct
import termios
import threading
import time
from dataclasses import dataclass, field
from urllib.parse import urlsplit

import serial

from common import device_socket
from common.background import BackgroundOpener
from common.fingers import FINGERS
from common.framing import Frame, FrameReader, encode_frame
from common.serial_messages import DeviceKind, Identity, MessageId

log = logging.getLogger(__name__)

BAUD = 921_600
"""Of a real line; a simulated one does not care."""
_IDENTIFY_S = 1.0
_CHUNK = 4096


class WrongDevice(ValueError):
    """The device at an address is not the one that the configuration names."""


class DeviceAbsent(OSError):
    """No device answers at an address."""


@dataclass(frozen=True, slots=True)
class OpenLine:
    """An open port whose device said who it is."""

    port: serial.SerialBase
    identity: Identity


def open_port(address: str, baud: int = BAUD) -> serial.SerialBase:
    """Open an address; a tty is nobody else's then.

    A zero byte is sent first: it ends a half frame that an earlier driver left, and shows who comes here as a driver.

    Raises:
        DeviceAbsent: nothing there, not to be opened, or another program has it.
    """
    try:
        if address.startswith("socket://") and urlsplit(address).port is None:
            raise ValueError("a device behind TCP is socket://HOST:PORT")
        port = serial.serial_for_url(
            address, do_not_open=True, baudrate=baud, timeout=0.05, write_timeout=0.5, exclusive=True
        )
    except (serial.SerialException, OSError, ValueError) as error:
        raise DeviceAbsent(f"{address}: {error}") from None
    try:
        port.open()
        if isinstance(connection := getattr(port, "_socket", None), socket.socket):
            device_socket.tune(connection)
        port.write(b"\0")
    except (serial.SerialException, OSError, ValueError) as error:
        close_port(port)  # also when it did not open: the library leaves a connection that was reset meanwhile open
        raise DeviceAbsent(f"{address}: {error}{_advice(error)}") from None
    return port


def _advice(error: Exception) -> str:
    """What to do about a port that cannot be opened."""
    return {
        errno.EACCES: "; the group `dialout` may open it: deploy/udev/README.md",
        errno.EAGAIN: "; another program has it, such as a running site",
    }.get(getattr(error, "errno", None) or 0, "")


def open_line(address: str, baud: int = BAUD) -> OpenLine:
    """Open an address and ask the device for its identity; blocks up to about a second.

    Raises:
        DeviceAbsent: nothing there, or it does not answer.
    """
    port = open_port(address, baud)
    reader = FrameReader()
    try:
        deadline = time.monotonic() + _IDENTIFY_S
        port.write(encode_frame(MessageId.IDENTIFY, 0))
        while time.monotonic() < deadline:
            for frame in reader.feed(port.read(_CHUNK)):
                if frame.message_id == MessageId.IDENTITY:
                    identity = Identity.decode(frame.payload)
                    port.timeout = 0
                    port.write_timeout = 0
                    return OpenLine(port, identity)
    except (serial.SerialException, OSError, ValueError) as error:
        close_port(port)
        raise DeviceAbsent(f"{address}: {error}") from None
    close_port(port)
    garbage = f"; what comes is no frame: is it at {baud} baud?" if reader.damaged else ""
    raise DeviceAbsent(f"{address}: a port, but no device answers IDENTIFY within {_IDENTIFY_S:g} s{garbage}")


def close_port(port: serial.SerialBase) -> None:
    """Give an address back."""
    connection = getattr(port, "_socket", None)
    port.close()
    if connection is not None:
        connection.close()  # the library forgets to when the far side has gone first


def _waiting(port: serial.SerialBase) -> int:
    """Bytes that wait in the kernel; the library counts those of a tty only."""
    if not isinstance(connection := getattr(port, "_socket", None), socket.socket):
        return int(port.in_waiting)
    return int(struct.unpack("i", fcntl.ioctl(connection, termios.FIONREAD, bytes(4)))[0])


def read_now(port: serial.SerialBase) -> bytes:
    """What waits to be read; raises OSError at the end of a connection.

    The library asks the system twice more, and so for each port in each tick.
    """
    try:
        chunk = os.read(port.fileno(), _CHUNK)
    except BlockingIOError:
        return b""
    if not chunk:
        raise serial.SerialException("readable, but nothing comes: the device is gone, or another program reads it")
    return chunk


def write_now(port: serial.SerialBase, data: bytes) -> bool:
    """Write without waiting; returns whether the line took all of it."""
    try:
        return os.write(port.fileno(), data) == len(data)
    except BlockingIOError:
        return False


def _is_readable(port: serial.SerialBase) -> bool:
    return bool(select.select((port,), (), (), 0.0)[0])


def _discard(opened: OpenLine) -> None:
    _hang_up(opened.port)


def _hang_up(port: serial.SerialBase) -> None:
    """Close beside the loop: the library sleeps 0.3 s after closing a socket, and a tty may wait for its output."""
    threading.Thread(target=close_port, args=(port,), daemon=True, name="closer").start()


@dataclass(slots=True)
class SerialLine:
    """The line to one finger's device of one kind. Reading and writing never block."""

    address: str
    kind: DeviceKind
    finger: str
    baud: int = BAUD
    identity: Identity | None = None
    """Who answered; None while no device is there."""
    reader: FrameReader = field(default_factory=FrameReader)
    times_lost: int = 0
    unsent: int = 0
    """Messages dropped because the line was full."""
    readable: bool | None = None
    """See `ReadyLines`."""
    descriptor: int | None = None
    drained: bool = True
    """Whether the last poll has read all that waited."""
    _port: serial.SerialBase | None = None
    _sequence: int = 0
    _opener: BackgroundOpener[OpenLine] = field(init=False)

    def __post_init__(self) -> None:
        self._opener = BackgroundOpener(self._open_checked)
        self._opener.discard = _discard
        self._opener.start()

    @property
    def connected(self) -> bool:
        """Whether the right device is there."""
        return self._port is not None

    @property
    def silent(self) -> bool:
        """Whether the device is there and nothing of it waits to be read: then `poll` has nothing to do."""
        return self.readable is False and self._port is not None

    @property
    def problem(self) -> Exception | None:
        """Why there is no device: DeviceAbsent or WrongDevice; None while it is there or still being asked."""
        return None if self.connected else self._opener.problem

    def figures(self) -> dict[str, object]:
        """What the status file tells of this line."""
        return {
            "serial": self.identity.serial if self.identity is not None else None,
            "times_lost": self.times_lost,
            "damaged": self.reader.damaged,
            "missed": self.reader.lost,
            "unsent": self.unsent,
        }

    def poll(self) -> list[Frame]:
        """Frames that came since the last call; takes a device up that has appeared."""
        if self._port is None:
            opened = self._opener.take()
            if opened is None:
                return []
            self._port, self.identity = opened.port, opened.identity
            self.descriptor, self.readable = opened.port.fileno(), None
            self.reader = FrameReader()
            log.info("%s %s: serial number %s", self.finger, self.kind.name.lower(), opened.identity.serial)
        try:
            waits = _is_readable(self._port) if self.readable is None else self.readable
            chunk = read_now(self._port) if waits else b""
        except (serial.SerialException, OSError) as error:
            self._lose(error)
            return []
        self.drained = len(chunk) < _CHUNK
        return self.reader.feed(chunk) if chunk else []

    def unread_bytes(self) -> int:
        """How many bytes wait to be read; 0 with no device there."""
        if self._port is None or self.readable is False:
            return 0
        try:
            return _waiting(self._port)
        except OSError:
            return 0  # the next poll finds out

    def send(self, message_id: MessageId, payload: bytes) -> None:
        """Send one message; with no device there, or one that takes nothing any more, it is dropped."""
        if self._port is None:
            return
        self._sequence = (self._sequence + 1) & 0xFF
        try:
            # The library's write without a time-out turns for ever on a line that is full.
            if not write_now(self._port, encode_frame(message_id, self._sequence, payload)):
                self.unsent += 1
        except (serial.SerialException, OSError) as error:
            self._lose(error)

    def close(self) -> None:
        """Close the port and stop looking for the device."""
        self._opener.stop()
        if self._port is not None:
            _hang_up(self._port)
            self._port = self.descriptor = None

    def _open_checked(self) -> OpenLine:
        opened = open_line(self.address, self.baud)
        found = opened.identity
        if found.kind is not self.kind or FINGERS[found.finger] != self.finger:
            close_port(opened.port)
            raise WrongDevice(
                f"{self.address}: is the {FINGERS[found.finger]}'s {found.kind.name.lower()} {found.serial}, "
                f"the configuration says {self.finger}'s {self.kind.name.lower()}"
            )
        return opened

    def _lose(self, error: Exception) -> None:
        log.warning("%s %s at %s lost: %s", self.finger, self.kind.name.lower(), self.address, error)
        assert self._port is not None
        _hang_up(self._port)
        self._port = self.descriptor = self.identity = None
        self.times_lost += 1
        self._opener.start()
