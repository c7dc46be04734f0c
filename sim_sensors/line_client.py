"""One TCP connection to a module's line, and whether a driver is still at its far end."""

import fcntl
import socket
import struct
import termios

from common.limits import MODULE_TIMEOUT_S


class LineClient:
    """A driver is there as long as it sends, or its system acknowledges what it was sent."""

    def __init__(self, connection: socket.socket, now_s: float) -> None:
        """A connection that was admitted at `now_s`, s."""
        self.connection = connection
        self._there_s = now_s
        self._sent = self._taken = 0

    def send(self, data: bytes) -> int:
        """Send what goes without waiting; returns how many bytes.

        Raises:
            OSError: the connection has ended, or takes nothing at the moment.
        """
        sent = self.connection.send(data)
        self._sent += sent
        return sent

    def heard(self, now_s: float) -> None:
        """It sent something."""
        self._there_s = now_s

    def live(self, now_s: float) -> bool:
        """Whether it was there within the time in which a module waits for commands; ask it every few ms."""
        under_way = struct.unpack("i", fcntl.ioctl(self.connection, termios.TIOCOUTQ, bytes(4)))[0]
        taken = self._sent - under_way
        if taken > self._taken or not under_way:
            self._there_s = now_s
        self._taken = taken
        return now_s - self._there_s < MODULE_TIMEOUT_S
