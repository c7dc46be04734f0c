"""Ways to send a touch packet from one process to another: the product's own classes, and bare sockets."""

import time
from typing import Protocol

from benchmarks.link.bare import BareCurve, PlainTcp, numbered, read_number
from benchmarks.link.ends import EndLost, Place
from benchmarks.link.packets import SESSION, next_touch
from common.limits import AGE_MAX_S
from common.link.keys import TrustedKeys, load_keys
from common.link.link import OperatorLink, RemoteLink
from common.link.packet_filter import PacketFilter
from common.wire.messages import Touch

Departure = tuple[int, int]
"""Times before and after encoding a message, ns; equal for a bare message."""
Arrival = tuple[int, int]
"""Number of a message, and the time from which it could be acted on, ns."""


class Sender(Protocol):
    """Sends numbered messages."""

    def send(self, sequence: int) -> Departure:
        """Encode and send a message."""

    def close(self) -> None:
        """Close the socket."""


class Receiver(Protocol):
    """Receives the messages of a sender."""

    def receive(self, seconds: float) -> Arrival | None:
        """The next message within `seconds`."""

    def close(self) -> None:
        """Close the socket."""


class LinkSender:
    """The remote site's end of the product's link."""

    def __init__(self, place: Place, like: Touch):
        self._link = RemoteLink(
            place.host, place.base_port, load_keys(place.remote_keys), TrustedKeys(place.remote_keys)
        )
        self._like = like

    def send(self, sequence: int) -> Departure:
        """Encode one packet and send it."""
        touch = next_touch(self._like, sequence, time.monotonic_ns())
        begin_ns = time.monotonic_ns()
        packet = touch.encode()
        encoded_ns = time.monotonic_ns()
        self._link.send_latest("touch", packet)
        return begin_ns, encoded_ns

    def close(self) -> None:
        """Close the link."""
        self._link.close()


class LinkReceiver:
    """The operator site's end of the product's link."""

    def __init__(self, place: Place):
        remote_key = load_keys(place.remote_keys).public
        self._link = OperatorLink(place.host, place.base_port, load_keys(place.operator_keys), remote_key)
        self._acceptance = PacketFilter(round(AGE_MAX_S * 1e9))

    def receive(self, seconds: float) -> Arrival | None:
        """The next packet, decoded, checked and accepted."""
        if (packet := self._link.wait_for_latest("touch", seconds)) is None:
            return None
        touch = Touch.decode(packet)
        if not self._acceptance.accept(touch, SESSION, time.monotonic_ns(), 0, 0):
            raise EndLost(f"a packet was refused: {dict(self._acceptance.refused)}")
        return touch.sequence, time.monotonic_ns()

    def close(self) -> None:
        """Close the link."""
        self._link.close()


class BareSender:
    """Sends numbered messages over a bare socket."""

    def __init__(self, socket: BareCurve | PlainTcp, body: bytes, busy_with: Touch | None = None):
        """Send messages as long as `body`; with `busy_with`, encode that packet before each of them."""
        self._socket, self._body, self._busy_with = socket, body, busy_with

    def send(self, sequence: int) -> Departure:
        """Send one message."""
        if self._busy_with is not None:
            next_touch(self._busy_with, sequence, time.monotonic_ns()).encode()
        message = numbered(self._body, sequence)
        encoded_ns = time.monotonic_ns()
        self._socket.send(message)
        return encoded_ns, encoded_ns

    def close(self) -> None:
        """Close the socket."""
        self._socket.close()


class BareReceiver:
    """Receives numbered messages from a bare socket."""

    def __init__(self, socket: BareCurve | PlainTcp, busy_with: bytes | None = None):
        """Receive messages; with `busy_with`, decode that packet after each of them."""
        self._socket, self._busy_with = socket, busy_with

    def receive(self, seconds: float) -> Arrival | None:
        """The next message."""
        if (message := self._socket.receive(seconds)) is None:
            return None
        end_ns = time.monotonic_ns()
        if self._busy_with is not None:
            Touch.decode(self._busy_with)
        return read_number(message), end_ns

    def close(self) -> None:
        """Close the socket."""
        self._socket.close()
