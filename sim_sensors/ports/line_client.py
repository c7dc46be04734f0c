"""TCP connection to a module's line, with a check that the driver is still present."""

import fcntl
import socket
import struct
import termios

from common.limits import MODULE_TIMEOUT_S


class LineClient:
    """Connection of one driver. The driver is present while it sends, or while its system acknowledges bytes."""

    def __init__(self, connection: socket.socket, now_s: float) -> None:
        """Take a connection that was accepted at `now_s`, s."""
        self.connection = connection
        self._there_s = now_s
        self._sent = self._taken = 0

    def send(self, data: bytes) -> int:
        """Send without blocking; return the number of bytes sent.

        Raises:
            OSError: the connection has ended, or takes nothing at the moment.
        """
        sent = self.connection.send(data)
        self._sent += sent
        return sent

    def heard(self, now_s: float) -> None:
        """Record that the driver sent bytes at `now_s`."""
        self._there_s = now_s

    def live(self, now_s: float) -> bool:
        """Return whether the driver was present within the last `MODULE_TIMEOUT_S`; call it every few ms."""
        under_way = struct.unpack("i", fcntl.ioctl(self.connection, termios.TIOCOUTQ, bytes(4)))[0]
        taken = self._sent - under_way
        if taken > self._taken or not under_way:
            self._there_s = now_s
        self._taken = taken
        return now_s - self._there_s < MODULE_TIMEOUT_S
