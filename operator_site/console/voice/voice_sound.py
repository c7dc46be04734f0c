"""Holds one encoded sound, and packs it for the pages and for the recording; reads the sounds of a page."""

import math
import struct
from dataclasses import asdict, dataclass
from typing import Any, Literal, Self

import msgpack

from common.wire.voice_messages import MAX_SOUND

MAGIC, VERSION = 0x7EA9, 1
HEADER = struct.Struct("<HBxIddf")
"""Header of a message to a page: magic, version, sequence, begin and sending (s), uncertainty (s)."""
PAGE_HEADER = struct.Struct("<HBxId")
"""Header of a message of a page: magic, version, sequence, begin (s of the page's clock)."""
Direction = Literal["from_remote", "to_remote"]


@dataclass(frozen=True, slots=True)
class VoiceSound:
    """One sound of either side.

    Attributes:
        direction: whether the remote site or a page said it.
        sequence: number of the sound of its sender.
        captured_s: when it begins, s of this side's clock.
        uncertainty_s: bound of the error of `captured_s` from the comparison of the clocks, s.
        content: one frame of the codec.
    """

    direction: Direction
    sequence: int
    captured_s: float
    uncertainty_s: float
    content: bytes

    def encode(self, sent_s: float) -> bytes:
        """Return the message for a page: a header of 28 bytes, little-endian, with `sent_s`, the console's time, s."""
        sequence = self.sequence & 0xFFFFFFFF
        return HEADER.pack(MAGIC, VERSION, sequence, self.captured_s, sent_s, self.uncertainty_s) + self.content

    def record(self) -> dict[str, Any]:
        """Return the record for `console/voice`."""
        return asdict(self)

    @classmethod
    def of_record(cls, payload: bytes) -> Self:
        """Return the sound of a record.

        Raises:
            ValueError: the record is damaged.
        """
        try:
            found = cls(**msgpack.unpackb(payload))
            found.encode(0.0)
            if found.direction not in ("from_remote", "to_remote"):
                raise ValueError(f"direction {found.direction!r}")
        except Exception as error:  # the library's exceptions have no common base
            raise ValueError(f"console/voice: {error}") from None
        return found


def clock_message(sent_s: float) -> bytes:
    """Return a message without a sound, which the page answers with its clock; `sent_s` is the console's clock, s."""
    return HEADER.pack(MAGIC, VERSION, 0, 0.0, sent_s, 0.0)


def read_page_sound(message: bytes) -> VoiceSound:
    """Return the sound of a page's message; it begins at a time of the page's clock, of unknown uncertainty, NaN.

    Raises:
        ValueError: it is no such message, its sound is empty or too large, or its time is not finite.
    """
    if not PAGE_HEADER.size < len(message) <= PAGE_HEADER.size + MAX_SOUND:
        raise ValueError(f"a sound of {len(message)} bytes")
    magic, version, sequence, captured_s = PAGE_HEADER.unpack_from(message)
    if (magic, version) != (MAGIC, VERSION) or not abs(captured_s) < 1e9:
        raise ValueError("not a sound of version 1")
    return VoiceSound("to_remote", sequence, captured_s, math.nan, message[PAGE_HEADER.size :])
