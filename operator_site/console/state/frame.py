"""Encodes the picture that the page draws thirty times a second; the page reads it without copying."""

import struct
from dataclasses import dataclass
from enum import IntEnum

import numpy as np
from numpy.typing import NDArray

from common.fingers import FINGERS
from common.wire.packets import LinkState
from operator_site.console.state.signals import SIGNALS, SPAN_S

MAGIC, VERSION = 0x7EA7, 1
HEADER = struct.Struct("<HBBIIIdfHBB")
_FLOAT32 = np.dtype("<f4")
RECORDING, PLAYBACK = 1 << 5, 1 << 6
"""Flags of a recorded session and of a shown recording."""
CONTACT, LIMITED, IN_USE = 8, 16, 24
"""First bit of each group of five flags, one flag a finger."""


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

    state: LinkState
    priority: Priority
    recording: bool
    playback: bool
    contact: tuple[bool, ...]
    limited: tuple[bool, ...]
    in_use: tuple[bool, ...]

    def bits(self) -> int:
        """Return the flags as one integer."""
        found = int(self.state) | int(self.priority) << 3 | RECORDING * self.recording | PLAYBACK * self.playback
        for first, group in ((CONTACT, self.contact), (LIMITED, self.limited), (IN_USE, self.in_use)):
            for finger, flag in enumerate(group):
                found |= flag << (first + finger)
        return found


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
    bins: NDArray[np.float32]
    session: int
    kind: Kind

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
