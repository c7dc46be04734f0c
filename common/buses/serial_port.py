"""Opens the host's end of a serial line, a tty or a `socket://` address, for exclusive use."""

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
"""Baud rate of a real line; a simulated line ignores it."""
CHUNK = 4096
"""Maximum size of one read, bytes."""


class DeviceAbsent(OSError):
    """No device answers at an address."""


class Port(Protocol):
    """The host's end of an open serial line. Reading and writing never block."""

    @property
    def descriptor(self) -> int | None:
        """File descriptor to poll; None where there is none."""

    def wait(self, seconds: float) -> bool:
        """Wait up to `seconds` for data; return whether `read` has any. An ended connection counts as readable."""

    def read(self) -> bytes:
        """Return waiting data, at most CHUNK bytes; empty where there are none.

        Raises:
            OSError: the connection has ended.
        """

    def write(self, data: bytes) -> int:
        """Return how many of the bytes the line took; raises OSError where the connection has ended."""

    def unread(self) -> int:
        """Return how many bytes wait to be read; raises OSError as `read`."""

    def close(self) -> None:
        """Release the address; may take a moment."""


class SystemPort:
    """A port of the operating system, opened by pyserial.

    Reads and writes bypass pyserial. Its read makes two more system calls. Its write without a time-out never returns
    on a full line.
    """

    def __init__(self, port: serial.SerialBase) -> None:
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
            raise serial.SerialException("readable without data: the device is gone, or another program reads it")
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


def open_port(address: str) -> SystemPort:
    """Open an address; a tty is locked against other programs.

    The first byte sent is zero: it ends a partial frame of an earlier driver, and identifies this client as a driver.

    Raises:
        DeviceAbsent: the address does not exist, cannot be opened, or is in use.
    """
    try:
        if address.startswith("socket://") and urlsplit(address).port is None:
            raise ValueError("a device behind TCP is socket://HOST:PORT")
        port = serial.serial_for_url(address, do_not_open=True, baudrate=BAUD, timeout=0, exclusive=True)
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
    """Close a port and its connection, which the library leaves open where the far side ended or reset it."""
    connection = getattr(port, "_socket", None)
    port.close()
    if connection is not None:
        connection.close()


def _advice(error: Exception) -> str:
    """Return advice about a port that cannot be opened."""
    return {
        errno.EACCES: "; the group `dialout` may open it: deploy/udev/README.md",
        errno.EAGAIN: "; another program has it, such as a running site",
    }.get(getattr(error, "errno", None) or 0, "")
