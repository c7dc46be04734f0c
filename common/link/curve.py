"""CurveZMQ sockets: their common options, and requests with answers.

All socket options are set before bind and connect; later they have no effect.
"""

import contextlib
import os
import select
import socket as sockets
import sys
from collections.abc import Iterator
from typing import NamedTuple

import zmq

from common.link.keys import KeyPair
from common.wire.packets import MAX_PACKET

MOST_AT_ONCE = 64
"""Maximum number of packets read from one socket in one tick; a socket takes turns among its connections."""
WAITING = 64
"""Maximum number of packets of one connection that wait to be read, or to be sent; beyond it TCP holds the sender."""
_STOP = b"estop"
"""Bytes that every request for an emergency stop contains."""
_TOPICS_COUNT = 116
"""Option ZMQ_TOPICS_COUNT of libzmq from 4.3.5 on, which pyzmq does not name."""
_MOST_OF_A_READER = 2048
"""Maximum number of bytes that a reader sends: a handshake of 700, a subscription to everything, and its end."""
_LONGEST_OF_A_READER = 512
"""Maximum size of a reader's packet, bytes; the longest packet of a handshake has some 300."""
_MOST_OF_READERS = 8
"""Maximum number of waiting packets of one reader; with 1 the library takes no subscription."""
_BYTES_RECEIVED = 128
"""Offset of tcpi_bytes_received, 8 bytes, in struct tcp_info, bytes, on every Linux from 4.1 on."""
_READABLE, _EVENTS, _DONTWAIT = int(zmq.POLLIN), int(zmq.EVENTS), int(zmq.DONTWAIT)
_HANDSHAKE_MS = 2000
_UNACKNOWLEDGED_MS = 2000
_CURVE_BYTES = 64
"""Room for the bytes that encryption adds to a packet; the library counts them."""


class LinkProblem(OSError):
    """The link cannot be set up: a port is in use, or this side's key is not allowed."""


class Received(NamedTuple):
    """A packet of a client.

    Attributes:
        who: routing identity of the client for the answer; empty on a stream without answers.
        key: public key of the client, authenticated by the handshake.
        packet: the bytes.
        connection: file descriptor of the TCP connection in this process; 0 where there is none.
    """

    who: bytes
    key: str
    packet: bytes
    connection: int = 0


def prepare_socket(socket: "zmq.Socket[bytes]") -> None:
    """Set the options that all sockets of the link share."""
    socket.setsockopt(zmq.LINGER, 0)
    socket.setsockopt(zmq.MAXMSGSIZE, MAX_PACKET + _CURVE_BYTES)
    socket.setsockopt(zmq.HANDSHAKE_IVL, _HANDSHAKE_MS)
    socket.setsockopt(zmq.RCVHWM, WAITING)
    socket.setsockopt(zmq.SNDHWM, WAITING)
    # ZMTP heartbeats stay off: with a full receive queue they abort the process (libzmq issues 3937, 4364). TCP drops a
    # peer behind a broken network, or one that reads nothing: after unacknowledged data, or after probes without an
    # answer.
    socket.setsockopt(zmq.TCP_KEEPALIVE, 1)
    socket.setsockopt(zmq.TCP_KEEPALIVE_IDLE, 1)
    socket.setsockopt(zmq.TCP_KEEPALIVE_INTVL, 1)
    socket.setsockopt(zmq.TCP_MAXRT, _UNACKNOWLEDGED_MS)
    socket.setsockopt(zmq.CONNECT_TIMEOUT, 1000)
    # The library waits once or twice this time and repeats the handshake; outputs end after 100 ms without packets.
    socket.setsockopt(zmq.RECONNECT_IVL, 20)
    socket.setsockopt(zmq.RECONNECT_IVL_MAX, 500)


def prepare_publisher(socket: "zmq.Socket[bytes]") -> None:
    """Limit what readers of a PUB socket send at once to a handshake and a subscription; call it before bind."""
    socket.setsockopt(zmq.MAXMSGSIZE, _LONGEST_OF_A_READER)
    socket.setsockopt(zmq.RCVHWM, _MOST_OF_READERS)


def serve_curve(socket: "zmq.Socket[bytes]", keys: KeyPair, domain: str) -> None:
    """Make a socket a Curve server; the authenticator decides who may connect to `domain`."""
    socket.setsockopt(zmq.CURVE_SERVER, 1)
    socket.setsockopt(zmq.CURVE_SECRETKEY, keys.secret)
    socket.setsockopt(zmq.CURVE_PUBLICKEY, keys.public.encode())
    socket.setsockopt_string(zmq.ZAP_DOMAIN, domain)


def use_curve(socket: "zmq.Socket[bytes]", keys: KeyPair, server_public_key: str) -> None:
    """Make a socket a Curve client of the server with this public key."""
    socket.setsockopt(zmq.CURVE_SERVERKEY, server_public_key.encode())
    socket.setsockopt(zmq.CURVE_SECRETKEY, keys.secret)
    socket.setsockopt(zmq.CURVE_PUBLICKEY, keys.public.encode())


class Inbox:
    """Unread packets of one socket.

    The socket's descriptor becomes readable when its state changes; polling it takes a fifth of the time of asking the
    library. It signals each change once. Therefore the library is asked until no packet waits, and after `stale`.
    """

    __slots__ = ("_look", "_news", "_socket")

    def __init__(self, socket: "zmq.Socket[bytes]") -> None:
        """Read from a socket that has no other reader."""
        self._socket = socket
        news = select.poll()
        news.register(int(socket.getsockopt(zmq.FD)), select.POLLIN)
        self._news = news.poll
        self._look = True

    def stale(self) -> None:
        """Note another use of the socket, such as sending, which may have consumed a signal of the descriptor."""
        self._look = True

    def take(self) -> list[zmq.Frame]:
        """Return the parts of the next packet; empty where no packet waits."""
        socket = self._socket
        if not self._look:
            if not self._news(0):
                return []
        elif not int(socket.getsockopt(_EVENTS)) & _READABLE:
            self._look = False
            return []
        self._look = True
        try:
            frames = [socket.recv(_DONTWAIT, copy=False)]
            while frames[-1].more:
                frames.append(socket.recv(_DONTWAIT, copy=False))
        except zmq.Again:
            return []
        return frames


def receive_requests(inbox: Inbox, most: int = MOST_AT_ONCE) -> list[Received]:
    """Return requests that clients sent to a ROUTER socket, at most `most`; emergency stops first."""
    found: list[Received] = []
    for _ in range(most):
        if not (frames := inbox.take()):
            break
        if len(frames) == 2:
            found.append(_received(frames[0].bytes, frames[1]))
    return sorted(found, key=may_stop, reverse=True) if len(found) > 1 else found


def may_stop(received: Received) -> bool:
    """Return whether a packet may be a request for an emergency stop; False is certain."""
    return _STOP in received.packet


def receive_newest(inbox: Inbox) -> list[Received]:
    """Return the newest unread packet of each connection of a CONFLATE socket, at most MOST_AT_ONCE in all."""
    found: dict[int, Received] = {}
    for _ in range(MOST_AT_ONCE):
        if not (frames := inbox.take()):
            break
        received = _received(b"", frames[0])
        found[received.connection] = received
    return list(found.values())


def is_open(connection: int, local_port: int) -> bool:
    """Return whether a descriptor of this process is a TCP connection accepted at `local_port`."""
    with _tcp_connection(connection, local_port) as end:
        return end is not None


def subscriptions(socket: "zmq.Socket[bytes]") -> int:
    """Return how many different subscriptions a PUB socket has received, those of closed connections included."""
    return int(socket.getsockopt(_TOPICS_COUNT))


def end_strange_readers(local_port: int) -> int:
    """End each connection to a PUB socket's port that sent more bytes than a reader needs; return how many."""
    ended = 0
    for name in os.listdir("/proc/self/fd"):
        with _tcp_connection(int(name), local_port) as end, contextlib.suppress(OSError):
            if end is not None and _received_bytes(end) > _MOST_OF_A_READER:
                end.shutdown(sockets.SHUT_RDWR)
                ended += 1
    return ended


def _received_bytes(end: sockets.socket) -> int:
    """Return how many bytes a TCP connection has received since it was made."""
    info = end.getsockopt(sockets.IPPROTO_TCP, sockets.TCP_INFO, _BYTES_RECEIVED + 8)
    return int.from_bytes(info[_BYTES_RECEIVED:], sys.byteorder)


def end_connection(connection: int, local_port: int) -> None:
    """End one TCP connection of this process; libzmq finds it closed, and the peer connects again.

    The descriptor may have been closed and reused. Nothing happens unless it is a TCP socket of `local_port`.

    Args:
        connection: file descriptor of the connection.
        local_port: port at which the connection was accepted.
    """
    with _tcp_connection(connection, local_port) as end, contextlib.suppress(OSError):
        if end is not None:
            end.shutdown(sockets.SHUT_RDWR)


@contextlib.contextmanager
def _tcp_connection(connection: int, local_port: int) -> Iterator[sockets.socket | None]:
    """Yield a second descriptor of a connection accepted at `local_port`; None where it is something else."""
    try:
        descriptor = os.dup(connection)
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


def _received(who: bytes, frame: zmq.Frame) -> Received:
    return Received(who, str(frame.get("User-Id")), frame.bytes, int(str(frame.get("__fd"))))


def send_answer(socket: "zmq.Socket[bytes]", who: bytes, packet: bytes) -> None:
    """Answer one client of a ROUTER socket; a client that is gone or reads nothing gets no answer."""
    with contextlib.suppress(zmq.Again):
        socket.send_multipart([who, packet], zmq.DONTWAIT)
