"""What the two sites stream to each other: where the operator's fingertips are, and what the remote ones touch.

Floats of all fingers travel as one block. The same checks run when a packet is made: nothing that the far side would
refuse is sent.
"""

from enum import IntEnum
from functools import lru_cache
from typing import NamedTuple

from common.finger_block import FingerBlock
from common.packets import (
    SCHEMA_VERSION,
    BadPacket,
    Floats,
    LinkState,
    N,
    pack,
    read_enum,
    read_integer,
    read_state,
    read_text,
    read_texts,
    unpack,
    unpack_list,
)
from common.told import NOTHING_TOLD, Told, pack_told, read_told

EVENT_MAX = 2000.0
"""Largest value of an event, in its own unit."""
MAX_EVENTS = 40
"""Events in one touch packet, newest last: five fingers cross up to 375 grooves in a second, and a link may be silent
for 0.1 s."""


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


STIFFNESS_KNOWN_LN_SD = 0.06
"""A stiffness told with this standard deviation of its logarithm, or a larger one, is not yet known."""

MOTION_BLOCK = FingerBlock({"x_m": (-0.66, 0.66), "y_m": (-0.66, 0.66), "z_m": (-0.0103, 0.0103)})
MOTION_FIELDS = MOTION_BLOCK.names

TOUCH_RANGES = {
    "mode": (0, 3),
    "contact": (0, 1),
    "contact_force_n": (0, 10.5),
    "x_m": (-0.66, 0.66),
    "y_m": (-0.66, 0.66),
    "surface_z_m": (-0.011, 0.011),
    "stiffness_n_m": (0, 20_000),
    "stiffness_ln_sd": (0, 10),
    "damping_n_s_m": (0, 100),
    "slope_x": (-1, 1),
    "slope_y": (-1, 1),
    "k_tap": (0, 20_000),
    "b_tap_per_s": (0, 1000),
    "k_stroke_v": (0, 50_000),
    "k_stroke_f": (0, 5000),
    "groove_rad_s": (0, 1100),
    "b_groove_per_s": (0, 1000),
    "conductivity_w_mk": (0, 500),
    "density_kg_m3": (0, 25_000),
    "specific_heat_j_kgk": (0, 10_000),
    "effusivity_ln_sd": (0, 10),
    "object_c": (-50, 150),
    "object_c_sd": (0, 100),
    "probability": (0, 1),
    "thermal_status": (0, len(ThermalStatus) - 1),
}
"""Columns of the touch block in order, each with the range that decoding enforces.

The surface is a plane through the height surface_z_m where the remote hand is over (x_m, y_m); slope_x and slope_y are
its dz/dx and dz/dy, 0 where not known. stiffness_ln_sd is the standard deviation of the logarithm of the stiffness,
STIFFNESS_KNOWN_LN_SD or more where it is not yet known; damping_n_s_m is the object's at the present force.
effusivity_ln_sd is the standard deviation of the logarithm of the effusivity that the three thermal constants make.
k_tap and k_stroke_v in (rad/s)/(m/s), k_stroke_f in (rad/s)/N (Kron & Schmidt 2003, Eq. 1-2); a conductivity of 0 W/mK
says that the object's thermal constants are not known.
"""
TOUCH_FIELDS = tuple(TOUCH_RANGES)
TOUCH_COLUMN = {name: column for column, name in enumerate(TOUCH_FIELDS)}
TOUCH_BLOCK = FingerBlock(TOUCH_RANGES, codes=("mode", "contact", "thermal_status"))
TOUCH_LOW, TOUCH_HIGH = TOUCH_BLOCK.low, TOUCH_BLOCK.high


class Event(NamedTuple):
    """One happening at a finger; `ident` is unique in the session, so each is played once.

    `value`: approach speed in m/s of a tap, amplitude in rad/s of a groove, probability of a material. `time_ns` is of
    the remote site's clock; `hand_ns` of the operator's: the source time of the motion packet that the finger was
    following then, 0 where it followed none.
    """

    ident: int
    kind: EventKind
    finger: int
    time_ns: int
    hand_ns: int
    value: float
    name: str = ""


class Motion(NamedTuple):
    """Where the operator's fingertips are, m; `floats` are the bytes of a `MOTION_BLOCK`."""

    session: int
    sequence: int
    time_ns: int
    state: LinkState
    floats: bytes

    def encode(self) -> bytes:
        """Packet bytes; raises BadPacket on a value out of range."""
        floats = MOTION_BLOCK.check(self.floats)
        return pack([SCHEMA_VERSION, self.session, self.sequence, self.time_ns, self.state, floats])

    @classmethod
    def decode(cls, packet: bytes) -> "Motion":
        """Check and unpack; raises BadPacket."""
        _, session, sequence, time_ns, state, floats = unpack(packet, 6)
        return cls(session, sequence, time_ns, read_state(state), MOTION_BLOCK.check(floats))

    @property
    def block(self) -> Floats:
        """(5, 3) of `MOTION_FIELDS`, m; read only."""
        return MOTION_BLOCK.array(self.floats)


class Touch(NamedTuple):
    """What the remote fingers touch: bytes of a `TOUCH_BLOCK`, names of the likeliest materials, events.

    `told`, of each finger, is what a person reads of it at a slow pace.
    """

    session: int
    sequence: int
    time_ns: int
    state: LinkState
    floats: bytes
    materials: tuple[str, ...]
    events: tuple[Event, ...]
    told: tuple[Told, ...] = NOTHING_TOLD

    def encode(self) -> bytes:
        """Packet bytes; raises BadPacket on a value out of range."""
        floats = TOUCH_BLOCK.check(self.floats)
        header = (SCHEMA_VERSION, self.session, self.sequence, self.time_ns, self.state)
        return pack([*header, floats, _pack_news(self.materials, self.events), pack_told(self.told)])

    @classmethod
    def decode(cls, packet: bytes) -> "Touch":
        """Check and unpack; raises BadPacket."""
        _, session, sequence, time_ns, state, floats, news, told = unpack(packet, 8)
        if type(news) is not bytes or type(told) is not bytes:
            raise BadPacket("news or told: not bytes")
        checked = TOUCH_BLOCK.check(floats)
        # As `cls(...)` does, without another function that would have to be fetched into the caches.
        told_now = read_told(told)
        return tuple.__new__(cls, (session, sequence, time_ns, read_state(state), checked, *_read_news(news), told_now))

    @property
    def block(self) -> Floats:
        """(5, 25) of `TOUCH_FIELDS`; read only."""
        return TOUCH_BLOCK.array(self.floats)


# Names and events stay the same for many packets: what was packed or read once is remembered. Reading them every time
# would cost as much as all the rest of a packet.
@lru_cache(maxsize=64)
def _pack_news(materials: tuple[str, ...], events: tuple[Event, ...]) -> bytes:
    return pack([materials, events])


@lru_cache(maxsize=64)
def _read_news(news: bytes) -> tuple[tuple[str, ...], tuple[Event, ...]]:
    fields = unpack_list(news)
    if len(fields) != 2:
        raise BadPacket(f"news: {len(fields)} fields, expected 2")
    materials, events = fields
    if type(events) is not list or len(events) > MAX_EVENTS:
        raise BadPacket(f"events: expected a list of at most {MAX_EVENTS}")
    try:
        happened = tuple([_event(*event) for event in events])
    except TypeError:
        raise BadPacket("events: expected lists of 7 plain values") from None
    return read_texts(materials, "materials", N), happened


def _event(
    ident: object, kind: object, finger: object, time_ns: object, hand_ns: object, value: object, name: object
) -> Event:
    if type(value) is not float or not 0.0 <= value <= EVENT_MAX:
        raise BadPacket(f"event: value is not a number in 0..{EVENT_MAX:g}")
    return Event(
        read_integer(ident, "event"),
        read_enum(EventKind, kind),
        read_integer(finger, "event finger", 0, N - 1),
        read_integer(time_ns, "event time"),
        read_integer(hand_ns, "event hand time"),
        value,
        read_text(name, "event name"),
    )
