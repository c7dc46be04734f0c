"""What the two sites stream to each other: where the operator's fingertips are, and what the remote ones touch.

Floats of all fingers travel as one packed little-endian float32 block. The same checks run when a packet is made:
nothing that the far side would refuse is sent.
"""

from dataclasses import dataclass
from enum import IntEnum

import numpy as np

from common.packets import (
    SCHEMA_VERSION,
    BadPacket,
    Floats,
    LinkState,
    N,
    check_block,
    pack,
    read_block,
    read_enum,
    read_header,
    read_integer,
    read_text,
    unpack,
)

EVENT_MAX = 2000.0
"""Largest value of an event, in its own unit."""
MAX_EVENTS = 24
"""Events in one touch packet: newest last."""


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
        check_block(self.block, _MOTION_LOW, _MOTION_HIGH, MOTION_FIELDS)
        return pack([SCHEMA_VERSION, self.session, self.sequence, self.time_ns, int(self.state), self.block.tobytes()])

    @classmethod
    def decode(cls, packet: bytes) -> "Motion":
        """Check and unpack; raises BadPacket."""
        _, session, sequence, time_ns, state, raw = unpack(packet, 6)
        block = read_block(raw, _MOTION_LOW, _MOTION_HIGH, MOTION_FIELDS)
        return cls(*read_header(session, sequence, time_ns), read_enum(LinkState, state), block)


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
        check_block(self.block, TOUCH_LOW, TOUCH_HIGH, TOUCH_FIELDS)
        events = [[e.ident, int(e.kind), e.finger, e.time_ns, e.value, e.name] for e in self.events]
        return pack(
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
        _, session, sequence, time_ns, state, raw, materials, events = unpack(packet, 8)
        block = read_block(raw, TOUCH_LOW, TOUCH_HIGH, TOUCH_FIELDS)
        if not isinstance(materials, list) or len(materials) != N:
            raise BadPacket(f"materials: expected a list of {N} names")
        if not isinstance(events, list) or len(events) > MAX_EVENTS:
            raise BadPacket(f"events: expected a list of at most {MAX_EVENTS}")
        return cls(
            *read_header(session, sequence, time_ns),
            read_enum(LinkState, state),
            block,
            tuple(read_text(name, "material") for name in materials),
            tuple(_event(item) for item in events),
        )


def _event(item: object) -> Event:
    if not isinstance(item, list) or len(item) != 6:
        raise BadPacket("event: expected a list of 6")
    ident, kind, finger, time_ns, value, name = item
    if type(value) is not float or not 0.0 <= value <= EVENT_MAX:
        raise BadPacket("event: value is not a number in 0..2000")
    return Event(
        read_integer(ident, "event"),
        read_enum(EventKind, kind),
        read_integer(finger, "event finger", 0, N - 1),
        read_integer(time_ns, "event time"),
        value,
        read_text(name, "event name"),
    )
