"""What every packet of the link is made of: MessagePack lists, checked field by field.

A packet is one list that begins with schema version, session, sequence and source time (ns of the sender's monotonic
clock). The checks run on decode and, where they can fail there, when a packet is made.
"""

import math
from enum import IntEnum
from typing import Any, TypeVar, cast

import msgpack
import numpy as np
from numpy.typing import NDArray

from common.fingers import FINGERS

SCHEMA_VERSION = 6
MAX_PACKET = 6144
"""No packet of this link is larger, bytes."""
MAX_INTEGER = 2**63 - 1
MAX_TEXT = 40
"""Characters of a name."""

Floats = NDArray[np.float32]
N = len(FINGERS)
_E = TypeVar("_E", bound=IntEnum)


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


_LINK_STATES = tuple(LinkState)
_packer = msgpack.Packer(use_bin_type=True)


def pack(fields: list[Any]) -> bytes:
    """Packet bytes of a list that begins with the schema version.

    Raises:
        BadPacket: it would be longer than MAX_PACKET.
    """
    packet: bytes = _packer.pack(fields)
    if len(packet) > MAX_PACKET:
        raise BadPacket(f"a packet of {len(packet)} bytes is longer than {MAX_PACKET}")
    return packet


def unpack(packet: bytes, length: int) -> list[Any]:
    """The fields of a packet of this schema version: the four of its header, checked, and the others as they came.

    A packet comes after a pause in which all that reads it has left the processor's caches: each further function and
    each loop costs more than a microsecond then, so that what every packet goes through is written out here.

    Raises:
        WrongVersion: it is of another version.
        BadPacket: it is not a list of `length` fields, or its header is not what it should be.
    """
    if len(packet) > MAX_PACKET:
        raise BadPacket(f"a packet of {len(packet)} bytes is longer than {MAX_PACKET}")
    try:
        fields = msgpack.unpackb(packet)
    except Exception as error:
        raise _not_messagepack(error) from None
    if type(fields) is not list or len(fields) != length or fields[0] != SCHEMA_VERSION or type(fields[0]) is not int:
        raise _otherwise(fields, length)
    _, session, sequence, time_ns = fields[:4]
    if type(session) is not int or type(sequence) is not int or type(time_ns) is not int:
        raise BadPacket("session, sequence or time_ns: not an integer")
    if session < 0 or sequence < 0 or time_ns < 0:
        raise BadPacket("session, sequence or time_ns: negative")
    if session > MAX_INTEGER or sequence > MAX_INTEGER or time_ns > MAX_INTEGER:
        raise BadPacket(f"session, sequence or time_ns: more than {MAX_INTEGER}")
    return fields


def _otherwise(fields: object, length: int) -> BadPacket:
    """Why this is not a list of so many fields of this schema version."""
    if type(fields) is not list:
        return BadPacket("not a list")
    version = fields[0] if fields else None
    if version != SCHEMA_VERSION or type(version) is not int:
        # Only an integer is shown: printing something deeply nested would raise an error of its own.
        shown = version if type(version) is int else type(version).__name__
        return WrongVersion(f"schema version {shown}, this side speaks {SCHEMA_VERSION}")
    return BadPacket(f"{len(fields)} fields, expected {length}")


def _not_messagepack(error: Exception) -> BadPacket:
    """The unpacker's own errors have no common base; whatever it meets, the packet is what is wrong."""
    return BadPacket(f"not MessagePack: {type(error).__name__}")


def unpack_list(packed: bytes) -> list[Any]:
    """The list that these bytes inside a packet hold; raises BadPacket."""
    try:
        fields = msgpack.unpackb(packed)
    except Exception as error:
        raise _not_messagepack(error) from None
    if type(fields) is not list:
        raise BadPacket("not a list")
    return fields


def read_integer(value: object, name: str, low: int = 0, high: int = MAX_INTEGER) -> int:
    """`value` when it is an integer in low..high; raises BadPacket."""
    if type(value) is not int or not low <= value <= high:
        raise BadPacket(f"{name}: not an integer in {low}..{high}")
    return value


def read_state(value: object) -> LinkState:
    """The state that a site says it is in; raises BadPacket."""
    if type(value) is not int or not 0 <= value < len(_LINK_STATES):
        raise BadPacket(f"LinkState: not an integer in 0..{len(_LINK_STATES) - 1}")
    return _LINK_STATES[value]


def read_text(value: object, name: str, longest: int = MAX_TEXT) -> str:
    """`value` when it is a text of at most `longest` characters; raises BadPacket."""
    if not isinstance(value, str) or len(value) > longest:
        raise BadPacket(f"{name}: not a text of at most {longest} characters")
    return value


def read_texts(value: object, name: str, count: int) -> tuple[str, ...]:
    """`value` when it is a list of `count` texts, each as `read_text` takes it; raises BadPacket."""
    if type(value) is not list or len(value) != count:
        raise BadPacket(f"{name}: not a list of {count} texts")
    for text in value:
        if type(text) is not str or len(text) > MAX_TEXT:
            raise BadPacket(f"{name}: not texts of at most {MAX_TEXT} characters")
    return tuple(value)


def read_details(value: object) -> dict[str, Any]:
    """`value` when it is a flat map with text keys; raises BadPacket."""
    if not isinstance(value, dict) or not all(isinstance(key, str) for key in value):
        raise BadPacket("details: not a map with text keys")
    for item in value.values():
        if not all(_plain(part) for part in (item if isinstance(item, list) else (item,))):
            raise BadPacket("details: values must be nil, booleans, finite numbers, texts, or lists of these")
    return value


def _plain(value: object) -> bool:
    return value is None or isinstance(value, (bool, int, str)) or (isinstance(value, float) and math.isfinite(value))


def read_enum(kind: type[_E], value: object) -> _E:
    """The member of `kind` that `value` stands for; raises BadPacket."""
    if type(value) is not int or value not in kind._value2member_map_:
        raise BadPacket(f"{kind.__name__}: not an integer in 0..{len(kind) - 1}")
    return cast(_E, kind._value2member_map_[value])
