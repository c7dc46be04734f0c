"""Holds one encoded picture, and packs it for the page and for the recording."""

import struct
from dataclasses import asdict, dataclass
from typing import Any, Self

import msgpack

MAGIC, VERSION = 0x7EA8, 1
HEADER = struct.Struct("<HBBIdfHH")
KEY = 1
"""Flag of a picture that can be decoded by itself."""


@dataclass(frozen=True, slots=True)
class Picture:
    """One picture of the camera.

    Attributes:
        sequence: number of the picture.
        captured_s: when it was captured, s of this side's clock.
        uncertainty_s: bound of the error of `captured_s` from the comparison of the clocks, s.
        is_key: whether it can be decoded by itself.
        width, height: size, pixels.
        content: bytes of the codec.
    """

    sequence: int
    captured_s: float
    uncertainty_s: float
    is_key: bool
    width: int
    height: int
    content: bytes

    def encode(self) -> bytes:
        """Return the message for the page: a header of 24 bytes, little-endian, and the content."""
        header = HEADER.pack(
            MAGIC,
            VERSION,
            KEY * self.is_key,
            self.sequence & 0xFFFFFFFF,
            self.captured_s,
            self.uncertainty_s,
            self.width,
            self.height,
        )
        return header + self.content

    def record(self) -> dict[str, Any]:
        """Return the record for `console/camera`."""
        return asdict(self)

    @classmethod
    def of_record(cls, payload: bytes) -> Self:
        """Return the picture of a record.

        Raises:
            ValueError: the record is damaged.
        """
        try:
            found = cls(**msgpack.unpackb(payload))
            found.encode()
        except Exception as error:  # the library's exceptions have no common base
            raise ValueError(f"console/camera: {error}") from None
        return found


def follows(picture: Picture, sequence: int | None) -> bool:
    """Return whether a picture can be decoded after the one with `sequence`, or after none."""
    return picture.is_key or (sequence is not None and picture.sequence == sequence + 1)
