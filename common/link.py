"""The network link: one CurveZMQ socket for each stream, the remote site bound, operator and observers connected.

All socket options are set before bind and connect: set later they do nothing. Without the doorkeeper a Curve
server would serve any key; with it only those of the allow-list, each where its role lets it.
"""

import contextlib
import ipaddress
from types import TracebackType
from typing import Any, NamedTuple

import zmq
import zmq.utils.monitor

from common.doorkeeper import Doorkeeper
from common.keys import KeyPair, Role, TrustedKeys
from common.packets import MAX_PACKET
from common.streams import STREAMS, Direction, Stream

# Motion and touch have one sender and one reader; only what observers see may have several readers.
_REMOTE_TYPE = {
    Direction.TO_REMOTE: zmq.PULL,
    Direction.TO_OPERATOR: zmq.PUB,
    Direction.TO_OBSERVERS: zmq.PUB,
    Direction.BOTH: zmq.ROUTER,
}
_CLIENT_TYPE = {
    Direction.TO_REMOTE: zmq.PUSH,
    Direction.TO_OPERATOR: zmq.SUB,
    Direction.TO_OBSERVERS: zmq.SUB,
    Direction.BOTH: zmq.DEALER,
}
_MAY_OBSERVE = (Direction.TO_OBSERVERS, Direction.BOTH)
"""What an observer's key opens; requests of an observer are judged by the session."""
_HANDSHAKE_MS = 2000
_CURVE_BYTES = 64
"""Room for what the encryption adds to a packet; the library counts it."""
_MOST_AT_ONCE = 100
_LAST_REQUEST_MS = 100


class LinkProblem(OSError):
    """The link cannot be set up: port in use, or this side's key is not allowed."""


class Received(NamedTuple):
    """A request: which connection it came on, whose key that is (authenticated), and its bytes."""

    who: bytes
    key: str
    packet: bytes


def prepare_socket(socket: "zmq.Socket[bytes]") -> None:
    """Set what all sockets of the link have in common."""
    socket.setsockopt(zmq.LINGER, 0)
    socket.setsockopt(zmq.MAXMSGSIZE, MAX_PACKET + _CURVE_BYTES)
    socket.setsockopt(zmq.HANDSHAKE_IVL, _HANDSHAKE_MS)
    # A peer behind a broken network is dropped after 2 s and found again as soon as the network is back.
    socket.setsockopt(zmq.HEARTBEAT_IVL, 500)
    socket.setsockopt(zmq.HEARTBEAT_TIMEOUT, 2000)
    socket.setsockopt(zmq.CONNECT_TIMEOUT, 1000)
    socket.setsockopt(zmq.RECONNECT_IVL, 50)
    socket.setsockopt(zmq.RECONNECT_IVL_MAX, 500)


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


def receive_requests(socket: "zmq.Socket[bytes]") -> list[Received]:
    """What clients sent to a ROUTER socket, at most 100 at once."""
    found: list[Received] = []
    for _ in range(_MOST_AT_ONCE):
        try:
            frames = socket.recv_multipart(zmq.DONTWAIT, copy=False)
        except zmq.Again:
            break
        if len(frames) == 2:
            found.append(Received(frames[0].bytes, str(frames[1].get("User-Id")), frames[1].bytes))
    return found


def send_answer(socket: "zmq.Socket[bytes]", who: bytes, packet: bytes) -> None:
    """Answer one client of a ROUTER socket; one that is gone, or takes nothing any more, gets nothing."""
    with contextlib.suppress(zmq.Again):
        socket.send_multipart([who, packet], zmq.DONTWAIT)


def check_bind(host: str, trusted: TrustedKeys) -> None:
    """Whether a remote site may bind to `host`.

    Raises:
        LinkProblem: `host` is open to a network and nobody is trusted: keys come first.
        KeyProblem: the list of trusted keys is damaged.
    """
    owners = trusted.owners()
    try:
        loopback = host == "localhost" or ipaddress.ip_address(host).is_loopback
    except ValueError:
        loopback = False
    if not loopback and not owners:
        raise LinkProblem(
            f"{host} is open to a network and {trusted.file} trusts nobody: "
            f"`teletaction keys trust --keys {trusted.folder} -- NAME KEY` first, or bind to 127.0.0.1"
        )


class _Link:
    """Sockets of one side. Sending and receiving never block; only `wait_for_latest` does."""

    def __init__(self) -> None:
        self._context = zmq.Context()
        self._sockets: dict[str, zmq.Socket[bytes]] = {}

    def _socket(self, stream: Stream, kind: int) -> "zmq.Socket[bytes]":
        socket = self._context.socket(kind)
        prepare_socket(socket)
        if stream.latest_only:
            socket.setsockopt(zmq.CONFLATE, 1)
        if kind == zmq.SUB:
            socket.setsockopt(zmq.SUBSCRIBE, b"")
        return socket

    def close(self) -> None:
        """Close all sockets at once, dropping what was not sent."""
        self._context.destroy(linger=0)

    def send_latest(self, stream: str, packet: bytes) -> None:
        """Send on a latest-only stream; an unsent older packet is replaced. To a far side that refused us: nothing."""
        socket = self._sockets.get(stream)
        if socket is not None:
            try:
                socket.send(packet, zmq.DONTWAIT)
            except zmq.Again:
                return

    def receive_latest(self, stream: str) -> bytes | None:
        """The newest unread packet of a latest-only stream."""
        socket = self._sockets.get(stream)
        if socket is None:
            return None
        try:
            return socket.recv(zmq.DONTWAIT)
        except zmq.Again:
            return None

    def wait_for_latest(self, stream: str, seconds: float) -> bytes | None:
        """The newest unread packet of a latest-only stream, or the next one that comes within `seconds`.

        For tools that have nothing else to do: it holds the caller up, and a site's loop must never wait.
        """
        socket = self._sockets.get(stream)
        if socket is None:
            return None
        socket.setsockopt(zmq.RCVTIMEO, round(seconds * 1e3))
        try:
            return socket.recv()
        except zmq.Again:
            return None


class RemoteLink(_Link):
    """The remote site's side: bound, serving trusted keys only."""

    def __init__(self, host: str, base_port: int, keys: KeyPair, trusted: TrustedKeys):
        """Bind all streams.

        Raises:
            LinkProblem: a port is in use, the address is not this machine's, or it is open to a network while nobody
                is trusted.
            KeyProblem: the list of trusted keys is damaged.
        """
        check_bind(host, trusted)
        super().__init__()
        self._host, self._base_port, self._keys, self._trusted = host, base_port, keys, trusted
        self._doorkeeper = Doorkeeper(self._context, self._admits)
        self.handshakes = self._doorkeeper.answers
        """Handshakes so far: `admitted`, `refused`, `too_many`."""
        for stream in STREAMS.values():
            try:
                self._bind(stream)
            except zmq.ZMQError as error:
                self.close()
                raise LinkProblem(f"{self._address(stream)} ({stream.name}): {error.strerror}") from None

    def requests(self, stream: str) -> list[Received]:
        """What clients sent on a request stream, at most 100 at once."""
        socket = self._sockets.get(stream)
        if socket is None:
            self._bind_missing()
            return []
        return receive_requests(socket)

    def answer(self, stream: str, who: bytes, packet: bytes) -> None:
        """Answer one client; one that is gone gets nothing."""
        socket = self._sockets.get(stream)
        if socket is not None:
            send_answer(socket, who, packet)

    def may_operate(self, key: str) -> bool:
        """Whether the owner of this key may be a session's operator."""
        return self._trusted.role(key) is Role.PARTNER

    def recheck_keys(self) -> set[str]:
        """Cut every connection of a key that is no longer trusted; returns these keys.

        The library cannot end one connection of many: the sockets that such a key was admitted to are bound anew, and
        whoever is still trusted is back within a moment. Where the old socket holds its port a little longer, the next
        `requests` tries again.
        """
        revoked = self._doorkeeper.revoked()
        for name in revoked:
            if (socket := self._sockets.pop(name, None)) is not None:
                socket.close(linger=0)
        self._bind_missing()
        return set().union(*revoked.values())

    def _bind_missing(self) -> None:
        for stream in STREAMS.values():
            if stream.name not in self._sockets:
                with contextlib.suppress(zmq.ZMQError):  # the old one still holds the port
                    self._bind(stream)

    def _bind(self, stream: Stream) -> None:
        socket = self._socket(stream, _REMOTE_TYPE[stream.direction])
        serve_curve(socket, self._keys, stream.name)
        try:
            socket.bind(self._address(stream))
        except zmq.ZMQError:
            socket.close(linger=0)
            raise
        self._sockets[stream.name] = socket

    def _address(self, stream: Stream) -> str:
        return f"tcp://{self._host}:{self._base_port + stream.port}"

    def _admits(self, domain: str, key: str) -> bool:
        role = self._trusted.role(key)
        return role is Role.PARTNER or (role is Role.OBSERVER and STREAMS[domain].direction in _MAY_OBSERVE)

    def close(self) -> None:
        """Close all sockets and end the doorkeeper."""
        self._doorkeeper.close()
        super().close()

    def __enter__(self) -> "RemoteLink":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


class OperatorLink(_Link):
    """The side that connects, whenever the remote site is there: an operator or an observer."""

    def __init__(self, host: str, base_port: int, keys: KeyPair, remote_public_key: str, role: Role = Role.PARTNER):
        """Connect this role's streams in the background; raises nothing when the remote site is absent."""
        super().__init__()
        self._host, self._base_port, self._keys, self._remote_key = host, base_port, keys, remote_public_key
        self._streams = [
            stream
            for stream in STREAMS.values()
            if (stream.direction in _MAY_OBSERVE if role is Role.OBSERVER else stream.name != "observed")
        ]
        self._connect()

    def _connect(self) -> None:
        self._monitors: list[zmq.Socket[bytes]] = []
        for stream in self._streams:
            socket = self._socket(stream, _CLIENT_TYPE[stream.direction])
            use_curve(socket, self._keys, self._remote_key)
            if stream.direction is Direction.BOTH:
                # A request to a remote that is not there must fail now, not reach it minutes later.
                socket.setsockopt(zmq.IMMEDIATE, 1)
                socket.setsockopt(zmq.SNDHWM, 8)
            self._monitors.append(socket.get_monitor_socket(zmq.EVENT_HANDSHAKE_FAILED_AUTH))
            socket.connect(f"tcp://{self._host}:{self._base_port + stream.port}")
            self._sockets[stream.name] = socket

    def reconnect(self) -> None:
        """Try again after a refusal: the library itself never does."""
        self._disconnect()
        self._connect()

    def _disconnect(self, linger_ms: int = 0) -> None:
        for socket in self._sockets.values():
            socket.disable_monitor()
        for monitor in self._monitors:
            monitor.close()
        for socket in self._sockets.values():
            socket.close(linger=linger_ms)

    def send(self, stream: str, packet: bytes) -> bool:
        """Send on a request stream; False when there is nobody to send to."""
        try:
            self._sockets[stream].send(packet, zmq.DONTWAIT)
        except zmq.Again:
            return False
        return True

    def receive(self, stream: str) -> list[bytes]:
        """All unread packets of a request stream, at most 100."""
        found: list[bytes] = []
        while len(found) < _MOST_AT_ONCE:
            try:
                found.append(self._sockets[stream].recv(zmq.DONTWAIT))
            except zmq.Again:
                break
        return found

    def key_refused(self) -> bool:
        """Whether the remote site has refused this side's key on any stream since the last call."""
        refused = False
        for monitor in self._monitors:
            while monitor.poll(0):
                event: dict[str, Any] = dict(zmq.utils.monitor.recv_monitor_message(monitor))
                # 300 asks for patience and is tried again by the library; 400 is a refusal.
                final = event["event"] == zmq.EVENT_HANDSHAKE_FAILED_AUTH and event["value"] == 400
                refused = refused or final
        return refused

    def close(self) -> None:
        """Close all sockets, once a last request has left."""
        self._disconnect(_LAST_REQUEST_MS)
        self._context.term()

    def __enter__(self) -> "OperatorLink":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
