"""Good packets, payloads and frames of every kind; new kinds are found automatically."""

from random import Random
from types import ModuleType
from typing import Any

from cantools.database.can import Message

from common.buses import serial_messages
from common.buses.can_frames import FrameSender, database
from common.buses.serial_messages import BadPayload, Frame, FrameReader
from common.wire import messages, session_messages
from common.wire.packets import BadPacket


def _decoded_in(*modules: ModuleType) -> list[Any]:
    return [
        kind
        for module in modules
        for kind in vars(module).values()
        if isinstance(kind, type) and hasattr(kind, "decode") and kind.__module__ == module.__name__
    ]


PACKETS = _decoded_in(messages, session_messages)
"""Classes of the network link's packets."""
PAYLOADS = _decoded_in(serial_messages)
"""Classes of the serial devices' payloads."""
CAN_FRAMES: list[Message] = list(database().messages)
"""Descriptions of the CAN frames."""


def good_packets(kind: Any, golden: dict[str, bytes]) -> list[bytes]:
    """The protocol document's packets that this kind takes."""
    return _taken(kind, list(golden.values()), BadPacket)


def good_payloads(kind: Any, golden: dict[str, bytes]) -> list[bytes]:
    """The protocol document's serial payloads that this kind takes."""
    return _taken(kind, [frame.payload for _, frame in serial_frames(golden)], BadPayload)


def serial_frames(golden: dict[str, bytes]) -> list[tuple[bytes, Frame]]:
    """The protocol document's serial frames, as they stand on the line and as they are read."""
    return [(line, frame) for line in golden.values() for frame in FrameReader().feed(line)]


def good_can_frames(message: Message) -> list[bytes]:
    """64 frames of one sender in a row: the first may follow the last."""
    rng, sender = Random(message.frame_id), FrameSender(message.name)
    return [
        bytes(sender.encode({s.name: rng.uniform(float(s.minimum or 0), float(s.maximum or 0)) for s in signals}).data)
        for signals in [values_of(message)] * 64
    ]


def values_of(message: Message) -> list[Any]:
    """The signals of a CAN frame that a sender gives values for."""
    return [signal for signal in message.signals if signal.name not in ("counter", "crc")]


def has_crc(message: Message) -> bool:
    """Whether a CAN frame has a check sum of its own."""
    return any(signal.name == "crc" for signal in message.signals)


def _taken(kind: Any, candidates: list[bytes], refusal: type[ValueError]) -> list[bytes]:
    found = []
    for candidate in candidates:
        try:
            kind.decode(candidate)
        except refusal:
            continue
        found.append(candidate)
    assert found, f"docs/protocols.md has no golden {kind.__name__}"
    return found
