"""TCP ports on loopback that were free a moment ago."""

import socket
from contextlib import ExitStack

from common.wire.streams import STREAMS

HOST = "127.0.0.1"


def free_port() -> int:
    """One port."""
    with socket.create_server((HOST, 0)) as server:
        port: int = server.getsockname()[1]
        return port


def free_ports() -> int:
    """First of as many ports in a row as a link has."""
    for _ in range(100):
        with socket.create_server((HOST, 0)) as first, ExitStack() as others:
            port: int = first.getsockname()[1]
            try:
                for number in range(port + 1, port + len(STREAMS)):
                    others.enter_context(socket.create_server((HOST, number)))
            except (OSError, OverflowError):
                continue
            return port
    raise AssertionError("no free ports in a row")
