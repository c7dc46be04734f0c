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
"""Maximum size of a packet, bytes."""
MAX_INTEGER = 2**63 - 1
MAX_TEXT = 40
"""Maximum length of a name, characters."""

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
    """A packet that violates the schema; the only error that decoding raises."""


class WrongVersion(BadPacket):
    """A packet of another schema version."""


class LinkState(IntEnum):
    """State of a site's session in packets."""

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
        """Return the packet's bytes; raises BadPacket on more than MAX_PACKET bytes."""
        return pack(self)

    @classmethod
    def decode(cls, packet: bytes) -> Self:
        """Check and unpack.

        Raises:
            WrongVersion: the packet has another schema version.
            BadPacket: a field, or the number of fields, violates the schema.
        """
        _check_length(packet)
        try:
            return _decode(packet, type=cls)
        except Exception as error:  # what the decoder raises has no common base
            raise _refusal(cls, packet, str(error)) from None


class FingerBlock:
    """Columns of a block (5, columns) of little-endian float32, each with its range.

    A check compares the block as one whole number whose 32-bit digits are its floats. As bits, floats without their
    signs are ordered as their values are, infinity and NaN above all others. One subtraction from the largest block
    compares all digits. After a pause, with cold caches, this takes no longer than creating an array. A block that
    does not pass is checked again, float by float.

    Attributes:
        names: names of the columns, in order.
        low, high: range of each column, float32 (columns,).
    """

    def __init__(
        self,
        ranges: Mapping[str, tuple[float, float]],
        codes: Sequence[str] = (),
        agree: Callable[[Sequence[float]], bool] = lambda codes: True,
    ):
        """Define a block.

        Args:
            ranges: range of each column.
            codes: columns that hold codes, which are whole numbers.
            agree: returns whether the codes of one finger, in the order of the columns, are consistent.
        """
        self._agree = agree
        self.names = tuple(ranges)
        self.low: Floats = np.array([low for low, _ in ranges.values()], dtype=_FLOAT32)
        self.high: Floats = np.array([high for _, high in ranges.values()], dtype=_FLOAT32)
        self._shape = (N, len(self.names))
        self._bytes = 4 * N * len(self.names)
        # In a symmetric column the sign does not matter; in another one, a sign leads to the check float by float.
        signed = self.low == -self.high
        self._signs = self._number([_SIGN] * len(self.names))
        self._magnitudes = self._number([_SIGN - 1 if either else 2 * _SIGN - 1 for either in signed])
        self._largest = self._number([_SIGN | int(bits) for bits in self.high.view(np.uint32)])
        self._code_bits = self._number([2 * _SIGN - 1 if name in codes else 0 for name in self.names])
        self._code_columns = [column for column, name in enumerate(self.names) if name in codes]
        self._known_codes: set[int] = set()

    def _number(self, digits: Sequence[int]) -> int:
        """Return the whole number with these 32-bit digits for each finger, one for a column."""
        return int.from_bytes(np.tile(np.array(digits, dtype="<u4"), N).tobytes(), "little")

    def to_bytes(self, block: Floats) -> bytes:
        """Return the bytes of a block; values are not checked yet. Raises BadPacket on another shape or type."""
        if block.shape != self._shape or block.dtype != _FLOAT32:
            raise BadPacket(f"block: expected float32 {self._shape}, not {block.dtype} {block.shape}")
        return block.tobytes()

    def array(self, raw: bytes) -> Floats:
        """Return the block (5, columns) of these bytes, read only."""
        return np.ndarray(self._shape, _FLOAT32, raw)

    def check(self, raw: object) -> bytes:
        """Return `raw`, the bytes of a block; raises BadPacket on a value out of its column's range."""
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
        """Raise BadPacket on a value out of its range; NaN fails both comparisons."""
        wrong = np.argwhere(~((block >= self.low) & (block <= self.high)))
        if len(wrong):
            finger, column = wrong[0]
            raise BadPacket(
                f"{FINGERS[finger]}.{self.names[column]}: {block[finger, column]} is outside "
                f"{self.low[column]:g}..{self.high[column]:g}"
            )

    def _learn(self, codes: int, block: Floats) -> None:
        """Remember codes that are whole numbers and consistent, because they recur; raises BadPacket."""
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
    """Return the MessagePack bytes of a packet or a part of one; raises BadPacket on more than MAX_PACKET bytes."""
    packed = _encode(value)
    _check_length(packed)
    return packed


def unpack(packed: bytes, kind: type[_T], name: str) -> _T:
    """Return the value of a type from bytes within a packet; raises BadPacket with the name of the part."""
    try:
        return _decode(packed, type=kind)
    except Exception as error:
        raise BadPacket(f"{name}: {error}") from None


def _check_length(packet: bytes) -> None:
    if len(packet) > MAX_PACKET:
        raise BadPacket(f"a packet of {len(packet)} bytes is longer than {MAX_PACKET}")


def _refusal(kind: type[Packet], packet: bytes, error: str) -> BadPacket:
    """Return the reason why these bytes are no packet of this kind."""
    try:
        fields = _decode(packet, type=list[Raw])
        version: Any = _decode(fields[0]) if fields else None
    except Exception:
        return BadPacket(f"not a packet: {error}")
    if type(version) is not int or version != SCHEMA_VERSION:
        # Only an integer is shown, because a deeply nested value cannot be.
        shown = version if type(version) is int else type(version).__name__
        return WrongVersion(f"schema version {shown}, this side speaks {SCHEMA_VERSION}")
    return BadPacket(misfit(("schema", *kind.__struct_fields__), error))
