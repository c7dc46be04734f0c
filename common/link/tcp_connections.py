"""TCP connections that sockets of the library have accepted in this process; the library cannot end a single one."""

import contextlib
import os
import socket as sockets
import sys
from collections.abc import Collection, Iterator

_BYTES_RECEIVED = 128
"""Offset of tcpi_bytes_received, 8 bytes, in struct tcp_info, bytes, on every Linux from 4.1 on."""
_DESCRIPTOR_BITS = 32
"""Number of low bits of a connection's number that hold its descriptor; above them is the number of its socket."""


def connection_number(descriptor: int) -> int:
    """Return a number of an open socket that no later socket with the same descriptor has; 0 where it is closed."""
    try:
        return os.fstat(descriptor).st_ino << _DESCRIPTOR_BITS | descriptor
    except OSError:
        return 0


def is_open(connection: int, local_port: int) -> bool:
    """Return whether a connection, by its number, is open and was accepted at `local_port`."""
    with _numbered(connection, local_port) as end:
        return end is not None


def open_connections(local_port: int) -> int:
    """Return the number of connections accepted at `local_port` that this process holds."""
    return sum(1 for _ in _accepted_at(local_port))


def end_talkers(local_port: int, most_bytes: int) -> int:
    """End each connection accepted at `local_port` that sent more than `most_bytes`; return how many."""
    ended = 0
    for end in _accepted_at(local_port):
        with contextlib.suppress(OSError):
            if _received_bytes(end) > most_bytes:
                end.shutdown(sockets.SHUT_RDWR)
                ended += 1
    return ended


def socket_of(connection: int) -> int:
    """Return the number of a connection's socket, which is the same for all descriptors of it."""
    return connection >> _DESCRIPTOR_BITS


def received_bytes(local_port: int) -> dict[int, int]:
    """Return how many bytes each socket accepted at `local_port` has received since it was made."""
    found = {}
    for end in _accepted_at(local_port):
        with contextlib.suppress(OSError):
            found[os.fstat(end.fileno()).st_ino] = _received_bytes(end)
    return found


def end_sockets(local_port: int, which: Collection[int]) -> None:
    """End the connections of these sockets accepted at `local_port`."""
    for end in _accepted_at(local_port):
        with contextlib.suppress(OSError):
            if os.fstat(end.fileno()).st_ino in which:
                end.shutdown(sockets.SHUT_RDWR)


def _accepted_at(local_port: int) -> Iterator[sockets.socket]:
    """Yield a second descriptor of each connection accepted at `local_port`; it is closed after its turn.

    Yields none where no descriptor is free, because strangers hold all of them.
    """
    try:
        names = os.listdir("/proc/self/fd")
    except OSError:
        return
    for name in names:
        with _tcp_connection(int(name), local_port) as end:
            if end is not None:
                yield end


def _received_bytes(end: sockets.socket) -> int:
    """Return how many bytes a TCP connection has received since it was made."""
    info = end.getsockopt(sockets.IPPROTO_TCP, sockets.TCP_INFO, _BYTES_RECEIVED + 8)
    return int.from_bytes(info[_BYTES_RECEIVED:], sys.byteorder)


def end_connection(connection: int, local_port: int) -> None:
    """End one TCP connection of this process, by its number; libzmq finds it closed, and the peer connects again.

    Nothing happens where it is closed, or was not accepted at `local_port`.
    """
    with _numbered(connection, local_port) as end, contextlib.suppress(OSError):
        if end is not None:
            end.shutdown(sockets.SHUT_RDWR)


@contextlib.contextmanager
def _numbered(connection: int, local_port: int) -> Iterator[sockets.socket | None]:
    """Yield a second descriptor of the connection with a number; None where it is closed or not of `local_port`."""
    with _tcp_connection(connection & (1 << _DESCRIPTOR_BITS) - 1, local_port) as end:
        yield end if end is not None and os.fstat(end.fileno()).st_ino == socket_of(connection) else None


@contextlib.contextmanager
def _tcp_connection(number: int, local_port: int) -> Iterator[sockets.socket | None]:
    """Yield a second descriptor of a connection accepted at `local_port`; None where `number` is something else."""
    try:
        descriptor = os.dup(number)
    except OSError:
        yield None
        return
    try:
        end = sockets.socket(fileno=descriptor)
    except OSError:
        os.close(descriptor)
        yield None
        return
    with end:
        try:
            ours = end.type == sockets.SOCK_STREAM and end.getsockname()[1:2] == (local_port,)
            end.getpeername()
        except OSError:
            ours = False
        yield end if ours else None
