"""What the two sites say to each other: MessagePack lists, checked field by field on decode.

Every packet is one list that begins with schema version, session, sequence and source time (ns of
the sender's monotonic clock). Floats of all fingers travel as one packed little-endian float32
block. The same checks run when a packet is made: nothing that the far side would refuse is sent.
"""

import math
from dataclasses import dataclass
from enum import IntEnum
from typing import Any, TypeVar

import msgpack
import numpy as np
from numpy.typing import NDArray

from common.fingers import FINGERS

SCHEMA_VERSION = 1
MAX_PACKET = 4096
"""No packet of this link is larger, bytes."""
LONGEST_REFUSAL = 400
"""Characters of an answer's reason."""
EVENT_MAX = 2000.0
"""Largest value of an event, in its own unit."""
MAX_EVENTS = 24
"""Events in one touch packet: newest last."""

_E = TypeVar("_E", bound=IntEnum)
Floats = NDArray[np.float32]
N = len(FINGERS)


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


class ExplorationMode(IntEnum):
    """What a fingertip is doing (Kron & Schmidt 2003, section 3.1)."""

    FREE = 0
    TAPPING = 1
    QUIESCENT = 2
    STROKING = 3


class ThermalStatus(IntEnum):
    """What can be said about an object's material."""

    NONE = 0
    NO_CONTACT = 1
    DECIDING = 2
    IDENTIFIED = 3
    AMBIGUOUS = 4
    UNKNOWN = 5
    UNIDENTIFIABLE = 6


class EventKind(IntEnum):
    """Happenings that must not be lost with a superseded packet."""

    TAP = 0
    GROOVE = 1
    MATERIAL = 2


MOTION_FIELDS = ("x_m", "y_m", "z_m")
_MOTION_LOW = np.array([-0.66, -0.66, -0.0103], dtype=np.float32)
_MOTION_HIGH = np.array([0.66, 0.66, 0.0103], dtype=np.float32)

TOUCH_RANGES = {
    "mode": (0, 3),
    "contact": (0, 1),
    "contact_force_n": (0, 10.5),
    "surface_z_m": (-0.011, 0.011),
    "stiffness_n_m": (0, 20_000),
    "k_tap": (0, 20_000),
    "b_tap_per_s": (0, 1000),
    "k_stroke_v": (0, 50_000),
    "k_stroke_f": (0, 5000),
    "groove_rad_s": (0, 1100),
    "b_groove_per_s": (0, 1000),
    "conductivity_w_mk": (0, 500),
    "density_kg_m3": (0, 25_000),
    "specific_heat_j_kgk": (0, 10_000),
    "object_c": (-50, 150),
    "object_c_sd": (0, 100),
    "probability": (0, 1),
    "thermal_status": (0, len(ThermalStatus) - 1),
}
"""Columns of the touch block in order, each with the range that decoding enforces.

k_tap and k_stroke_v in (rad/s)/(m/s), k_stroke_f in (rad/s)/N (Kron & Schmidt 2003, Eq. 1-2); a
conductivity of 0 W/mK says that the object's thermal constants are not known.
"""
TOUCH_FIELDS = tuple(TOUCH_RANGES)
TOUCH_COLUMN = {name: column for column, name in enumerate(TOUCH_FIELDS)}
TOUCH_LOW = np.array([low for low, _ in TOUCH_RANGES.values()], dtype=np.float32)
TOUCH_HIGH = np.array([high for _, high in TOUCH_RANGES.values()], dtype=np.float32)


@dataclass(frozen=True, slots=True)
class Event:
    """One happening at a finger; `ident` is unique in the session, so each is played once.

    `value`: approach speed in m/s of a tap, amplitude in rad/s of a groove, probability of a material.
    """

    ident: int
    kind: EventKind
    finger: int
    time_ns: int
    value: float
    name: str = ""


@dataclass(frozen=True, slots=True)
class Motion:
    """Where the operator's fingertips are: block (5, 3) of `MOTION_FIELDS`, m."""

    session: int
    sequence: int
    time_ns: int
    state: LinkState
    block: Floats

    def encode(self) -> bytes:
        """Packet bytes; raises BadPacket on a value out of range."""
        _check_block(self.block, _MOTION_LOW, _MOTION_HIGH, MOTION_FIELDS)
        return _pack([SCHEMA_VERSION, self.session, self.sequence, self.time_ns, int(self.state), self.block.tobytes()])

    @classmethod
    def decode(cls, packet: bytes) -> "Motion":
        """Check and unpack; raises BadPacket."""
        _, session, sequence, time_ns, state, raw = _unpack(packet, 6)
        block = _block(raw, _MOTION_LOW, _MOTION_HIGH, MOTION_FIELDS)
        return cls(*_header(session, sequence, time_ns), _enum(LinkState, state), block)


@dataclass(frozen=True, slots=True)
class Touch:
    """What the remote fingers touch: block (5, 18) of `TOUCH_FIELDS`, names of the likeliest materials, events."""

    session: int
    sequence: int
    time_ns: int
    state: LinkState
    block: Floats
    materials: tuple[str, ...]
    events: tuple[Event, ...]

    def encode(self) -> bytes:
        """Packet bytes; raises BadPacket on a value out of range."""
        _check_block(self.block, TOUCH_LOW, TOUCH_HIGH, TOUCH_FIELDS)
        events = [[e.ident, int(e.kind), e.finger, e.time_ns, e.value, e.name] for e in self.events]
        return _pack(
            [
                SCHEMA_VERSION,
                self.session,
                self.sequence,
                self.time_ns,
                int(self.state),
                self.block.tobytes(),
                list(self.materials),
                events,
            ]
        )

    @classmethod
    def decode(cls, packet: bytes) -> "Touch":
        """Check and unpack; raises BadPacket."""
        _, session, sequence, time_ns, state, raw, materials, events = _unpack(packet, 8)
        block = _block(raw, TOUCH_LOW, TOUCH_HIGH, TOUCH_FIELDS)
        if not isinstance(materials, list) or len(materials) != N:
            raise BadPacket(f"materials: expected a list of {N} names")
        if not isinstance(events, list) or len(events) > MAX_EVENTS:
            raise BadPacket(f"events: expected a list of at most {MAX_EVENTS}")
        return cls(
            *_header(session, sequence, time_ns),
            _enum(LinkState, state),
            block,
            tuple(_text(name, "material") for name in materials),
            tuple(_event(item) for item in events),
        )


@dataclass(frozen=True, slots=True)
class Heartbeat:
    """One leg of the clock comparison, from the loop itself.

    The operator sends `sent_ns`; the remote answers with it, its own arrival time `arrived_ns` and
    `time_ns` as the time of the answer. `offset_ns` +- `uncertainty_ns` is what the operator found so
    far for (remote clock - operator clock); an uncertainty of 0 says nothing was found yet.
    """

    session: int
    sequence: int
    time_ns: int
    state: LinkState
    sent_ns: int
    arrived_ns: int
    offset_ns: int
    uncertainty_ns: int

    def encode(self) -> bytes:
        """Packet bytes."""
        return _pack(
            [
                SCHEMA_VERSION,
                self.session,
                self.sequence,
                self.time_ns,
                int(self.state),
                self.sent_ns,
                self.arrived_ns,
                self.offset_ns,
                self.uncertainty_ns,
            ]
        )

    @classmethod
    def decode(cls, packet: bytes) -> "Heartbeat":
        """Check and unpack; raises BadPacket."""
        _, session, sequence, time_ns, state, sent, arrived, offset, uncertainty = _unpack(packet, 9)
        return cls(
            *_header(session, sequence, time_ns),
            _enum(LinkState, state),
            _integer(sent, "sent_ns"),
            _integer(arrived, "arrived_ns"),
            _integer(offset, "offset_ns", low=-(2**63)),
            _integer(uncertainty, "uncertainty_ns"),
        )


REQUESTS = ("hello", "engage", "disengage", "estop", "clear_fault", "annotate")


@dataclass(frozen=True, slots=True)
class Request:
    """A control request; `details` holds a hello's capabilities or an annotation's text."""

    session: int
    sequence: int
    time_ns: int
    verb: str
    details: dict[str, Any]

    def encode(self) -> bytes:
        """Packet bytes."""
        return _pack([SCHEMA_VERSION, self.session, self.sequence, self.time_ns, self.verb, self.details])

    @classmethod
    def decode(cls, packet: bytes) -> "Request":
        """Check and unpack; raises BadPacket."""
        _, session, sequence, time_ns, verb, details = _unpack(packet, 6)
        if not isinstance(verb, str) or verb not in REQUESTS:
            raise BadPacket(f"unknown request {verb[:40] if isinstance(verb, str) else type(verb).__name__!r}")
        return cls(*_header(session, sequence, time_ns), verb, _details(details))


@dataclass(frozen=True, slots=True)
class Answer:
    """The answer to the request of the same sequence number; `refused` is empty when it was done."""

    session: int
    sequence: int
    time_ns: int
    refused: str
    details: dict[str, Any]

    def encode(self) -> bytes:
        """Packet bytes."""
        return _pack([SCHEMA_VERSION, self.session, self.sequence, self.time_ns, self.refused, self.details])

    @classmethod
    def decode(cls, packet: bytes) -> "Answer":
        """Check and unpack; raises BadPacket."""
        _, session, sequence, time_ns, refused, details = _unpack(packet, 6)
        return cls(*_header(session, sequence, time_ns), _text(refused, "refused", LONGEST_REFUSAL), _details(details))


_packer = msgpack.Packer(use_bin_type=True)


def _pack(fields: list[Any]) -> bytes:
    packet: bytes = _packer.pack(fields)
    if len(packet) > MAX_PACKET:
        raise BadPacket(f"a packet of {len(packet)} bytes is longer than {MAX_PACKET}")
    return packet


def _unpack(packet: bytes, length: int) -> list[Any]:
    if len(packet) > MAX_PACKET:
        raise BadPacket(f"a packet of {len(packet)} bytes is longer than {MAX_PACKET}")
    try:
        fields = msgpack.unpackb(packet)
    except Exception as error:
        # The unpacker's own errors have no common base; whatever it meets, the packet is what is wrong.
        raise BadPacket(f"not MessagePack: {type(error).__name__}") from None
    if not isinstance(fields, list) or not fields:
        raise BadPacket("not a list")
    version = fields[0]
    if type(version) is not int or version != SCHEMA_VERSION:
        # Only an integer is shown: printing something deeply nested would raise an error of its own.
        shown = version if type(version) is int else type(version).__name__
        raise WrongVersion(f"schema version {shown}, this side speaks {SCHEMA_VERSION}")
    if len(fields) != length:
        raise BadPacket(f"{len(fields)} fields, expected {length}")
    return fields


def _integer(value: object, name: str, low: int = 0, high: int = 2**63 - 1) -> int:
    if type(value) is not int or not low <= value <= high:
        raise BadPacket(f"{name}: not an integer in {low}..{high}")
    return value


def _header(session: object, sequence: object, time_ns: object) -> tuple[int, int, int]:
    return _integer(session, "session"), _integer(sequence, "sequence"), _integer(time_ns, "time_ns")


def _text(value: object, name: str, longest: int = 40) -> str:
    if not isinstance(value, str) or len(value) > longest:
        raise BadPacket(f"{name}: not a text of at most {longest} characters")
    return value


def _details(value: object) -> dict[str, Any]:
    if not isinstance(value, dict) or not all(isinstance(key, str) for key in value):
        raise BadPacket("details: not a map with text keys")
    for item in value.values():
        if not all(_plain(part) for part in (item if isinstance(item, list) else (item,))):
            raise BadPacket("details: values must be nil, booleans, finite numbers, texts, or lists of these")
    return value


def _plain(value: object) -> bool:
    return value is None or isinstance(value, (bool, int, str)) or (isinstance(value, float) and math.isfinite(value))


def _enum(kind: type[_E], value: object) -> _E:
    number = _integer(value, kind.__name__, 0, 255)
    try:
        return kind(number)
    except ValueError:
        raise BadPacket(f"{kind.__name__}: no value {number}") from None


def _block(raw: object, low: Floats, high: Floats, names: tuple[str, ...]) -> Floats:
    if not isinstance(raw, bytes) or len(raw) != 4 * N * len(names):
        raise BadPacket(f"block: expected {4 * N * len(names)} bytes")
    block = np.frombuffer(raw, dtype="<f4").reshape(N, len(names))
    _check_block(block, low, high, names)
    return block


def _check_block(block: Floats, low: Floats, high: Floats, names: tuple[str, ...]) -> None:
    # NaN fails both comparisons, so what is not finite is out of range.
    good = (block >= low) & (block <= high)
    if not good.all():
        finger, column = np.argwhere(~good)[0]
        raise BadPacket(
            f"{FINGERS[finger]}.{names[column]}: {block[finger, column]} is outside {low[column]:g}..{high[column]:g}"
        )


def _event(item: object) -> Event:
    if not isinstance(item, list) or len(item) != 6:
        raise BadPacket("event: expected a list of 6")
    ident, kind, finger, time_ns, value, name = item
    if type(value) is not float or not 0.0 <= value <= EVENT_MAX:
        raise BadPacket("event: value is not a number in 0..2000")
    return Event(
        _integer(ident, "event"),
        _enum(EventKind, kind),
        _integer(finger, "event finger", 0, N - 1),
        _integer(time_ns, "event time"),
        value,
        _text(name, "event name"),
    )
