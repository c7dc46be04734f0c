"""Ways to send a touch packet from one process to another: the product's own classes, and bare sockets."""

import time
from collections.abc import Callable
from typing import NamedTuple

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


class Sender(NamedTuple):
    """Encodes and sends a message with a number; closes its socket."""

    send: Callable[[int], Departure]
    close: Callable[[], None]


class Receiver(NamedTuple):
    """Receives the next message within a time, s; closes its socket."""

    receive: Callable[[float], Arrival | None]
    close: Callable[[], None]


def link_sender(place: Place, like: Touch) -> Sender:
    """Return the remote site's end of the product's link."""
    link = RemoteLink(place.host, place.base_port, load_keys(place.remote_keys), TrustedKeys(place.remote_keys))

    def send(sequence: int) -> Departure:
        touch = next_touch(like, sequence, time.monotonic_ns())
        begin_ns = time.monotonic_ns()
        packet = touch.encode()
        encoded_ns = time.monotonic_ns()
        link.send_latest("touch", packet)
        return begin_ns, encoded_ns

    return Sender(send, link.close)


def link_receiver(place: Place) -> Receiver:
    """Return the operator site's end of the product's link; it decodes, checks and accepts each packet."""
    remote_key = load_keys(place.remote_keys).public
    link = OperatorLink(place.host, place.base_port, load_keys(place.operator_keys), remote_key)
    acceptance = PacketFilter(round(AGE_MAX_S * 1e9))

    def receive(seconds: float) -> Arrival | None:
        if (packet := link.wait_for_latest("touch", seconds)) is None:
            return None
        touch = Touch.decode(packet)
        if not acceptance.accept(touch, SESSION, time.monotonic_ns(), 0, 0):
            raise EndLost(f"a packet was refused: {dict(acceptance.refused)}")
        return touch.sequence, time.monotonic_ns()

    return Receiver(receive, link.close)


def bare_sender(socket: BareCurve | PlainTcp, body: bytes, busy_with: Touch | None = None) -> Sender:
    """Return an end that sends messages as long as `body`; with `busy_with`, it encodes that packet before each."""

    def send(sequence: int) -> Departure:
        if busy_with is not None:
            next_touch(busy_with, sequence, time.monotonic_ns()).encode()
        message = numbered(body, sequence)
        encoded_ns = time.monotonic_ns()
        socket.send(message)
        return encoded_ns, encoded_ns

    return Sender(send, socket.close)


def bare_receiver(socket: BareCurve | PlainTcp, busy_with: bytes | None = None) -> Receiver:
    """Return an end that receives messages; with `busy_with`, it decodes that packet after each."""

    def receive(seconds: float) -> Arrival | None:
        if (message := socket.receive(seconds)) is None:
            return None
        end_ns = time.monotonic_ns()
        if busy_with is not None:
            Touch.decode(busy_with)
        return read_number(message), end_ns

    return Receiver(receive, socket.close)
