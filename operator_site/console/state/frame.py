"""Encodes the picture that the page draws thirty times a second; its typed arrays view the bytes without copying."""

import struct
from dataclasses import dataclass, field
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from common.fingers import FINGERS
from common.wire.packets import LinkState
from operator_site.console.state.fingers_now import FIELDS
from operator_site.console.state.signals import BINS, SIGNALS, SPAN_S

MAGIC, VERSION = 0x7EA7, 1
HEADER = struct.Struct("<HBBIIIdfHBB")
_SIGNALS = len(FINGERS) * len(SIGNALS)
_ROWS = len(FINGERS) * len(FIELDS)
_FLOAT32 = np.dtype("<f4")
_RECORDING, _PLAYBACK = 1 << 5, 1 << 6
_CONTACT, _LIMITED, _IN_USE = 8, 16, 24
"""First bit of each group of five flags, one flag a finger."""


class BadFrame(ValueError):
    """The bytes are no picture of this version."""


class Kind(IntEnum):
    """Kind of a binary message to the page."""

    PICTURE = 1
    TILE = 2
    WHOLE = 3
    """A picture with all kept bins: the first one, and the first after a jump."""


class Priority(IntEnum):
    """Priority of an alarm."""

    NONE = 0
    LOW = 1
    MEDIUM = 2
    HIGH = 3


@dataclass(frozen=True, slots=True)
class Flags:
    """Flags of a picture in single bits; groups have one bit for each of the five fingers."""

    state: LinkState = LinkState.DISCONNECTED
    priority: Priority = Priority.NONE
    recording: bool = False
    playback: bool = False
    contact: tuple[bool, ...] = (False,) * len(FINGERS)
    limited: tuple[bool, ...] = (False,) * len(FINGERS)
    in_use: tuple[bool, ...] = (False,) * len(FINGERS)

    def bits(self) -> int:
        """Return the flags as one integer."""
        found = int(self.state) | int(self.priority) << 3 | _RECORDING * self.recording | _PLAYBACK * self.playback
        for first, group in ((_CONTACT, self.contact), (_LIMITED, self.limited), (_IN_USE, self.in_use)):
            for finger, flag in enumerate(group):
                found |= flag << (first + finger)
        return found

    @classmethod
    def of(cls, bits: int) -> "Flags":
        """Read the flags from one integer; raise BadFrame if it has an unknown bit or state."""

        def five(first: int) -> tuple[bool, ...]:
            return tuple(bool(bits >> (first + finger) & 1) for finger in range(len(FINGERS)))

        state = bits & 7
        if state not in LinkState._value2member_map_:
            raise BadFrame(f"unknown state {state}")
        flags = cls(
            LinkState(state),
            Priority(bits >> 3 & 3),
            bool(bits & _RECORDING),
            bool(bits & _PLAYBACK),
            five(_CONTACT),
            five(_LIMITED),
            five(_IN_USE),
        )
        if flags.bits() != bits:
            raise BadFrame(f"flags {bits:#x} have unknown bits")
        return flags


@dataclass(frozen=True, slots=True)
class Frame:
    """Contents of a picture.

    Attributes:
        sequence: number of the picture, rising.
        time_s: end of the newest bin, s of the operator site's monotonic clock.
        flags: flags of the session and of the fingers.
        fingers: FIELDS of each finger, (5, 12); NaN if unknown.
        bins: (n, 25, 2) smallest and largest value, oldest bin first; n is 0..300.
        session: number of the session, its lower 32 bits.
        kind: PICTURE or WHOLE.
    """

    sequence: int
    time_s: float
    flags: Flags
    fingers: NDArray[np.float32]
    bins: NDArray[np.float32] = field(default_factory=lambda: np.empty((0, _SIGNALS, 2), dtype=np.float32))
    session: int = 0
    kind: Kind = Kind.PICTURE

    def encode(self) -> bytes:
        """Return the bytes, little-endian, with all blocks at multiples of 4."""
        header = HEADER.pack(
            MAGIC,
            VERSION,
            self.kind,
            self.session & 0xFFFFFFFF,
            self.sequence & 0xFFFFFFFF,
            self.flags.bits(),
            self.time_s,
            SPAN_S,
            len(self.bins),
            len(FINGERS),
            len(SIGNALS),
        )
        return header + self.fingers.astype(_FLOAT32).tobytes() + self.bins.astype(_FLOAT32).tobytes()

    @classmethod
    def decode(cls, packed: bytes) -> "Frame":
        """Check and read the bytes; raise BadFrame if they are invalid."""
        if len(packed) < HEADER.size:
            raise BadFrame(f"{len(packed)} bytes, shorter than a header")
        magic, version, kind, session, sequence, bits, time_s, span_s, count, fingers, signals = HEADER.unpack_from(
            packed
        )
        if magic != MAGIC or version != VERSION or kind not in (Kind.PICTURE, Kind.WHOLE):
            raise BadFrame(f"magic {magic:#x}, version {version}, kind {kind}: no picture of this version")
        if (fingers, signals) != (len(FINGERS), len(SIGNALS)) or not 0.0 < span_s < 1.0 or not np.isfinite(time_s):
            raise BadFrame("invalid number of fingers or signals, span or time")
        if count > BINS or len(packed) != HEADER.size + 4 * (_ROWS + count * 2 * _SIGNALS):
            raise BadFrame(f"{len(packed)} bytes with {count} bins")
        floats = np.frombuffer(packed, dtype=_FLOAT32, offset=HEADER.size)
        return cls(
            sequence,
            time_s,
            Flags.of(bits),
            floats[:_ROWS].reshape(len(FINGERS), len(FIELDS)),
            floats[_ROWS:].reshape(count, _SIGNALS, 2),
            session,
            Kind(kind),
        )
