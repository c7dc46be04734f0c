"""CurveZMQ sockets: the options that all of this project's sockets share, and requests with their answers.

All socket options are set before bind and connect: set later they do nothing.
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
"""Packets that are read from one socket in one tick; a socket takes turns among its connections."""
WAITING = 64
"""Packets of one connection that wait to be read, and answers that wait to be sent to it; then TCP holds the sender."""
_STOP = b"estop"
"""Stands in every request for an emergency stop."""
_TOPICS_COUNT = 116
"""ZMQ_TOPICS_COUNT of libzmq from 4.3.5 on, which pyzmq does not name."""
_MOST_OF_A_READER = 2048
"""Bytes that a reader sends at most: a handshake of 700, a subscription to everything, and its end."""
_LONGEST_OF_A_READER = 512
"""Bytes; the longest packet of a handshake has some 300."""
_MOST_OF_READERS = 8
"""Packets of one reader that wait; with 1 the library takes no subscription."""
_BYTES_RECEIVED = 128
"""Where struct tcp_info has tcpi_bytes_received, 8 bytes, on every Linux from 4.1 on."""
_READABLE, _EVENTS, _DONTWAIT = int(zmq.POLLIN), int(zmq.EVENTS), int(zmq.DONTWAIT)
_HANDSHAKE_MS = 2000
_UNACKNOWLEDGED_MS = 2000
_CURVE_BYTES = 64
"""Room for what the encryption adds to a packet; the library counts it."""


class LinkProblem(OSError):
    """The link cannot be set up: port in use, or this side's key is not allowed."""


class Received(NamedTuple):
    """A packet of a client.

    Attributes:
        who: routing identity of the client, for the answer; empty on a stream without answers.
        key: public key of the client, as the handshake authenticated it.
        packet: the bytes.
        connection: file descriptor of the TCP connection in this process; 0 where there is none.
    """

    who: bytes
    key: str
    packet: bytes
    connection: int = 0


def prepare_socket(socket: "zmq.Socket[bytes]") -> None:
    """Set what all sockets of the link have in common."""
    socket.setsockopt(zmq.LINGER, 0)
    socket.setsockopt(zmq.MAXMSGSIZE, MAX_PACKET + _CURVE_BYTES)
    socket.setsockopt(zmq.HANDSHAKE_IVL, _HANDSHAKE_MS)
    socket.setsockopt(zmq.RCVHWM, WAITING)
    socket.setsockopt(zmq.SNDHWM, WAITING)
    # ZMTP heartbeats stay off: with a receive queue that is full they abort the process (libzmq issues 3937, 4364). A
    # peer behind a broken network, or one that reads nothing, is dropped by TCP: after data without acknowledgement,
    # or after probes without an answer.
    socket.setsockopt(zmq.TCP_KEEPALIVE, 1)
    socket.setsockopt(zmq.TCP_KEEPALIVE_IDLE, 1)
    socket.setsockopt(zmq.TCP_KEEPALIVE_INTVL, 1)
    socket.setsockopt(zmq.TCP_MAXRT, _UNACKNOWLEDGED_MS)
    socket.setsockopt(zmq.CONNECT_TIMEOUT, 1000)
    # The library waits once or twice as long and shakes hands; outputs end after 100 ms without packets.
    socket.setsockopt(zmq.RECONNECT_IVL, 20)
    socket.setsockopt(zmq.RECONNECT_IVL_MAX, 500)


def prepare_publisher(socket: "zmq.Socket[bytes]") -> None:
    """Let readers of a PUB socket send no more at once than a handshake and a subscription; before it is bound."""
    socket.setsockopt(zmq.MAXMSGSIZE, _LONGEST_OF_A_READER)
    socket.setsockopt(zmq.RCVHWM, _MOST_OF_READERS)


def serve_curve(socket: "zmq.Socket[bytes]", keys: KeyPair, domain: str) -> None:
    """Make a socket a Curve server whose doorkeeper is asked for `domain`."""
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
    """The packets that wait to be read from one socket.

    The socket's descriptor becomes readable with news; polling it takes a fifth of the time of asking the library. It
    signals each piece of news once. So the library is asked until it says that nothing waits, and after `stale`.
    """

    __slots__ = ("_look", "_news", "_socket")

    def __init__(self, socket: "zmq.Socket[bytes]") -> None:
        """Read from a socket that nobody else reads from."""
        self._socket = socket
        news = select.poll()
        news.register(int(socket.getsockopt(zmq.FD)), select.POLLIN)
        self._news = news.poll
        self._look = True

    def stale(self) -> None:
        """Something else was done with the socket, such as sending: that may have used the news up."""
        self._look = True

    def take(self) -> list[zmq.Frame]:
        """The parts of the next packet; none where none waits."""
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
    """What clients sent to a ROUTER socket, at most `most`; emergency stops first."""
    found: list[Received] = []
    for _ in range(most):
        if not (frames := inbox.take()):
            break
        if len(frames) == 2:
            found.append(_received(frames[0].bytes, frames[1]))
    return sorted(found, key=may_stop, reverse=True) if len(found) > 1 else found


def may_stop(received: Received) -> bool:
    """Whether a packet may be a request for an emergency stop; False is certain."""
    return _STOP in received.packet


def receive_newest(inbox: Inbox) -> list[Received]:
    """The newest unread packet of each connection of a CONFLATE socket, at most MOST_AT_ONCE in all."""
    found: dict[int, Received] = {}
    for _ in range(MOST_AT_ONCE):
        if not (frames := inbox.take()):
            break
        received = _received(b"", frames[0])
        found[received.connection] = received
    return list(found.values())


def is_open(connection: int, local_port: int) -> bool:
    """Whether a descriptor of this process is a TCP connection that was accepted at `local_port`."""
    with _tcp_connection(connection, local_port) as end:
        return end is not None


def subscriptions(socket: "zmq.Socket[bytes]") -> int:
    """How many subscriptions that it did not have before a PUB socket got; those of a closed connection count on."""
    return int(socket.getsockopt(_TOPICS_COUNT))


def end_strange_readers(local_port: int) -> int:
    """End each connection to a port of a PUB socket that sent more than one reader has to say; returns how many."""
    ended = 0
    for name in os.listdir("/proc/self/fd"):
        with _tcp_connection(int(name), local_port) as end, contextlib.suppress(OSError):
            if end is not None and _received_bytes(end) > _MOST_OF_A_READER:
                end.shutdown(sockets.SHUT_RDWR)
                ended += 1
    return ended


def _received_bytes(end: sockets.socket) -> int:
    """What a TCP connection has received since it was made."""
    told = end.getsockopt(sockets.IPPROTO_TCP, sockets.TCP_INFO, _BYTES_RECEIVED + 8)
    return int.from_bytes(told[_BYTES_RECEIVED:], sys.byteorder)


def end_connection(connection: int, local_port: int) -> None:
    """End one TCP connection of this process; libzmq finds it closed and the peer connects again.

    The descriptor may have been closed and reused since: unless it is a TCP socket of `local_port`, nothing happens.

    Args:
        connection: file descriptor of the connection.
        local_port: port that the connection was accepted at.
    """
    with _tcp_connection(connection, local_port) as end, contextlib.suppress(OSError):
        if end is not None:
            end.shutdown(sockets.SHUT_RDWR)


@contextlib.contextmanager
def _tcp_connection(connection: int, local_port: int) -> Iterator[sockets.socket | None]:
    """A second descriptor of a connection that was accepted at `local_port`; None where it is something else."""
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
    """Answer one client of a ROUTER socket; one that is gone, or takes nothing any more, gets nothing."""
    with contextlib.suppress(zmq.Again):
        socket.send_multipart([who, packet], zmq.DONTWAIT)
