"""The socket of a stream beside the session: serves its readers with the remote site's keys."""

import contextlib
import select
from collections.abc import MutableMapping
from typing import Protocol, TypeVar

import zmq

from common.config.link_models import RemoteLinkConfig
from common.link.authenticator import MOST_FOR_OBSERVERS, Authenticator
from common.link.bind_address import check_bind
from common.link.curve import REFUSE_S, Inbox, LinkProblem, Received, prepare_socket, receive_requests, serve_curve
from common.link.endless_messages import EndlessMessages
from common.link.host_name import is_ipv6, tcp_endpoint
from common.link.keys import Role, TrustedKeys, load_keys
from common.link.tcp_connections import open_connections
from common.wire.streams import STREAMS

NICE = 10
"""Niceness of a stream's process: touch comes first."""
SECOND_S = 1.0
"""Time between two checks of the keys, and two writes of the status file, s."""
MOST_READERS = 8
"""Maximum number of readers of a stream; an operator's takes the place of an observer's, others are refused."""
LEFT_S = 2.0
"""Time without a packet after which a reader has left, s."""
_WAITING = 16
"""Maximum number of messages that wait to be sent to one reader."""


class Placed(Protocol):
    """A reader; `operates` says whether its key may operate the session."""

    operates: bool


Reader = TypeVar("Reader", bound=Placed)


def make_place(readers: MutableMapping[bytes, Reader], *, operates: bool) -> bool:
    """Return whether there is a place for a new reader; remove an observer's reader for one that `operates`."""
    if len(readers) < MOST_READERS:
        return True
    observes = next((who for who, reader in readers.items() if operates and not reader.operates), None)
    if observes is None:
        return False
    del readers[observes]
    return True


class StreamServer:
    """Serves trusted keys only; never blocks."""

    def __init__(self, config: RemoteLinkConfig, stream: str) -> None:
        """Bind the port of a stream.

        Raises:
            LinkProblem: the port is in use, the address is not this machine's, or it is open to a network and no key
                is trusted.
            KeyProblem, OSError: the keys are damaged or missing.
        """
        self._keys, self._trusted = load_keys(config.keys), TrustedKeys(config.keys)
        check_bind(config.bind, self._trusted)
        self._stream, self._host = stream, config.bind
        self._port = config.base_port + STREAMS[stream].port
        self._address = tcp_endpoint(config.bind, self._port)
        self.socket: zmq.Socket[bytes] | None = None
        """Socket of the stream; None for a moment after a key was revoked."""
        self._endless = EndlessMessages(self._port)
        self._context = zmq.Context()
        self._authenticator = Authenticator(
            self._context, lambda _, key: self._trusted.role(key) is not None, full=lambda _, key: self._full(key)
        )
        try:
            self._bind()
        except zmq.ZMQError as error:
            self.close()
            raise LinkProblem(f"{self._address} ({stream}): {error.strerror}") from None

    def _bind(self) -> None:
        socket = self._context.socket(zmq.ROUTER)
        prepare_socket(socket)
        socket.setsockopt(zmq.SNDHWM, _WAITING)
        socket.setsockopt(zmq.IPV6, is_ipv6(self._host))
        serve_curve(socket, self._keys, self._stream)
        try:
            socket.bind(self._address)
        except zmq.ZMQError:
            socket.close(linger=0)
            raise
        self.socket, self._inbox = socket, Inbox(socket)

    def wait(self, longest_s: float, *others: int) -> None:
        """Wait for a reader's packet, or until another descriptor is readable, at most `longest_s`, s."""
        own = [] if self.socket is None else [int(self.socket.getsockopt(zmq.FD))]
        news = select.poll()
        for descriptor in (*own, *others):
            news.register(descriptor, select.POLLIN)
        news.poll(longest_s * 1e3)

    def receive(self) -> list[Received]:
        """Return the readers' packets since the last call."""
        if self.socket is None:
            with contextlib.suppress(zmq.ZMQError):  # the old socket still holds the port
                self._bind()
        if self.socket is None:
            return []
        found = receive_requests(self._inbox)
        self._endless.heard(found)
        if self._inbox.rest_of is not None:  # a long message would delay all other readers
            self._authenticator.refuse(self._stream, str(self._inbox.rest_of.get("User-Id")), REFUSE_S)
            self._unbind()
        return found

    def may_operate(self, key: str) -> bool:
        """Return whether the owner of this key may be a session's operator."""
        return self._trusted.role(key) is Role.PARTNER

    def _full(self, key: str) -> bool:
        """Return whether there is no place for one more observer; an operator always has one."""
        return not self.may_operate(key) and open_connections(self._port) > MOST_FOR_OBSERVERS

    def send(self, who: bytes, *parts: bytes) -> None:
        """Send a message to one reader; a reader that is gone or reads nothing gets none."""
        if self.socket is not None:
            with contextlib.suppress(zmq.Again):
                self.socket.send_multipart([who, *parts], zmq.DONTWAIT)
            self._inbox.stale()

    def recheck_keys(self) -> None:
        """Cut every connection if a key that was admitted is no longer trusted; trusted readers connect again.

        A connection with a message without an end is ended, too. Called about once a second.
        """
        self._endless.step()
        if self.socket is not None and self._authenticator.revoked():
            self._unbind()
            self.receive()

    def _unbind(self) -> None:
        """Close the socket and all its connections; the next `receive` binds it again."""
        if self.socket is not None:
            self.socket.close(linger=0)
            self.socket = None

    def close(self) -> None:
        """Release the port."""
        self._authenticator.close()
        self._context.destroy(linger=0)
