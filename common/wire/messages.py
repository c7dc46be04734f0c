"""Packets that the sites stream to each other: motion of the operator's fingertips, and touch of the remote ones.

Floats of all fingers travel as one block. The same checks run when a packet is made, so that none is sent that the far
side would refuse.
"""

import struct
from collections.abc import Iterable, Sequence
from enum import IntEnum
from functools import lru_cache
from itertools import chain
from typing import Annotated, Any, NamedTuple, Self, get_type_hints

from msgspec import Meta, Struct

from common.wire.packets import BadPacket, FingerBlock, Floats, Integer, LinkState, N, Name, Packet, pack, unpack
from common.wire.touch_summary import NO_SUMMARIES, TouchSummary, pack_summaries, read_summaries

EVENT_MAX = 2000.0
"""Largest value of an event, in its own unit."""
MAX_EVENTS = 40
"""Maximum number of events in a touch packet, newest last: five fingers cross up to 375 grooves in a second, and a link
may be silent for 0.1 s."""


class ExplorationMode(IntEnum):
    """Exploration mode of a fingertip (Kron & Schmidt 2003, section 3.1)."""

    FREE = 0
    TAPPING = 1
    QUIESCENT = 2
    STROKING = 3

    @property
    def word(self) -> str:
        """The mode's word for readers, such as `resting`."""
        return "resting" if self is ExplorationMode.QUIESCENT else self.name.lower()


class ThermalStatus(IntEnum):
    """Status of the identification of an object's material."""

    NONE = 0
    NO_CONTACT = 1
    DECIDING = 2
    IDENTIFIED = 3
    AMBIGUOUS = 4
    UNKNOWN = 5
    UNIDENTIFIABLE = 6


class ThermalReason(IntEnum):
    """Reason of a status: why no material is named, or that the named one was found before.

    A touch that ends keeps its status, and the reason says how it ended.
    """

    NONE = 0
    NO_DIFFERENCE = 1
    NO_FIT = 2
    NOT_CALIBRATED = 3
    NOT_RULED_OUT = 4
    CONTACT_LOST = 5
    STROKED = 6
    STILL_WARM = 7
    TOUCHED_BEFORE = 8
    NO_READING = 9
    READINGS_MISSING = 10
    NOT_A_NUMBER = 11
    READING_STUCK = 12
    SENSOR_SHORTED = 13
    SENSOR_OPEN = 14
    SENSOR_JUMPS = 15
    SENSOR_FROZEN = 16

    @property
    def code(self) -> str:
        """The reason in files, such as `no-difference`; empty for NONE."""
        return self.name.lower().replace("_", "-") if self else ""


THERMAL_REASONS = {reason.code: reason for reason in ThermalReason}
"""Each reason by its code."""
_ENDED = {ThermalReason.CONTACT_LOST, ThermalReason.STROKED, *list(ThermalReason)[ThermalReason.NO_READING :]}
_EXPLAINS: dict[ThermalStatus, set[ThermalReason]] = {
    ThermalStatus.IDENTIFIED: _ENDED | {ThermalReason.TOUCHED_BEFORE},
    ThermalStatus.AMBIGUOUS: _ENDED | {ThermalReason.TOUCHED_BEFORE, ThermalReason.NOT_RULED_OUT},
    ThermalStatus.UNKNOWN: {ThermalReason.TOUCHED_BEFORE, ThermalReason.NO_FIT, ThermalReason.NOT_CALIBRATED},
    ThermalStatus.UNIDENTIFIABLE: _ENDED | {ThermalReason.STILL_WARM, ThermalReason.NO_DIFFERENCE},
}


def explains(reason: int, status: int) -> bool:
    """Return whether a status may have this reason; NONE is valid for each."""
    return not reason or ThermalReason(reason) in _EXPLAINS.get(ThermalStatus(status), ())


class EventKind(IntEnum):
    """Kinds of events that must not be lost with a superseded packet."""

    TAP = 0
    GROOVE = 1
    MATERIAL = 2


STIFFNESS_KNOWN_LN_SD = 0.06
"""Standard deviation of ln(stiffness) from which on a stiffness is not yet known, 1."""
OBJECT_UNKNOWN_SD_K = 50.0
"""Standard deviation that stands for an unknown temperature of the object, K."""


def _codes(kind: type[IntEnum]) -> str:
    return ", ".join(f"{member} {member.name.lower()}" for member in kind)


class Column(NamedTuple):
    """Definition of one number of a finger's row: lowest and highest value, unit, and meaning."""

    low: float
    high: float
    unit: str
    meaning: str


class MotionRow(NamedTuple):
    """Place of one fingertip of the operator: the columns of a `MOTION_BLOCK` in order."""

    x_m: Annotated[float, Column(-0.66, 0.66, "m", "place of the hand")]
    y_m: Annotated[float, Column(-0.66, 0.66, "m", "likewise")]
    z_m: Annotated[float, Column(-0.0103, 0.0103, "m", "height of the fingertip")]


class TouchRow(NamedTuple):
    """Touch of one remote finger: the columns of a `TOUCH_BLOCK` in order. Decoding enforces their ranges.

    The table in `docs/protocols.md` follows from this definition.
    """

    mode: Annotated[float, Column(0, 3, "", _codes(ExplorationMode))]
    contact: Annotated[float, Column(0, 1, "", "1 in contact")]
    contact_force_n: Annotated[float, Column(0, 10.5, "N", "force on the object")]
    x_m: Annotated[float, Column(-0.66, 0.66, "m", "where the remote hand was when this was measured")]
    y_m: Annotated[float, Column(-0.66, 0.66, "m", "likewise")]
    surface_z_m: Annotated[float, Column(-0.011, 0.011, "m", "height of the surface under the finger there")]
    stiffness_n_m: Annotated[float, Column(0, 20_000, "N/m", "**0: no surface**")]
    stiffness_ln_sd: Annotated[
        float,
        Column(
            0,
            10,
            "1",
            f"standard deviation of ln(stiffness); **{STIFFNESS_KNOWN_LN_SD:g} or more: not yet known**; "
            "until a press was measured, stiffness and surface are too low rather than too high",
        ),
    ]
    damping_n_s_m: Annotated[float, Column(0, 100, "N s/m", "of the object at the present force; 0 where not known")]
    slope_x: Annotated[float, Column(-1, 1, "1", "dz/dx of the surface along a stroke; 0 where not known")]
    slope_y: Annotated[float, Column(-1, 1, "1", "dz/dy, likewise")]
    k_tap: Annotated[
        float,
        Column(0, 20_000, "(rad/s)/(m/s)", "amplitude of a tap per approach speed (Kron & Schmidt 2003, Eq. 1)"),
    ]
    b_tap_per_s: Annotated[float, Column(0, 1000, "1/s", "its decay")]
    k_stroke_v: Annotated[float, Column(0, 50_000, "(rad/s)/(m/s)", "vibration per stroke speed (Eq. 2)")]
    k_stroke_f: Annotated[float, Column(0, 5000, "(rad/s)/N", "vibration per force (Eq. 2)")]
    groove_rad_s: Annotated[float, Column(0, 1100, "rad/s", "amplitude of a groove's impulse")]
    b_groove_per_s: Annotated[float, Column(0, 1000, "1/s", "its decay")]
    conductivity_w_mk: Annotated[float, Column(0, 500, "W/(m K)", "**0: thermal constants not known**")]
    density_kg_m3: Annotated[float, Column(0, 25_000, "kg/m3", "of the object")]
    specific_heat_j_kgk: Annotated[float, Column(0, 10_000, "J/(kg K)", "of the object")]
    effusivity_ln_sd: Annotated[
        float,
        Column(
            0, 10, "1", "standard deviation of ln(effusivity) of these three constants; 10 where they are not known"
        ),
    ]
    object_c: Annotated[float, Column(-50, 150, "C", "temperature of the object; 0 where not known")]
    object_c_sd: Annotated[
        float, Column(0, 100, "K", f"its standard deviation; **{OBJECT_UNKNOWN_SD_K:g}: not known**")
    ]
    probability: Annotated[float, Column(0, 1, "1", "of the likeliest material")]
    thermal_status: Annotated[float, Column(0, len(ThermalStatus) - 1, "", _codes(ThermalStatus))]
    thermal_reason: Annotated[
        float, Column(0, len(ThermalReason) - 1, "", "why the status is so, below; 0 where nothing explains it")
    ]


NO_TOUCH = TouchRow._make(0.0 for _ in TouchRow._fields)
"""Row of a finger that is not in use."""


def columns(row: type[MotionRow] | type[TouchRow]) -> dict[str, Column]:
    """Return the definition of each column of a row, in order."""
    return {name: hint.__metadata__[0] for name, hint in get_type_hints(row, include_extras=True).items()}


def _ranges(row: type[MotionRow] | type[TouchRow]) -> dict[str, tuple[float, float]]:
    return {name: (column.low, column.high) for name, column in columns(row).items()}


def _codes_agree(codes: Sequence[float]) -> bool:
    _, _, status, reason = codes
    return explains(int(reason), int(status))


MOTION_BLOCK = FingerBlock(_ranges(MotionRow))
TOUCH_RANGES = _ranges(TouchRow)
TOUCH_FIELDS = TouchRow._fields
TOUCH_COLUMN = {name: column for column, name in enumerate(TOUCH_FIELDS)}
TOUCH_BLOCK = FingerBlock(
    TOUCH_RANGES, codes=("mode", "contact", "thermal_status", "thermal_reason"), agree=_codes_agree
)
TOUCH_LOW, TOUCH_HIGH = TOUCH_BLOCK.low, TOUCH_BLOCK.high
_MOTION_ROW, _TOUCH_ROW = (struct.Struct(f"<{len(fields)}f") for fields in (MotionRow._fields, TOUCH_FIELDS))
_MOTION_ROWS, _TOUCH_ROWS = (struct.Struct(f"<{N * len(fields)}f") for fields in (MotionRow._fields, TOUCH_FIELDS))


def pack_rows(rows: Iterable[TouchRow]) -> bytes:
    """Return the bytes of a `TOUCH_BLOCK` from five rows; values are not checked yet.

    Raises:
        OverflowError: a value is too large for 32 bits.
    """
    return _TOUCH_ROWS.pack(*chain.from_iterable(rows))


class Event(NamedTuple):
    """One event at a finger.

    Attributes:
        ident: number, unique in the session, so that each event is played once.
        kind: kind of the event.
        finger: number of the finger.
        time_ns: time on the remote site's clock, ns.
        hand_ns: source time of the motion that the finger was following, on the operator's clock, ns; 0 without one.
        value: approach speed of a tap, m/s; amplitude of a groove, rad/s; probability of a material.
        name: name of the material.
    """

    ident: Integer
    kind: EventKind
    finger: Annotated[int, Meta(ge=0, le=N - 1)]
    time_ns: Integer
    hand_ns: Integer
    value: Annotated[float, Meta(ge=0.0, le=EVENT_MAX)]
    name: Name = ""


class _MotionPacket(Packet, frozen=True):
    """A motion on the wire; `floats` are the bytes of a `MOTION_BLOCK`."""

    state: LinkState
    floats: bytes


def pack_hand(x_m: float, y_m: float, z_m: Iterable[float]) -> bytes:
    """Return the bytes of a `MOTION_BLOCK` from the hand's place and five fingertips' heights, m; not checked yet.

    Raises:
        OverflowError: a value is too large for 32 bits.
    """
    return _MOTION_ROWS.pack(*chain.from_iterable([(x_m, y_m, height_m) for height_m in z_m]))


def motion_rows(floats: bytes) -> tuple[MotionRow, ...]:
    """Return the row of each finger from the bytes of a `MOTION_BLOCK`, as the far side reads them."""
    return tuple(map(MotionRow._make, _MOTION_ROW.iter_unpack(floats)))


def motion_packet(session: int, sequence: int, time_ns: int, state: LinkState, floats: bytes) -> bytes:
    """Return the packet of a motion; `floats` are the bytes of a `MOTION_BLOCK`.

    Raises:
        BadPacket: a value is out of range.
    """
    return _MotionPacket(session, sequence, time_ns, state, MOTION_BLOCK.check(floats)).encode()


class Motion(NamedTuple):
    """Places of the operator's fingertips."""

    session: int
    sequence: int
    time_ns: int
    state: LinkState
    rows: tuple[MotionRow, ...]

    def encode(self) -> bytes:
        """Return the packet's bytes; raises BadPacket on a value out of range."""
        return motion_packet(*self[:4], _MOTION_ROWS.pack(*chain.from_iterable(self.rows)))

    @classmethod
    def decode(cls, packet: bytes) -> Self:
        """Check and unpack; raises BadPacket."""
        sent = _MotionPacket.decode(packet)
        rows = motion_rows(MOTION_BLOCK.check(sent.floats))
        return cls(sent.session, sent.sequence, sent.time_ns, sent.state, rows)


class Touch(NamedTuple):
    """Touch of the remote fingers.

    Attributes:
        session, sequence, time_ns: header, as of each `Packet`.
        state: state of the remote site's session.
        floats: bytes of a `TOUCH_BLOCK`.
        materials: name of the likeliest material of each finger.
        events: newest events, newest last.
        summaries: summary of each finger for a person to read.
    """

    session: int
    sequence: int
    time_ns: int
    state: LinkState
    floats: bytes
    materials: tuple[str, ...]
    events: tuple[Event, ...]
    summaries: tuple[TouchSummary, ...] = NO_SUMMARIES

    def encode(self) -> bytes:
        """Return the packet's bytes; raises BadPacket on a value out of range."""
        floats, news = TOUCH_BLOCK.check(self.floats), _pack_news(self.materials, self.events)
        header = self.session, self.sequence, self.time_ns, self.state
        return _TouchPacket(*header, floats, news, pack_summaries(self.summaries)).encode()

    @classmethod
    def decode(cls, packet: bytes) -> "Touch":
        """Check and unpack; raises BadPacket."""
        sent = _TouchPacket.decode(packet)
        floats, news, summaries = TOUCH_BLOCK.check(sent.floats), _read_news(sent.news), read_summaries(sent.summaries)
        header = sent.session, sent.sequence, sent.time_ns, sent.state
        return cls(*header, floats, news.materials, news.events, summaries)

    @property
    def block(self) -> Floats:
        """(5, columns) of `TouchRow`; read only."""
        return TOUCH_BLOCK.array(self.floats)

    @property
    def rows(self) -> tuple[TouchRow, ...]:
        """The row of each finger."""
        return tuple(map(TouchRow._make, _TOUCH_ROW.iter_unpack(self.floats)))


class _TouchPacket(Packet, frozen=True):
    """A touch on the wire, with packed names and events, and packed summaries."""

    state: LinkState
    floats: bytes
    news: bytes
    summaries: bytes


class _News(Struct, array_like=True, forbid_unknown_fields=True, frozen=True):
    """Names and events of a touch."""

    materials: Annotated[tuple[Name, ...], Meta(min_length=N, max_length=N)]
    events: Annotated[tuple[Event, ...], Meta(max_length=MAX_EVENTS)]


_VALUE = Event._fields.index("value")


# Names and events stay the same for many packets, so the last results are cached. Reading them in each packet would
# cost as much as the rest of the packet.
@lru_cache(maxsize=64)
def _pack_news(materials: tuple[str, ...], events: tuple[Event, ...]) -> bytes:
    return pack(_News(materials, events))


@lru_cache(maxsize=64)
def _read_news(packed: bytes) -> _News:
    news = unpack(packed, _News, "news")
    # The decoder takes integers for floats, and a list that ends early for one with default values.
    for fields in unpack(packed, tuple[Any, list[list[Any]]], "news")[1]:
        if len(fields) != len(Event._fields) or type(fields[_VALUE]) is not float:
            raise BadPacket(f"news: not {len(Event._fields)} fields of an event, with a value that is a float")
    return news
