"""TCP as the line to a device: nothing waits long in it, and it ends by itself when the far side is dead."""

import socket

DEAD_S = 3
"""A far side without power or cable, or that has read nothing for this long, is lost; TCP alone might wait for ever."""
UNREAD_BYTES = 8192
"""What a stalled far side has not taken would be old when it goes on: no more than this is kept for it here."""
_OPTIONS = {
    "TCP_KEEPIDLE": 1,
    "TCP_KEEPINTVL": 1,
    "TCP_KEEPCNT": DEAD_S - 1,
    "TCP_USER_TIMEOUT": DEAD_S * 1000,
}
"""How soon, as Linux is told; a system without an option keeps its own times."""


def tune(connection: socket.socket) -> None:
    """Set a connection up as the line to a device."""
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, UNREAD_BYTES)
    # A command must not wait until the device has acknowledged the one before.
    connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
    for name, value in _OPTIONS.items():
        if hasattr(socket, name):
            connection.setsockopt(socket.IPPROTO_TCP, getattr(socket, name), value)
