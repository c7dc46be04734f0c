"""Encodes and decodes the CAN frames of `haptics.dbc`, with the rolling counter and CRC that cantools leaves open.

Encoding clips a value to the range of its signal. The gates have limited commands before, so only sensor values reach
an end of their range. Decoding checks the counter, the CRC and the range of each value.
"""

import binascii
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import cache
from importlib import resources

import can
import cantools
from cantools.database.can import Database, Message

from common.timing.timeouts import FRAME_S

_BYTES = 8
"""Length of every frame, bytes."""
SentFrame = tuple[int, bytes]
"""A frame to send: its 11-bit identifier and its bytes."""


class BadFrame(ValueError):
    """A CAN frame that must be ignored because it is unknown, damaged or repeated."""


@cache
def database() -> Database:
    """Return the CAN description shipped with the package."""
    text = resources.files("common.buses").joinpath("haptics.dbc").read_text("utf-8")
    loaded = cantools.database.load_string(text, "dbc")
    assert isinstance(loaded, Database)
    return loaded


def frame_crc(frame_id: int, data: bytes) -> int:
    """Return the low byte of CRC-16/CCITT-FALSE over the identifier and all bytes before the CRC."""
    return binascii.crc_hqx(data[:7], _crc_begun(frame_id)) & 0xFF


def _crc_begun(frame_id: int) -> int:
    """Return the CRC over the identifier alone, the start value for the CRC over the bytes."""
    return binascii.crc_hqx(frame_id.to_bytes(2, "big"), 0xFFFF)


class CanSignals:
    """Packs and unpacks the values of one kind of frame, with bit positions read once from the description.

    Packing takes a third of the time of an encoder that reads the description for each frame. A test compares the
    result with cantools.

    Attributes:
        frame_id: identifier of the frame.
        has_crc: whether the last byte is a CRC. `pack` leaves it 0.
        names: names of the values, in the order of their bits.
    """

    def __init__(self, message: Message) -> None:
        """Take a message's description: eight bytes with a `counter` and integers in Intel byte order without offset.

        Raises:
            ValueError: a signal has another format.
        """
        self.frame_id = int(message.frame_id)
        names: list[str] = []
        self._places: list[tuple[int, int, int, float]] = []
        """Start, mask, sign bit (0 where unsigned) and scale of each value."""
        self._ranges: list[tuple[float, float, float, int, int, str]] = []
        """Minimum, maximum, scale, mask, start and name of each value."""
        self.has_crc = False
        for signal in sorted(message.signals, key=lambda signal: int(signal.start)):
            if signal.byte_order != "little_endian" or signal.is_float or signal.offset:
                raise ValueError(
                    f"{message.name}.{signal.name}: an integer in Intel byte order without offset is needed"
                )
            if signal.name == "crc":
                self.has_crc = True
            elif signal.name == "counter":
                self._counter_at = int(signal.start)
            else:
                sign = 1 << signal.length - 1 if signal.is_signed else 0
                low, high = float(signal.minimum or 0.0), float(signal.maximum or 0.0)
                mask = (1 << signal.length) - 1
                start, scale = int(signal.start), float(signal.scale)
                names.append(signal.name)
                self._places.append((start, mask, sign, scale))
                self._ranges.append((low, high, scale, mask, start, signal.name))
        self.names = tuple(names)

    def pack(self, values: Mapping[str, float], counter: int) -> bytes:
        """Return the frame's bytes from values by name; otherwise as `pack_in_order`."""
        return self.pack_in_order([values.get(name, math.nan) for name in self.names], counter)

    def pack_in_order(self, values: Sequence[float], counter: int) -> bytes:
        """Return the frame's bytes from values in the order of `names`; a value beyond its range is clipped to it.

        Raises:
            ValueError: a value is missing or not a finite number; the message names it.
        """
        packed = counter << self._counter_at
        for value, (low, high, scale, mask, start, name) in zip(values, self._ranges, strict=True):
            if low <= value <= high:
                packed |= (round(value / scale) & mask) << start
            elif math.isfinite(value):
                packed |= (round((low if value < low else high) / scale) & mask) << start
            else:
                raise ValueError(f"{name}: {value} is no value to send")
        return packed.to_bytes(_BYTES, "little")

    def unpack(self, data: bytes) -> tuple[dict[str, float], int]:
        """Return the values of eight bytes by name, and the counter."""
        values, counter = self.unpack_in_order(data)
        return dict(zip(self.names, values, strict=True)), counter

    def unpack_in_order(self, data: bytes) -> tuple[tuple[float, ...], int]:
        """Return the values of eight bytes in the order of `names`, and the counter."""
        packed = int.from_bytes(data, "little")
        values = [(((packed >> start & mask) ^ sign) - sign) * scale for start, mask, sign, scale in self._places]
        return tuple(values), packed >> self._counter_at & 0xF


def packing(name: str) -> CanSignals:
    """Return the layout of a frame's values, by the frame's name."""
    return CanSignals(database().get_message_by_name(name))


@dataclass(slots=True)
class FrameSender:
    """Encodes frames of one kind and numbers them with the rolling counter."""

    name: str
    _packing: CanSignals = field(init=False)
    _crc_begun: int = field(init=False)
    _counter: int = 0

    def __post_init__(self) -> None:
        self._packing = packing(self.name)
        self._crc_begun = _crc_begun(self._packing.frame_id)

    def encode(self, values: Mapping[str, float]) -> can.Message:
        """Pack physical values (mm, N) by name into a message of python-can; raises as `next_frame`."""
        frame_id, data = self.named_frame(values)
        return can.Message(arbitration_id=frame_id, data=data, is_extended_id=False)

    def named_frame(self, values: Mapping[str, float]) -> SentFrame:
        """Pack physical values (mm, N) by name into the next frame; raises as `next_frame`."""
        return self.next_frame([values.get(name, math.nan) for name in self._packing.names])

    def next_frame(self, values: Sequence[float]) -> SentFrame:
        """Pack physical values (mm, N), in the order of their bits, into the next frame.

        Raises:
            ValueError: a value is missing or not a finite number.
        """
        layout = self._packing
        try:
            data = layout.pack_in_order(values, self._counter)
        except ValueError as error:
            raise ValueError(f"{self.name}.{error}") from None
        if layout.has_crc:
            data = data[:7] + bytes((binascii.crc_hqx(data[:7], self._crc_begun) & 0xFF,))
        self._counter = (self._counter + 1) & 0xF
        return layout.frame_id, data


@dataclass(slots=True)
class FrameReceiver:
    """Decodes and checks frames of one kind; counts refused frames.

    Attributes:
        taken: number of good frames.
        refused: number of frames that were damaged or repeated.
        skipped: number of frames that were lost or refused, as the counters of the good frames show. Sixteen frames
            lost in a row are not counted.
    """

    name: str
    taken: int = 0
    refused: int = 0
    skipped: int = 0
    frame_id: int = field(init=False)
    _packing: CanSignals = field(init=False)
    _crc_begun: int = field(init=False)
    _counter: int | None = None
    _read_s: float = math.nan
    """Last time of the gateway, s."""
    _sent_s: float = math.nan

    def __post_init__(self) -> None:
        self._packing = packing(self.name)
        self.frame_id = self._packing.frame_id
        self._crc_begun = _crc_begun(self.frame_id)

    def begin(self) -> None:
        """Start a new connection: its first frame may have any counter."""
        self._counter = None

    def sent_s(self, read_s: float) -> float:
        """Return the time of the next frame from the gateway's time `read_s`, s.

        While the gateway's clock stands still, or is coarse, each frame comes FRAME_S after the one before. Without
        this no check of the readings would see time pass.
        """
        if self._read_s <= read_s <= self._sent_s:
            self._sent_s += FRAME_S
        else:
            self._sent_s = read_s
        self._read_s = read_s
        return self._sent_s

    def decode(self, data: bytes) -> dict[str, float]:
        """Check one frame's bytes and return its physical values (mm, N) by name; raises as `values`."""
        return dict(zip(self._packing.names, self.values(data), strict=True))

    def values(self, data: bytes) -> tuple[float, ...]:
        """Check one frame's bytes and return its physical values (mm, N), in the order of their bits.

        Raises:
            BadFrame: wrong length or CRC, or an unchanged counter (a frame repeated by a hung sender).
        """
        layout = self._packing
        if len(data) != _BYTES:
            raise self._refuse(f"{len(data)} bytes, expected {_BYTES}")
        if layout.has_crc and data[7] != binascii.crc_hqx(data[:7], self._crc_begun) & 0xFF:
            raise self._refuse("wrong CRC")
        values, counter = layout.unpack_in_order(data)
        if counter == self._counter:
            raise self._refuse("rolling counter stands still")
        if self._counter is not None:
            self.skipped += (counter - self._counter - 1) & 0xF
        self._counter = counter
        self.taken += 1
        return values

    def _refuse(self, why: str) -> BadFrame:
        self.refused += 1
        return BadFrame(f"{self.name}: {why}")
