"""One wrong byte at every place of each message is refused or harmless, counted, and the next message is accepted.

The reader of serial lines is tested so in tests/unit/common/buses/test_serial_framing.py.
"""

from collections.abc import Iterable, Iterator
from typing import Any

import pytest
from cantools.database.can import Message

from common.buses.can_frames import BadFrame, FrameReceiver
from common.buses.serial_messages import BadPayload
from common.link.curve import Received, Sender
from common.wire.packets import BadPacket
from operator_site.session.session_client import SessionClient
from remote_site.session.session_server import SessionServer
from tests.robustness.hardening.harmless import HarmlessValues, harmless_packet, harmless_payload
from tests.robustness.hardening.specimens import (
    CAN_FRAMES,
    PACKETS,
    PAYLOADS,
    good_can_frames,
    good_packets,
    good_payloads,
)

OPERATOR = "key of the operator"
EVERY = range(1, 256)
ONE_BIT = [1 << bit for bit in range(8)]
MANY = [*ONE_BIT, *range(3, 256, 12)]
"""For packets, which are longer."""


def with_one_wrong_byte(good: bytes, damages: Iterable[int] = EVERY) -> Iterator[bytes]:
    """Every frame that differs from this one in one byte by one of these patterns."""
    for position in range(len(good)):
        for damage in damages:
            broken = bytearray(good)
            broken[position] ^= damage
            yield bytes(broken)


KINDS = [
    *(pytest.param(kind, good_packets, MANY, BadPacket, harmless_packet, id=kind.__name__) for kind in PACKETS),
    *(pytest.param(kind, good_payloads, EVERY, BadPayload, harmless_payload, id=kind.__name__) for kind in PAYLOADS),
]
"""Packets, and payloads before a valid CRC."""


@pytest.mark.long
@pytest.mark.parametrize(("kind", "goods", "damages", "refusal", "harmless"), KINDS)
def test_one_wrong_byte_in_a_message_is_refused_or_harmless(
    kind: Any, goods: Any, damages: Iterable[int], refusal: type[Exception], harmless: Any, golden: dict[str, bytes]
) -> None:
    refused = 0
    for good in goods(kind, golden):
        for broken in with_one_wrong_byte(good, damages):
            try:
                taken = kind.decode(broken)
            except refusal:
                refused += 1
                continue
            harmless(broken, taken)
        kind.decode(good)
    assert refused > 0


@pytest.mark.parametrize("message", CAN_FRAMES, ids=lambda message: message.name)
def test_one_wrong_byte_in_a_can_frame_is_refused_or_harmless(message: Message) -> None:
    harmless = HarmlessValues(message)
    good, second, third, *_ = good_can_frames(message)
    for broken in with_one_wrong_byte(good):
        receiver = FrameReceiver(message.name)
        try:
            taken = receiver.decode(broken)
        except BadFrame:
            assert receiver.refused == 1
            assert receiver.decode(second)
            continue
        harmless(broken, taken)
        # Without a check sum a wrong counter is believed; if it is the next one's, that one is refused and no other.
        before = receiver.refused
        try:
            receiver.decode(second)
        except BadFrame:
            assert receiver.refused == before + 1
        assert receiver.decode(third)


class OnePacket:
    """A link on which one packet has come, on one stream."""

    def __init__(self, stream: str) -> None:
        self._stream = stream
        self.packet = b""

    def newest(self, stream: str) -> list[bytes]:
        return self.receive(stream)

    def receive(self, stream: str) -> list[bytes]:
        return [self.packet] if stream == self._stream else []

    def requests(self, stream: str) -> list[Received]:
        return [(Sender(b"who", OPERATOR), self.packet)] if stream == self._stream else []

    def newest_of_each(self, stream: str) -> list[Received]:
        return self.requests(stream)

    def expel(self, stream: str, sender: Sender, refuse_s: float = 0.0) -> None:
        """There is no connection."""

    def is_open(self, stream: str, connection: int) -> bool:
        return True

    def answer(self, stream: str, who: bytes, packet: bytes) -> None:
        """Nobody listens."""

    def send(self, stream: str, packet: bytes) -> bool:
        return False

    def may_operate(self, key: str) -> bool:
        return False

    def key_refused(self) -> bool:
        return False


def site_of(stream: str, link: Any) -> Any:
    """The end of the session that takes this stream."""
    if stream == "touch":
        return SessionClient(link, {"fingers": []}, 0.15, want_engaged=False)
    server = SessionServer(link, {"fingers": []}, 0.15)
    server.operator = OPERATOR if stream == "motion" else ""
    return server


@pytest.mark.parametrize("stream", ["motion", "touch"])
def test_one_wrong_byte_in_a_stream_is_counted_once_by_the_receiver(stream: str, golden: dict[str, bytes]) -> None:
    link = OnePacket(stream)
    site = site_of(stream, link)
    for number, broken in enumerate(with_one_wrong_byte(golden[stream], ONE_BIT), start=1):
        link.packet = broken
        site.step(number, "")
        refused = site.damaged[stream] + site.acceptance.refused.total()
        assert refused == number, "neither damaged nor of another session, and yet not acted on"
    assert site.damaged[stream] > 0
    assert site.acceptance.received == 0


@pytest.mark.parametrize("name", ["hello", "heartbeat"])
def test_one_wrong_byte_in_a_request_begins_no_session(name: str, golden: dict[str, bytes]) -> None:
    stream = "control" if name == "hello" else "heartbeat"
    link = OnePacket(stream)
    site = site_of(stream, link)
    for number, broken in enumerate(with_one_wrong_byte(golden[name], ONE_BIT), start=1):
        link.packet = broken
        site.step(number, "")
        assert site.session.ident == 0
    assert 0 < site.damaged[stream] <= number
