"""The network link: one CurveZMQ socket for each stream, the remote site bound, the operator connected.

All socket options are set before bind and connect: set later they do nothing. Without the
authenticator a Curve server would serve any key; with it only those of the allow-list.
"""

import contextlib
import logging
from types import TracebackType
from typing import Any

import zmq
import zmq.utils.monitor
from zmq.auth.thread import ThreadAuthenticator

from common.keys import KeyPair, TrustedKeys, fingerprint
from common.packets import MAX_PACKET
from common.streams import STREAMS, Direction, Stream

log = logging.getLogger(__name__)

# Motion has one sender and one reader; touch may have observers beside the operator.
_REMOTE_TYPE = {Direction.TO_REMOTE: zmq.PULL, Direction.TO_OPERATOR: zmq.PUB, Direction.BOTH: zmq.ROUTER}
_OPERATOR_TYPE = {Direction.TO_REMOTE: zmq.PUSH, Direction.TO_OPERATOR: zmq.SUB, Direction.BOTH: zmq.DEALER}


class LinkProblem(OSError):
    """The link cannot be set up: port in use, or this side's key is not allowed."""


class _AllowList:
    """What the authenticator asks about each key that knocks."""

    def __init__(self, trusted: TrustedKeys):
        self._trusted = trusted

    def callback(self, domain: str, key: str | bytes) -> bool:
        text = key.decode() if isinstance(key, bytes) else key
        allowed = self._trusted.allows(text)
        if not allowed:
            log.warning("refused a connection: key %s is not trusted", fingerprint(text))
        return allowed


class _Link:
    """Sockets of one side. Sending and receiving never block."""

    def __init__(self) -> None:
        self._context = zmq.Context()
        self._sockets: dict[str, zmq.Socket[bytes]] = {}

    def _socket(self, stream: Stream, kind: int) -> "zmq.Socket[bytes]":
        socket = self._context.socket(kind)
        socket.setsockopt(zmq.LINGER, 0)
        socket.setsockopt(zmq.MAXMSGSIZE, MAX_PACKET)
        socket.setsockopt(zmq.HEARTBEAT_IVL, 500)
        socket.setsockopt(zmq.HEARTBEAT_TIMEOUT, 2000)
        socket.setsockopt(zmq.RECONNECT_IVL, 50)
        socket.setsockopt(zmq.RECONNECT_IVL_MAX, 500)
        if stream.latest_only:
            socket.setsockopt(zmq.CONFLATE, 1)
        if kind == zmq.SUB:
            socket.setsockopt(zmq.SUBSCRIBE, b"")
        self._sockets[stream.name] = socket
        return socket

    def close(self) -> None:
        """Close all sockets at once, dropping what was not sent."""
        self._context.destroy(linger=0)

    def send_latest(self, stream: str, packet: bytes) -> None:
        """Send on a latest-only stream; an unsent older packet is replaced. To a far side that refused us: nothing."""
        with contextlib.suppress(zmq.Again):
            self._sockets[stream].send(packet, zmq.DONTWAIT)

    def receive_latest(self, stream: str) -> bytes | None:
        """The newest unread packet of a latest-only stream."""
        try:
            return self._sockets[stream].recv(zmq.DONTWAIT)
        except zmq.Again:
            return None


class RemoteLink(_Link):
    """The remote site's side: bound, serving trusted keys only."""

    def __init__(self, host: str, base_port: int, keys: KeyPair, trusted: TrustedKeys):
        """Bind all streams.

        Raises:
            LinkProblem: a port is in use or the address is not this machine's.
        """
        super().__init__()
        self._authenticator = ThreadAuthenticator(self._context)
        self._authenticator.start()
        self._authenticator.configure_curve_callback("*", credentials_provider=_AllowList(trusted))
        for stream in STREAMS.values():
            socket = self._socket(stream, _REMOTE_TYPE[stream.direction])
            socket.setsockopt(zmq.CURVE_SERVER, 1)
            socket.setsockopt(zmq.CURVE_SECRETKEY, keys.secret)
            socket.setsockopt(zmq.CURVE_PUBLICKEY, keys.public.encode())
            address = f"tcp://{host}:{base_port + stream.port}"
            try:
                socket.bind(address)
            except zmq.ZMQError as error:
                self.close()
                raise LinkProblem(f"{address} ({stream.name}): {error.strerror}") from None

    def requests(self, stream: str) -> list[tuple[bytes, bytes]]:
        """What clients sent on a request stream: (who, packet) pairs, at most 100 at once."""
        found: list[tuple[bytes, bytes]] = []
        while len(found) < 100:
            try:
                frames = self._sockets[stream].recv_multipart(zmq.DONTWAIT)
            except zmq.Again:
                break
            if len(frames) == 2:
                found.append((frames[0], frames[1]))
        return found

    def answer(self, stream: str, who: bytes, packet: bytes) -> None:
        """Answer one client; one that is gone gets nothing."""
        try:
            self._sockets[stream].send_multipart([who, packet], zmq.DONTWAIT)
        except zmq.Again:
            log.warning("an answer on %s found no room and was dropped", stream)

    def close(self) -> None:
        """Close all sockets and end the authenticator."""
        self._authenticator.stop()
        super().close()

    def __enter__(self) -> "RemoteLink":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


class OperatorLink(_Link):
    """The operator site's side: connects whenever the remote site is there."""

    def __init__(self, host: str, base_port: int, keys: KeyPair, remote_public_key: str):
        """Connect all streams in the background; raises nothing when the remote site is absent."""
        super().__init__()
        for stream in STREAMS.values():
            socket = self._socket(stream, _OPERATOR_TYPE[stream.direction])
            socket.setsockopt(zmq.CURVE_SERVERKEY, remote_public_key.encode())
            socket.setsockopt(zmq.CURVE_SECRETKEY, keys.secret)
            socket.setsockopt(zmq.CURVE_PUBLICKEY, keys.public.encode())
            if stream.direction is Direction.BOTH:
                # A request to a remote that is not there must fail now, not reach it minutes later.
                socket.setsockopt(zmq.IMMEDIATE, 1)
                socket.setsockopt(zmq.SNDHWM, 8)
            if stream.name == "control":
                self._monitor = socket.get_monitor_socket(zmq.EVENT_HANDSHAKE_FAILED_AUTH)
            socket.connect(f"tcp://{host}:{base_port + stream.port}")

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
        while len(found) < 100:
            try:
                found.append(self._sockets[stream].recv(zmq.DONTWAIT))
            except zmq.Again:
                break
        return found

    def key_refused(self) -> bool:
        """Whether the remote site has refused this side's key since the last call."""
        refused = False
        while self._monitor.poll(0):
            event: dict[str, Any] = dict(zmq.utils.monitor.recv_monitor_message(self._monitor))
            refused = refused or event["event"] == zmq.EVENT_HANDSHAKE_FAILED_AUTH
        return refused

    def close(self) -> None:
        """Close all sockets at once."""
        self._sockets["control"].disable_monitor()
        self._monitor.close()
        super().close()

    def __enter__(self) -> "OperatorLink":
        return self

    def __exit__(
        self, kind: type[BaseException] | None, value: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()
