"""What a site needs of its side of the link: `common.link.link` has sockets, a test bed has memory."""

from collections.abc import Mapping
from typing import Protocol

from common.link.curve import Received


class RemoteSide(Protocol):
    """The remote site's side; see `common.link.link.RemoteLink`."""

    @property
    def handshakes(self) -> Mapping[str, int]:
        """Handshakes so far, by what came of them."""

    @property
    def keys_problem(self) -> str:
        """What is wrong with the list of trusted keys; empty while it is sound."""

    def requests(self, stream: str) -> list[Received]:
        """What clients sent on a request stream; emergency stops first."""

    def motions(self) -> list[Received]:
        """The newest unread motion of each connection."""

    def send_latest(self, stream: str, packet: bytes) -> None:
        """Send on a latest-only stream; an unsent older packet is replaced."""

    def answer(self, stream: str, who: bytes, packet: bytes) -> None:
        """Answer one client; one that is gone gets nothing."""

    def expel(self, stream: str, received: Received, refuse_s: float = 0.0) -> None:
        """End the connection that `received` came on, and refuse its key at this stream for a while, s."""

    def forgive(self, key: str) -> None:
        """Serve a key again that was refused for a while."""

    def is_open(self, stream: str, connection: int) -> bool:
        """Whether the connection that a packet of this stream came on is still open."""

    def may_operate(self, key: str) -> bool:
        """Whether the owner of this key may be a session's operator."""

    def recheck_keys(self) -> set[str]:
        """Cut every connection of a key that is no longer trusted; returns these keys."""


class OperatorSide(Protocol):
    """The operator site's side; see `common.link.link.OperatorLink`."""

    def send(self, stream: str, packet: bytes) -> bool:
        """Send a request; returns whether it was taken."""

    def receive(self, stream: str) -> list[bytes]:
        """What the remote site answered since the last call."""

    def send_latest(self, stream: str, packet: bytes) -> None:
        """Send on a latest-only stream; an unsent older packet is replaced."""

    def receive_latest(self, stream: str) -> bytes | None:
        """The newest unread packet of a latest-only stream."""
