"""Interface between a site and its side of the link: `common.link.link` has sockets, a test bed has memory."""

from collections.abc import Mapping
from typing import Protocol

from common.link.curve import Received, Sender


class RemoteSide(Protocol):
    """The remote site's side; see `common.link.link.RemoteLink`."""

    @property
    def handshakes(self) -> Mapping[str, int]:
        """Number of handshakes by result."""

    @property
    def keys_problem(self) -> str:
        """Error in the list of trusted keys; empty while the list is valid."""

    def requests(self, stream: str) -> list[Received]:
        """Return clients' packets of a request stream; emergency stops first."""

    def newest_of_each(self, stream: str) -> list[Received]:
        """Return the newest unread packet of each connection of a latest-only stream."""

    def send_latest(self, stream: str, packet: bytes) -> None:
        """Send on a latest-only stream, replacing an unsent older packet."""

    def answer(self, stream: str, who: bytes, packet: bytes) -> None:
        """Answer one client; a client that is gone gets no answer."""

    def expel(self, stream: str, sender: Sender, refuse_s: float = 0.0) -> None:
        """End a sender's connection to a stream, and refuse its key there for `refuse_s`, s."""

    def forgive(self, key: str) -> None:
        """Serve a key again that was refused for a while."""

    def is_open(self, stream: str, connection: int) -> bool:
        """Return whether the connection that a packet of this stream came on is still open."""

    def may_operate(self, key: str) -> bool:
        """Return whether the owner of this key may be a session's operator."""

    def recheck_keys(self) -> set[str]:
        """Cut every connection of a key that is no longer trusted; return these keys."""


class OperatorSide(Protocol):
    """The operator site's side; see `common.link.link.OperatorLink`."""

    def send(self, stream: str, packet: bytes) -> bool:
        """Send a request; return whether it was accepted for sending."""

    def receive(self, stream: str) -> list[bytes]:
        """Return the remote site's packets since the last call."""

    def send_latest(self, stream: str, packet: bytes) -> None:
        """Send on a latest-only stream, replacing an unsent older packet."""

    def newest(self, stream: str) -> list[bytes]:
        """Return the newest unread packet of each of this side's connections to a latest-only stream."""

    def double(self, wanted: bool) -> None:
        """Open a second connection to each latest-only stream, with the same packets, or close them."""
