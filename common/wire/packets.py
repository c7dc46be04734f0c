"""The form of every packet of the link: a MessagePack list with typed fields, and a block with numbers of each finger.

A packet begins with schema version, session, sequence and source time (ns of the sender's monotonic clock). The checks
run on decode and, where they can fail there, when a packet is made.
"""

from collections.abc import Callable, Mapping, Sequence
from enum import IntEnum
from typing import Annotated, Any, Self, TypeVar

import msgspec
import numpy as np
from msgspec import Meta, Raw, Struct
from numpy.typing import NDArray

from common.fingers import FINGERS
from common.wire.misfit import misfit

SCHEMA_VERSION = 7
MAX_PACKET = 6144
"""No packet of this link is larger, bytes."""
MAX_INTEGER = 2**63 - 1
MAX_TEXT = 40
"""Characters of a name."""

Floats = NDArray[np.float32]
N = len(FINGERS)
Integer = Annotated[int, Meta(ge=0, le=MAX_INTEGER)]
Name = Annotated[str, Meta(max_length=MAX_TEXT)]
_FLOAT32 = np.dtype("<f4")
_SIGN = 1 << 31
_MOST_KNOWN = 256
"""Maximum number of combinations of codes that a block remembers."""
_T = TypeVar("_T")
_encode = msgspec.msgpack.Encoder().encode
_decode = msgspec.msgpack.decode


class BadPacket(ValueError):
    """A packet that is not what the schema promises. The only error that decoding raises."""


class WrongVersion(BadPacket):
    """A packet of another schema version."""


class LinkState(IntEnum):
    """State of a site's session, as it travels in packets."""

    DISCONNECTED = 0
    CONNECTED = 1
    ENGAGED = 2
    FAULT = 3


class Packet(Struct, array_like=True, forbid_unknown_fields=True, frozen=True, tag=SCHEMA_VERSION):
    """Header of every packet. On the wire the schema version stands before it."""

    session: Integer
    sequence: Integer
    time_ns: Integer

    def encode(self) -> bytes:
        """Packet bytes; raises BadPacket where there would be more than MAX_PACKET."""
        return pack(self)

    @classmethod
    def decode(cls, packet: bytes) -> Self:
        """Check and unpack.

        Raises:
            WrongVersion: it is of another schema version.
            BadPacket: a field, or their number, is not what the schema promises.
        """
        _check_length(packet)
        try:
            return _decode(packet, type=cls)
        except Exception as error:  # what the decoder raises has no common base
            raise _refusal(cls, packet, str(error)) from None


class FingerBlock:
    """Columns of a block (5, columns) of floats.

    A block is judged as one whole number whose 32-bit digits are its floats. As bits, floats without their signs are
    ordered as their values are, infinity and NaN above all others: one subtraction from the largest block compares all
    digits. That is quicker than comparing arrays after a pause, when nothing is in the processor's caches; even making
    an array takes as long then as all of that, and is left to who reads the floats. What does not pass so is judged
    again, float by float.

    Attributes:
        names: of the columns, in order.
        low, high: what each column may hold, float32 (columns,).
    """

    def __init__(
        self,
        ranges: Mapping[str, tuple[float, float]],
        codes: Sequence[str] = (),
        agree: Callable[[Sequence[float]], bool] = lambda codes: True,
    ):
        """A block of columns.

        Args:
            ranges: of each column.
            codes: columns that stand for words and hold whole numbers.
            agree: whether the codes of one finger, in the order of the columns, may stand together.
        """
        self._agree = agree
        self.names = tuple(ranges)
        self.low: Floats = np.array([low for low, _ in ranges.values()], dtype=_FLOAT32)
        self.high: Floats = np.array([high for _, high in ranges.values()], dtype=_FLOAT32)
        self._shape = (N, len(self.names))
        self._bytes = 4 * N * len(self.names)
        # Where a column is symmetric, a float without its sign tells all; elsewhere a sign is not passed at once.
        signed = self.low == -self.high
        self._signs = self._number([_SIGN] * len(self.names))
        self._magnitudes = self._number([_SIGN - 1 if either else 2 * _SIGN - 1 for either in signed])
        self._largest = self._number([_SIGN | int(bits) for bits in self.high.view(np.uint32)])
        self._code_bits = self._number([2 * _SIGN - 1 if name in codes else 0 for name in self.names])
        self._code_columns = [column for column, name in enumerate(self.names) if name in codes]
        self._known_codes: set[int] = set()

    def _number(self, digits: Sequence[int]) -> int:
        """The whole number with these 32-bit digits for each finger, one for a column."""
        return int.from_bytes(np.tile(np.array(digits, dtype="<u4"), N).tobytes(), "little")

    def to_bytes(self, block: Floats) -> bytes:
        """Bytes of a block, whose values are not judged yet; raises BadPacket on another shape or type."""
        if block.shape != self._shape or block.dtype != _FLOAT32:
            raise BadPacket(f"block: expected float32 {self._shape}, not {block.dtype} {block.shape}")
        return block.tobytes()

    def array(self, raw: bytes) -> Floats:
        """The block (5, columns) that these bytes are; it cannot be written to."""
        return np.ndarray(self._shape, _FLOAT32, raw)

    def check(self, raw: object) -> bytes:
        """`raw`, the bytes of a block; raises BadPacket where a value is not what its column may hold."""
        if type(raw) is not bytes or len(raw) != self._bytes:
            raise BadPacket(f"block: expected {self._bytes} bytes")
        bits = int.from_bytes(raw, "little")
        floats = bits & self._magnitudes
        if floats & self._signs or (self._largest - floats) & self._signs != self._signs:
            self._judge(self.array(raw))
        if (codes := bits & self._code_bits) not in self._known_codes:
            self._learn(codes, self.array(raw))
        return raw

    def _judge(self, block: Floats) -> None:
        """Raise BadPacket where a value is out of its range; NaN fails both comparisons."""
        wrong = np.argwhere(~((block >= self.low) & (block <= self.high)))
        if len(wrong):
            finger, column = wrong[0]
            raise BadPacket(
                f"{FINGERS[finger]}.{self.names[column]}: {block[finger, column]} is outside "
                f"{self.low[column]:g}..{self.high[column]:g}"
            )

    def _learn(self, codes: int, block: Floats) -> None:
        """Remember codes that are whole numbers and agree: the same ones come again and again; raises BadPacket."""
        values = block[:, self._code_columns]
        if (values != np.round(values)).any():
            raise BadPacket(
                f"block: {', '.join(self.names[column] for column in self._code_columns)}: not whole numbers"
            )
        for finger, row in zip(FINGERS, values.tolist(), strict=True):
            if not self._agree(row):
                raise BadPacket(f"{finger}: codes {row} do not agree")
        if len(self._known_codes) >= _MOST_KNOWN:
            self._known_codes.clear()
        self._known_codes.add(codes)


def pack(value: object) -> bytes:
    """MessagePack bytes of a packet or of a part of one; raises BadPacket where there would be more than MAX_PACKET."""
    packed = _encode(value)
    _check_length(packed)
    return packed


def unpack(packed: bytes, kind: type[_T], name: str) -> _T:
    """The value of a type that these bytes within a packet hold; raises BadPacket, with the name of the part."""
    try:
        return _decode(packed, type=kind)
    except Exception as error:
        raise BadPacket(f"{name}: {error}") from None


def _check_length(packet: bytes) -> None:
    if len(packet) > MAX_PACKET:
        raise BadPacket(f"a packet of {len(packet)} bytes is longer than {MAX_PACKET}")


def _refusal(kind: type[Packet], packet: bytes, error: str) -> BadPacket:
    """Why these bytes are no packet of this kind."""
    try:
        fields = _decode(packet, type=list[Raw])
        version: Any = _decode(fields[0]) if fields else None
    except Exception:
        return BadPacket(f"not a packet: {error}")
    if type(version) is not int or version != SCHEMA_VERSION:
        # Only an integer is shown: something deeply nested cannot be.
        shown = version if type(version) is int else type(version).__name__
        return WrongVersion(f"schema version {shown}, this side speaks {SCHEMA_VERSION}")
    return BadPacket(misfit(("schema", *kind.__struct_fields__), error))
