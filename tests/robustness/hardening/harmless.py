"""Judges what a decoder accepts of a broken frame: finite values, in range, the same when they are sent on."""

import math
from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np
from cantools.database.can import Message
from msgspec import Struct
from msgspec.structs import astuple

from common.buses.can_frames import FrameReceiver, FrameSender
from common.buses.serial_messages import Frame, FrameReader, Identity, encode_frame
from common.wire.messages import TOUCH_FIELDS, TOUCH_RANGES, Motion, Touch
from common.wire.packets import MAX_PACKET
from tests.robustness.hardening.specimens import values_of

RANGES = {
    Motion: np.array([(-0.66, 0.66), (-0.66, 0.66), (-0.0103, 0.0103)], dtype=np.float32).T,
    Touch: np.array([TOUCH_RANGES[name] for name in TOUCH_FIELDS], dtype=np.float32).T,
}
"""Lowest and highest value of each column of a packet's block, from the protocol document."""


def harmless_packet(_: bytes, taken: Any) -> None:
    """A packet of the network link."""
    assert_finite(taken)
    if type(taken) in RANGES:
        low, high = RANGES[type(taken)]
        block = np.array(taken.rows, np.float32)
        assert ((low <= block) & (block <= high)).all()
    encoded = taken.encode()
    assert len(encoded) <= MAX_PACKET
    assert type(taken).decode(encoded).encode() == encoded


def harmless_payload(payload: bytes, taken: Any) -> None:
    """What a serial frame carried."""
    assert_finite(taken)
    encoded = taken.encode()
    assert type(taken).decode(encoded) == taken
    # A serial number may be filled up with spaces in more ways than one; all else must say what was on the line.
    assert isinstance(taken, Identity) or encoded == payload


def harmless_frames(_: bytes, frames: list[Frame]) -> None:
    """Frames that were read from a serial line."""
    for frame in frames:
        again = encode_frame(frame.message_id, frame.sequence, frame.payload)
        assert FrameReader().feed(again) == [frame]


class HarmlessValues:
    """The values of one kind of CAN frame, judged by the description."""

    def __init__(self, message: Message) -> None:
        self._signals = {signal.name: signal for signal in values_of(message)}
        self._sender, self._receiver = FrameSender(message.name), FrameReceiver(message.name)

    def __call__(self, _: bytes, values: dict[str, float]) -> None:
        """Judge one decoded frame."""
        assert set(values) == set(self._signals)
        again = self._receiver.decode(bytes(self._sender.encode(values).data))
        for name, value in values.items():
            signal = self._signals[name]
            assert math.isfinite(value)
            assert float(signal.minimum or 0) - 1e-9 <= value <= float(signal.maximum or 0) + 1e-9
            assert abs(again[name] - value) <= 1e-9, name


def assert_finite(value: Any) -> None:
    """Nothing in it is infinite or no number, however deep."""
    if isinstance(value, float):
        assert math.isfinite(value)
    elif isinstance(value, np.ndarray):
        assert np.isfinite(value).all()
    elif is_dataclass(value):
        for field in fields(value):
            assert_finite(getattr(value, field.name))
    elif isinstance(value, Struct):
        assert_finite(astuple(value))
    elif isinstance(value, dict):
        for item in value.values():
            assert_finite(item)
    elif isinstance(value, (list, tuple)):
        for item in value:
            assert_finite(item)
    else:
        assert value is None or isinstance(value, (int, str, bytes))
