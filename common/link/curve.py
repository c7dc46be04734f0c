"""CurveZMQ sockets: their common options, packets with their senders, and the sockets of one side of the link.

All socket options are set before bind and connect; later they have no effect.
"""

import contextlib
import select
from typing import NamedTuple, Self

import zmq

from common.link.keys import KeyPair
from common.link.tcp_connections import connection_number
from common.wire.packets import MAX_PACKET
from common.wire.streams import Stream

MOST_AT_ONCE = 64
"""Maximum number of packets read from one socket in one tick; a socket takes turns among its connections."""
WAITING = 64
"""Maximum number of packets of one connection that wait to be read, or to be sent; beyond it TCP holds the sender."""
SECOND = ", second"
"""What follows a stream's name in the name of its second socket, which carries the same packets."""
REFUSE_S = 10.0
"""Time for which a key is refused at a stream after it sent a message with too many parts, s."""
_STOP = b"estop"
"""Bytes that every request for an emergency stop contains."""
_LONGEST_OF_A_READER = 512
"""Maximum size of a reader's packet, bytes; the longest packet of a handshake has some 300."""
_MOST_PARTS = 64
"""Maximum number of parts of a message that are read at once; a packet has one, with the sender's identity two."""
_MOST_OF_READERS = 8
"""Maximum number of waiting packets of one reader; with 1 the library takes no subscription."""
_READABLE, _EVENTS, _DONTWAIT = int(zmq.POLLIN), int(zmq.EVENTS), int(zmq.DONTWAIT)
_HANDSHAKE_MS = 2000
_UNACKNOWLEDGED_MS = 2000
_CURVE_BYTES = 64
"""Room for the bytes that encryption adds to a packet; the library counts them."""


class LinkProblem(OSError):
    """The link cannot be set up: a port is in use, or this side's key is not allowed."""


class Sender(NamedTuple):
    """Sender of a packet.

    Attributes:
        who: routing identity of the client for the answer; empty on a stream without answers.
        key: public key of the client, authenticated by the handshake.
        connection: number of the TCP connection, which no other one has; 0 where there is none.
    """

    who: bytes
    key: str
    connection: int = 0


Received = tuple[Sender, bytes]
"""A packet with its sender."""


def prepare_socket(socket: "zmq.Socket[bytes]", most_bytes: int = MAX_PACKET) -> None:
    """Set the options that all sockets of the link share; the largest received packet has `most_bytes`."""
    socket.setsockopt(zmq.LINGER, 0)
    socket.setsockopt(zmq.MAXMSGSIZE, most_bytes + _CURVE_BYTES)
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

    Attributes:
        rest_of: a part of a message that has too many, until its end was read; None without one.
    """

    def __init__(self, socket: "zmq.Socket[bytes]") -> None:
        """Read from a socket that has no other reader."""
        self._socket = socket
        news = select.poll()
        news.register(int(socket.getsockopt(zmq.FD)), select.POLLIN)
        self._news = news.poll
        self._look = True
        self.rest_of: zmq.Frame | None = None
        self._most_parts = 1 if socket.getsockopt(zmq.CONFLATE) else _MOST_PARTS

    def stale(self) -> None:
        """Note another use of the socket, such as sending, which may have consumed a signal of the descriptor."""
        self._look = True

    def take(self) -> list[zmq.Frame]:
        """Return the parts of the next packet; empty where none waits, or where its message has too many parts.

        A long message is read in pieces, and dropped. Of a newest-only stream the rest of a message must not be read:
        the library keeps one part, and aborts the process where it finds no further one.
        """
        socket = self._socket
        if not self._look:
            if not self._news(0):
                return []
        elif not int(socket.getsockopt(_EVENTS)) & _READABLE:
            self._look = False
            return []
        self._look = True
        if self.rest_of is not None and self._most_parts == 1:
            return []
        frames: list[zmq.Frame] = []
        try:
            while not frames or frames[-1].more:
                if len(frames) == self._most_parts:
                    self.rest_of = frames[-1]
                    return []
                frames.append(socket.recv(_DONTWAIT, copy=False))
        except zmq.Again:
            return []
        if self.rest_of is not None:
            self.rest_of, frames = None, []
        return frames


def receive_requests(inbox: Inbox, most: int = MOST_AT_ONCE) -> list[Received]:
    """Return requests that clients sent to a ROUTER socket, at most `most`; emergency stops first."""
    found: list[Received] = []
    for _ in range(most):
        if not (frames := inbox.take()):
            break
        if len(frames) == 2:
            found.append((_sender(frames[0].bytes, frames[1]), frames[1].bytes))
    return sorted(found, key=lambda received: may_stop(received[1]), reverse=True) if len(found) > 1 else found


def may_stop(packet: bytes) -> bool:
    """Return whether a packet may be a request for an emergency stop; False is certain."""
    return _STOP in packet


def _sender(who: bytes, frame: zmq.Frame) -> Sender:
    return Sender(who, str(frame.get("User-Id")), connection_number(int(str(frame.get("__fd")))))


def send_answer(socket: "zmq.Socket[bytes]", who: bytes, packet: bytes) -> None:
    """Answer one client of a ROUTER socket; a client that is gone or reads nothing gets no answer."""
    with contextlib.suppress(zmq.Again):
        socket.send_multipart([who, packet], zmq.DONTWAIT)


class CurveSockets:
    """Sockets of one side of the link, by stream. Only `wait_for_latest` blocks."""

    def __init__(self) -> None:
        self._context = zmq.Context()
        self._sockets: dict[str, zmq.Socket[bytes]] = {}
        self._inboxes: dict[str, Inbox] = {}

    def _socket(self, stream: Stream, kind: int) -> "zmq.Socket[bytes]":
        socket = self._context.socket(kind)
        prepare_socket(socket)
        if stream.latest_only:
            socket.setsockopt(zmq.CONFLATE, 1)
        if kind == zmq.SUB:
            socket.setsockopt(zmq.SUBSCRIBE, b"")
        return socket

    def close(self) -> None:
        """Close all sockets at once; drop unsent packets."""
        self._context.destroy(linger=0)

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def send_latest(self, stream: str, packet: bytes) -> None:
        """Send on a latest-only stream, replacing an unsent older packet; does nothing where the far side refused us.

        Where the stream has two sockets, both send the packet.

        A packet that is written just when the one before is read waits for the next write. One of 14 measured bursts of
        300 packets ended so. Therefore these streams never pause, and what must arrive is sent again.
        """
        for name in (stream, stream + SECOND):
            if (socket := self._sockets.get(name)) is not None:
                with contextlib.suppress(zmq.Again):
                    socket.send(packet, _DONTWAIT)

    def newest(self, stream: str) -> list[bytes]:
        """Return the newest unread packet of each socket of a latest-only stream."""
        return [frames[0].bytes for name in (stream, stream + SECOND) if (frames := self._take(name))]

    def receive_latest(self, stream: str) -> bytes | None:
        """Return the newest unread packet of a latest-only stream; None where there is none."""
        frames = self._take(stream)
        return frames[0].bytes if frames else None

    def newest_of_each(self, stream: str) -> list[Received]:
        """Return the newest unread packet of each connection of a latest-only stream, at most MOST_AT_ONCE in all."""
        found: dict[int, Received] = {}
        for _ in range(MOST_AT_ONCE):
            if not (frames := self._take(stream)):
                break
            sender = _sender(b"", frames[0])
            found[sender.connection] = sender, frames[0].bytes
        return list(found.values())

    def _take(self, stream: str) -> list[zmq.Frame]:
        """Return the parts of a stream's next packet; empty where there is none."""
        inbox = self._inboxes.get(stream)
        if inbox is None:
            return []
        frames = inbox.take()
        self._check(stream, inbox)
        return frames

    def _check(self, stream: str, inbox: Inbox) -> None:
        """Replace the socket of a stream on which a message with too many parts came, because it may not be read."""
        if inbox.rest_of is not None:
            self._replace(stream, inbox.rest_of)

    def _replace(self, stream: str, part: zmq.Frame) -> None:
        """Replace a stream's socket, on which this part of a message came."""
        raise NotImplementedError

    def wait_for_latest(self, stream: str, seconds: float) -> bytes | None:
        """Return the newest unread packet of a latest-only stream, or the next one within `seconds`, s; else None.

        It blocks the caller. It is for tools; a site's loop must never wait.
        """
        socket = self._sockets.get(stream)
        if socket is None:
            return None
        self._inboxes[stream].stale()
        socket.setsockopt(zmq.RCVTIMEO, round(seconds * 1e3))
        try:
            return socket.recv()
        except zmq.Again:
            return None
