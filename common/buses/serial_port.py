"""The host's end of a serial line: a tty or a `socket://` address, opened for one program alone."""

import errno
import fcntl
import os
import select
import socket
import struct
import termios
from typing import Protocol
from urllib.parse import urlsplit

import serial

from common.buses import tcp_options

BAUD = 921_600
"""Of a real line; a simulated one does not care."""
CHUNK = 4096
"""Most bytes of one read."""


class DeviceAbsent(OSError):
    """No device answers at an address."""


class Port(Protocol):
    """The host's end of a serial line that is open. Reading and writing never block."""

    @property
    def descriptor(self) -> int | None:
        """File descriptor that the system can be asked about; None where there is none."""

    def wait(self, seconds: float) -> bool:
        """Wait until something can be read, s; returns whether it can. The end of a connection can be read."""

    def read(self) -> bytes:
        """What waits to be read, CHUNK bytes at most; empty where nothing does.

        Raises:
            OSError: the connection has ended.
        """

    def write(self, data: bytes) -> int:
        """Write; returns how many bytes the line took.

        Raises:
            OSError: the connection has ended.
        """

    def unread(self) -> int:
        """How many bytes wait to be read; raises OSError as `read`."""

    def close(self) -> None:
        """Give the address back; may take a moment."""


class SystemPort:
    """A port of the operating system, as pyserial opens it.

    It is read and written past pyserial, which asks the system twice more for each read, and whose write without a
    time-out never returns on a line that is full.
    """

    __slots__ = ("_port", "descriptor")

    def __init__(self, port: serial.SerialBase) -> None:
        """Take an open port of pyserial."""
        self._port = port
        self.descriptor: int | None = port.fileno()

    def wait(self, seconds: float) -> bool:
        """As `Port.wait`."""
        poll = select.poll()
        poll.register(self._open, select.POLLIN)
        return bool(poll.poll(seconds * 1e3))

    def read(self) -> bytes:
        """As `Port.read`."""
        try:
            chunk = os.read(self._open, CHUNK)
        except BlockingIOError:
            return b""
        if not chunk:
            raise serial.SerialException("readable, but nothing comes: the device is gone, or another program reads it")
        return chunk

    def write(self, data: bytes) -> int:
        """As `Port.write`."""
        try:
            return os.write(self._open, data)
        except BlockingIOError:
            return 0

    def unread(self) -> int:
        """As `Port.unread`."""
        return int(struct.unpack("i", fcntl.ioctl(self._open, termios.FIONREAD, bytes(4)))[0])

    def close(self) -> None:
        """As `Port.close`."""
        self.descriptor = None
        _close(self._port)

    @property
    def _open(self) -> int:
        if self.descriptor is None:
            raise serial.SerialException("the port is closed")
        return self.descriptor


def open_port(address: str, baud: int = BAUD) -> SystemPort:
    """Open an address; a tty is nobody else's then.

    A zero byte is sent first: it ends a half frame that an earlier driver left, and shows who comes here as a driver.

    Raises:
        DeviceAbsent: nothing there, not to be opened, or another program has it.
    """
    try:
        if address.startswith("socket://") and urlsplit(address).port is None:
            raise ValueError("a device behind TCP is socket://HOST:PORT")
        port = serial.serial_for_url(address, do_not_open=True, baudrate=baud, timeout=0, exclusive=True)
    except (serial.SerialException, OSError, ValueError) as error:
        raise DeviceAbsent(f"{address}: {error}") from None
    try:
        port.open()
        opened = SystemPort(port)
        if isinstance(connection := getattr(port, "_socket", None), socket.socket):
            tcp_options.tune(connection)
        opened.write(b"\0")
    except (serial.SerialException, OSError, ValueError) as error:
        _close(port)
        raise DeviceAbsent(f"{address}: {error}{_advice(error)}") from None
    return opened


def _close(port: serial.SerialBase) -> None:
    """Close a port; the library leaves a connection open that the far side has ended, or that was reset while made."""
    connection = getattr(port, "_socket", None)
    port.close()
    if connection is not None:
        connection.close()


def _advice(error: Exception) -> str:
    """What to do about a port that cannot be opened."""
    return {
        errno.EACCES: "; the group `dialout` may open it: deploy/udev/README.md",
        errno.EAGAIN: "; another program has it, such as a running site",
    }.get(getattr(error, "errno", None) or 0, "")
