"""CAN frames described by `haptics.dbc`, with the rolling counter and CRC that cantools leaves open.

A value beyond its signal's range is clipped to the range on encode: the gates have limited it
before, so only the sensor side's own range ends are met here. On decode the counter, the CRC and
each value's range are checked.
"""

import binascii
import math
from dataclasses import dataclass, field
from functools import cache
from importlib import resources

import can
import cantools
from cantools.database.can import Database, Message

from common.fingers import FINGERS


class BadFrame(ValueError):
    """A CAN frame that must not be acted on: unknown, damaged, or repeated."""


@cache
def database() -> Database:
    """The CAN description shipped with the package."""
    text = resources.files("common").joinpath("haptics.dbc").read_text("utf-8")
    loaded = cantools.database.load_string(text, "dbc")
    assert isinstance(loaded, Database)
    return loaded


def _crc(frame_id: int, data: bytes) -> int:
    """Low byte of CRC-16/CCITT-FALSE over the identifier and all bytes before the CRC's own."""
    return binascii.crc_hqx(frame_id.to_bytes(2, "big") + data[:7], 0xFFFF) & 0xFF


@dataclass(slots=True)
class FrameSender:
    """Encodes one kind of frame, counting."""

    name: str
    _message: Message = field(init=False)
    _limits: dict[str, tuple[float, float]] = field(init=False)
    _has_crc: bool = field(init=False)
    _counter: int = 0

    def __post_init__(self) -> None:
        self._message = database().get_message_by_name(self.name)
        signals = [s for s in self._message.signals if s.name not in ("counter", "crc")]
        self._limits = {s.name: (float(s.minimum or 0.0), float(s.maximum or 0.0)) for s in signals}
        self._has_crc = any(s.name == "crc" for s in self._message.signals)

    def encode(self, values: dict[str, float]) -> can.Message:
        """Pack physical values (mm, N) into the next frame.

        Raises:
            ValueError: a value is missing or not a finite number.
        """
        packed: dict[str, float] = {"counter": self._counter}
        for name, (low, high) in self._limits.items():
            value = values.get(name, math.nan)
            if not math.isfinite(value):
                raise ValueError(f"{self.name}.{name}: {value} is no value to send")
            packed[name] = min(max(value, low), high)
        if self._has_crc:
            packed["crc"] = 0
        frame_id = self._message.frame_id
        data = self._message.encode(packed, strict=False)
        if self._has_crc:
            data = data[:7] + bytes((_crc(frame_id, data),))
        self._counter = (self._counter + 1) & 0xF
        return can.Message(arbitration_id=frame_id, data=data, is_extended_id=False)


@dataclass(slots=True)
class FrameReceiver:
    """Decodes and checks one kind of frame; counts what it refused."""

    name: str
    refused: int = 0
    frame_id: int = field(init=False)
    _message: Message = field(init=False)
    _has_crc: bool = field(init=False)
    _counter: int | None = None

    def __post_init__(self) -> None:
        self._message = database().get_message_by_name(self.name)
        self.frame_id = self._message.frame_id
        self._has_crc = any(s.name == "crc" for s in self._message.signals)

    def decode(self, data: bytes) -> dict[str, float]:
        """Check one frame's bytes and return its physical values (mm, N).

        Raises:
            BadFrame: wrong length or CRC, or the counter stands still (a frame repeated by a hung sender).
        """
        if len(data) != 8:
            raise self._refuse(f"{len(data)} bytes, expected 8")
        if self._has_crc and data[7] != _crc(self.frame_id, data):
            raise self._refuse("wrong CRC")
        decoded = self._message.decode(data)
        assert isinstance(decoded, dict)
        values = {name: float(value) for name, value in decoded.items() if isinstance(value, (int, float))}
        counter = int(values.pop("counter"))
        if counter == self._counter:
            raise self._refuse("rolling counter stands still")
        self._counter = counter
        values.pop("crc", None)
        return values

    def _refuse(self, why: str) -> BadFrame:
        self.refused += 1
        return BadFrame(f"{self.name}: {why}")


def by_finger(values: dict[str, float]) -> tuple[float, ...]:
    """The five fingers' values of a decoded frame, in the order of `FINGERS`."""
    return tuple(values[finger] for finger in FINGERS)
