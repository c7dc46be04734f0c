"""The network link: one CurveZMQ socket for each stream; the remote site binds, operator and observers connect.

A Curve server alone would serve any key. The authenticator admits only keys of the allow-list, each to the streams
that its role may use.
"""

import contextlib
import errno
import itertools
import logging
import time
from typing import Any

import zmq
import zmq.utils.monitor

from common.link.authenticator import MOST_FOR_OBSERVERS, Authenticator
from common.link.bind_address import check_bind
from common.link.curve import (
    MOST_AT_ONCE,
    REFUSE_S,
    SECOND,
    CurveSockets,
    Inbox,
    LinkProblem,
    Received,
    Sender,
    prepare_publisher,
    receive_requests,
    send_answer,
    serve_curve,
    use_curve,
)
from common.link.endless_messages import EndlessMessages
from common.link.host_name import Resolver, is_ipv6, tcp_endpoint
from common.link.keys import KeyPair, Role, TrustedKeys, fingerprint
from common.link.rate_limiter import RateLimiter
from common.link.subscriptions import Subscriptions
from common.link.tcp_connections import end_connection, is_open, open_connections
from common.wire.streams import SITE_STREAMS, Direction, Stream

log = logging.getLogger(__name__)

# Motion and touch have one sender and one reader; only the stream for observers may have several readers.
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
"""Directions that an observer's key may use; the session judges an observer's requests."""
_ENDS = zmq.EVENT_DISCONNECTED | zmq.EVENT_HANDSHAKE_FAILED_PROTOCOL
_ATTEMPTS = zmq.EVENT_CONNECT_DELAYED | zmq.EVENT_CONNECT_RETRIED | zmq.EVENT_CONNECTED
_NOT_HERE = "no address of this host; set bind in [link] to one, or to 0.0.0.0 for all"
_NOT_BOUND = {
    errno.ENODEV: _NOT_HERE,
    errno.EADDRNOTAVAIL: _NOT_HERE,
    errno.EADDRINUSE: "the port is in use; end the program that has it, or give both sites another base_port in [link]",
}
_OUTCOMES = zmq.EVENT_HANDSHAKE_SUCCEEDED | zmq.EVENT_HANDSHAKE_FAILED_AUTH | zmq.EVENT_HANDSHAKE_FAILED_NO_DETAIL
_OPEN_PER_S = 2.0
"""Maximum long-term rate at which streams are connected again, 1/s."""
_LAST_REQUEST_MS = 100
_UNSENT = 8
"""Maximum number of requests that wait to be sent; further ones fail."""


class RemoteLink(CurveSockets):
    """The remote site's side: binds, and serves trusted keys only."""

    def __init__(self, host: str, base_port: int, keys: KeyPair, trusted: TrustedKeys):
        """Bind all streams.

        Raises:
            LinkProblem: a port is in use, the address is not this machine's, or it is open to a network and no key is
                trusted.
            KeyProblem: the list of trusted keys is damaged.
        """
        check_bind(host, trusted)
        super().__init__()
        self._host, self._base_port, self._keys, self._trusted = host, base_port, keys, trusted
        self._authenticator = Authenticator(self._context, self._admits, full=self._full)
        self.handshakes = self._authenticator.answers
        """Number of handshakes by result: `admitted`, `refused`, `too_many`, `expelled`, `failed`."""
        self._subscribers: dict[str, Subscriptions] = {}
        self._turns = itertools.cycle(SITE_STREAMS)
        self._endless = {
            stream.name: EndlessMessages(base_port + stream.port)
            for stream in SITE_STREAMS.values()
            if stream.direction is Direction.BOTH
        }
        self._endless_turns = itertools.cycle(self._endless.values())
        for stream in SITE_STREAMS.values():
            try:
                self._bind(stream)
            except zmq.ZMQError as error:
                self.close()
                why = _NOT_BOUND.get(error.errno or 0, error.strerror)
                raise LinkProblem(f"{self._address(stream)} ({stream.name}): {why}") from None

    def requests(self, stream: str) -> list[Received]:
        """Return clients' packets of a request stream, at most MOST_AT_ONCE; emergency stops first.

        Each call also checks one stream for readers that subscribe repeatedly. A check after each packet would delay
        its sending by 10 to 20 us.
        """
        if len(self._sockets) < len(SITE_STREAMS):
            self._bind_missing()
        if (subscribers := self._subscribers.get(next(self._turns))) is not None:
            subscribers.step()
        inbox = self._inboxes.get(stream)
        if inbox is None:
            return []
        found = receive_requests(inbox)
        if found:
            self._endless[stream].heard(found)
        self._check(stream, inbox)
        return found

    def expel(self, stream: str, sender: Sender, refuse_s: float = 0.0) -> None:
        """End a sender's connection to a stream; refuse its key there for a while.

        Args:
            stream: name of the stream.
            sender: sender of a packet of that connection.
            refuse_s: duration of status 300 for the key's handshakes, s; the client's library retries by itself.
        """
        if refuse_s > 0.0:
            self._authenticator.refuse(stream, sender.key, refuse_s)
        end_connection(sender.connection, self._base_port + SITE_STREAMS[stream].port)

    def forgive(self, key: str) -> None:
        """Serve a key again that was refused for a while."""
        self._authenticator.forgive(key)

    def is_open(self, stream: str, connection: int) -> bool:
        """Return whether the connection that a packet of this stream came on is still open."""
        return is_open(connection, self._base_port + SITE_STREAMS[stream].port)

    def answer(self, stream: str, who: bytes, packet: bytes) -> None:
        """Answer one client; a client that is gone gets no answer."""
        socket = self._sockets.get(stream)
        if socket is not None:
            send_answer(socket, who, packet)
            self._inboxes[stream].stale()

    def may_operate(self, key: str) -> bool:
        """Return whether the owner of this key may be a session's operator."""
        return self._trusted.role(key) is Role.PARTNER

    @property
    def keys_problem(self) -> str:
        """Error in the list of trusted keys, during which no key is trusted; empty while the list is valid."""
        return self._trusted.problem

    def recheck_keys(self) -> set[str]:
        """Cut every connection of a key that is no longer trusted; return these keys.

        The library cannot end one of several connections. Therefore each socket that admitted such a key is bound
        again, and trusted peers reconnect within a moment. While the old socket still holds its port, the next
        `requests` retries. Each call also checks one stream for a message without an end.
        """
        next(self._endless_turns).step()
        revoked = self._authenticator.revoked()
        for name in revoked:
            self._unbind(name)
        self._bind_missing()
        return set().union(*revoked.values())

    def _replace(self, stream: str, part: zmq.Frame) -> None:
        key = str(part.get("User-Id"))
        log.warning("%s: key %s sent a message with too many parts", stream, fingerprint(key))
        self._authenticator.refuse(stream, key, REFUSE_S)
        self._unbind(stream)
        self._bind_missing()

    def _unbind(self, name: str) -> None:
        """Close a stream's socket and all its connections."""
        self._subscribers.pop(name, None)
        self._inboxes.pop(name, None)
        if (socket := self._sockets.pop(name, None)) is not None:
            socket.close(linger=0)

    def _bind_missing(self) -> None:
        for stream in SITE_STREAMS.values():
            if stream.name not in self._sockets:
                with contextlib.suppress(zmq.ZMQError):  # the old socket still holds the port
                    self._bind(stream)

    def _bind(self, stream: Stream) -> None:
        socket = self._socket(stream, _REMOTE_TYPE[stream.direction])
        if _REMOTE_TYPE[stream.direction] == zmq.PUB:
            prepare_publisher(socket)
        serve_curve(socket, self._keys, stream.name)
        socket.setsockopt(zmq.IPV6, is_ipv6(self._host))
        try:
            socket.bind(self._address(stream))
        except zmq.ZMQError:
            socket.close(linger=0)
            raise
        self._sockets[stream.name], self._inboxes[stream.name] = socket, Inbox(socket)
        if _REMOTE_TYPE[stream.direction] == zmq.PUB:
            self._subscribers[stream.name] = Subscriptions(socket, self._base_port + stream.port)

    def _address(self, stream: Stream) -> str:
        return tcp_endpoint(self._host, self._base_port + stream.port)

    def _admits(self, domain: str, key: str) -> bool:
        role = self._trusted.role(key)
        return role is Role.PARTNER or (role is Role.OBSERVER and SITE_STREAMS[domain].direction in _MAY_OBSERVE)

    def _full(self, domain: str, key: str) -> bool:
        """Return whether a stream has no place for one more observer; an operator always has one."""
        port = self._base_port + SITE_STREAMS[domain].port
        return self._trusted.role(key) is Role.OBSERVER and open_connections(port) > MOST_FOR_OBSERVERS

    def close(self) -> None:
        """Close all sockets and end the authenticator."""
        self._authenticator.close()
        super().close()


class OperatorLink(CurveSockets):
    """The side that connects when the remote site is there: an operator or an observer.

    Attributes:
        remote_key: public key that the remote site has to prove.
        unproven: number of handshakes since the last answered one that ended without an answer to this key, as with a
            server of another key.
    """

    def __init__(self, host: str, base_port: int, keys: KeyPair, remote_public_key: str, role: Role = Role.PARTNER):
        """Connect this role's streams in the background; an absent remote site is no error."""
        super().__init__()
        self._base_port, self._keys, self.remote_key = base_port, keys, remote_public_key
        self.unproven = 0
        self._resolver = Resolver(host, base_port)
        self._reopens = RateLimiter(_OPEN_PER_S, len(SITE_STREAMS))
        self._connections = {
            stream.name: stream
            for stream in SITE_STREAMS.values()
            if (stream.direction in _MAY_OBSERVE if role is Role.OBSERVER else stream.name != "observed")
        }
        """Stream of each connection, by the connection's name, which for the first one is that of the stream."""
        self._doubled = False
        self._connect()

    def double(self, wanted: bool) -> None:
        """Open a second connection to each latest-only stream, or close them; both carry the same packets.

        A lost TCP segment holds back what follows on its own connection only.
        """
        if wanted is self._doubled:
            return
        self._doubled = wanted
        log.info("second connections for motion and touch: %s", "opened" if wanted else "closed")
        for stream in [stream for name, stream in self._connections.items() if name == stream.name]:
            name = stream.name + SECOND
            if stream.latest_only and wanted:
                self._connections[name] = stream
                self._open(name)
            elif stream.latest_only:
                self._close(name)
                for kept in (self._connections, self._monitors, self._sockets, self._inboxes):
                    kept.pop(name)

    def _connect(self) -> None:
        self._address = self._resolver.address
        self._monitors: dict[str, zmq.Socket[bytes]] = {}
        self._ended: set[str] = set()
        for name in self._connections:
            self._open(name)

    def _open(self, name: str) -> None:
        stream = self._connections[name]
        socket = self._socket(stream, _CLIENT_TYPE[stream.direction])
        use_curve(socket, self._keys, self.remote_key)
        if stream.direction is Direction.BOTH:
            # A request to an absent remote must fail now instead of arriving minutes later.
            socket.setsockopt(zmq.IMMEDIATE, 1)
            socket.setsockopt(zmq.SNDHWM, _UNSENT)
        self._monitors[name] = socket.get_monitor_socket(_OUTCOMES | _ENDS | _ATTEMPTS)
        if self._address is not None:
            socket.setsockopt(zmq.IPV6, is_ipv6(self._address))
            socket.connect(tcp_endpoint(self._address, self._base_port + stream.port))
        self._sockets[name], self._inboxes[name] = socket, Inbox(socket)

    def reconnect(self) -> None:
        """Connect again after a refusal, because the library does not."""
        self._disconnect()
        self._connect()

    def _disconnect(self, linger_ms: int = 0) -> None:
        for name in self._monitors:
            self._close(name, linger_ms)

    def _close(self, name: str, linger_ms: int = 0) -> None:
        socket = self._sockets[name]
        socket.disable_monitor()
        self._monitors[name].close()
        socket.close(linger=linger_ms)

    def send(self, stream: str, packet: bytes) -> bool:
        """Send on a request stream; return False when no peer is connected."""
        try:
            self._sockets[stream].send(packet, zmq.DONTWAIT)
        except zmq.Again:
            return False
        self._inboxes[stream].stale()
        return True

    def receive(self, stream: str) -> list[bytes]:
        """Return unread packets of a request stream, at most MOST_AT_ONCE."""
        found: list[bytes] = []
        if self._address != self._resolver.address:  # the name server has answered
            self.reconnect()
        while len(found) < MOST_AT_ONCE and (frames := self._take(stream)):
            found.append(frames[0].bytes)
        return found

    def _replace(self, stream: str, part: zmq.Frame) -> None:
        if self._reopens.allows(time.monotonic()):
            self._close(stream)
            self._open(stream)

    def key_refused(self) -> bool:
        """Return whether the remote site has refused this side's key on any stream since the last call.

        A connection that has ended, without a new attempt of the library since the call before, is connected
        again. So it is after bytes that are no packet, which somebody on the way has changed.
        """
        refused = False
        for name, monitor in list(self._monitors.items()):
            given_up = name in self._ended
            while monitor.poll(0):
                event: dict[str, Any] = dict(zmq.utils.monitor.recv_monitor_message(monitor))
                # After status 300 the library retries by itself; 400 is a refusal.
                final = event["event"] == zmq.EVENT_HANDSHAKE_FAILED_AUTH and event["value"] == 400
                refused = refused or final
                if event["event"] & _OUTCOMES:
                    failed = event["event"] == zmq.EVENT_HANDSHAKE_FAILED_NO_DETAIL
                    self.unproven = self.unproven + 1 if failed else 0
                if event["event"] & _ENDS:
                    self._ended.add(name)
                elif event["event"] & _ATTEMPTS:
                    self._ended.discard(name)
                    given_up = False
            if given_up and self._reopens.allows(time.monotonic()):
                self._ended.discard(name)
                self._close(name)
                self._open(name)
        return refused

    def close(self) -> None:
        """Close all sockets after the last request was sent."""
        self._resolver.close()
        self._disconnect(_LAST_REQUEST_MS)
        self._context.term()
