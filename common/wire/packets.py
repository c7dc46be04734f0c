"""The form of every packet of the link: a MessagePack list with typed fields.

A packet begins with schema version, session, sequence and source time (ns of the sender's monotonic clock). The checks
run on decode and, where they can fail there, when a packet is made.
"""

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
