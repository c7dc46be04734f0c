"""Sets the TCP options for a line to a device: short delays, and an end when the far side is dead."""

import socket

DEAD_S = 3
"""Time after which a far side without power, cable or reads counts as lost, s; TCP alone may wait without a limit."""
UNREAD_BYTES = 8192
"""Size of the send buffer, bytes. More data would be outdated when a stalled far side reads again."""
_OPTIONS = {
    "TCP_KEEPIDLE": 1,
    "TCP_KEEPINTVL": 1,
    "TCP_KEEPCNT": DEAD_S - 1,
    "TCP_USER_TIMEOUT": DEAD_S * 1000,
}
"""Socket options for DEAD_S, by their Linux names; a system without an option keeps its own times."""


def tune(connection: socket.socket) -> None:
    """Set a connection up as a line to a device."""
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, UNREAD_BYTES)
    # A command must not wait for the acknowledgement of the command before.
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
    for name, value in _OPTIONS.items():
        if hasattr(socket, name):
            connection.setsockopt(socket.IPPROTO_TCP, getattr(socket, name), value)
