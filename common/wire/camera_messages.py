"""Packets of the `camera` stream: a reader asks, and the camera's process answers with pictures.

A picture is two parts of one message: a `PictureHeader`, and the picture's bytes as the codec made them. Both sides
stamp times of their own clock, so that a reader knows the age of each picture (`common.link.clock_offset`).
"""

from enum import IntEnum
from typing import Annotated

from msgspec import Meta

from common.wire.packets import BadPacket, Integer, Packet

CODEC = "vp8"
"""Codec of the pictures, as browsers name it (RFC 6386)."""
MAX_PICTURE = 1 << 19
"""Largest picture, bytes."""
ASK_S = 0.1
"""Longest time between two packets of a reader, s."""

_Microseconds = Annotated[int, Meta(ge=0, le=600_000_000)]
_Pixels = Annotated[int, Meta(ge=16, le=4096)]


class CameraState(IntEnum):
    """What the camera's process does."""

    SHOWING = 0
    GIVES_WAY = 1
    NO_CAMERA = 2


class CameraAsk(Packet, frozen=True):
    """What a reader has received, and how old its data are; `time_ns` is the reader's clock.

    Attributes:
        sequence: sequence of the newest picture received; 0 before the first.
        touch_age_us: largest age of touch since the previous packet, us; 0 where it is not known.
        picture_age_us: age of the newest picture when it was received, us; 0 where it is not known.
        wants_key: whether the reader needs a picture that can be decoded by itself.
    """

    touch_age_us: _Microseconds
    picture_age_us: _Microseconds
    wants_key: bool


class PictureHeader(Packet, frozen=True):
    """Header of a picture, or of a message without one; `time_ns` is when the picture was captured.

    Attributes:
        sequence: number of the picture, from 1; a message without a picture repeats the number of the newest one.
        sent_ns: when it was sent, ns of the camera's clock.
        asked_ns: `time_ns` of the reader's newest packet; 0 before the first.
        heard_ns: when that packet was read, ns of the camera's clock.
        state: what the camera's process does.
        rung: step of the ladder of bit rates; 0 is the best picture.
        is_key: whether the picture can be decoded by itself.
        width, height: size of the picture, pixels.
    """

    sent_ns: Integer
    asked_ns: Integer
    heard_ns: Integer
    state: CameraState
    rung: Annotated[int, Meta(ge=0, le=15)]
    is_key: bool
    width: _Pixels
    height: _Pixels


def read_picture(parts: list[bytes]) -> tuple[PictureHeader, bytes]:
    """Return header and picture of a message; the picture is empty where the message has none.

    Raises:
        BadPacket: the message does not have two parts, its picture is too large, or its header violates the schema.
    """
    if len(parts) != 2:
        raise BadPacket(f"camera: {len(parts)} parts instead of 2")
    if len(parts[1]) > MAX_PICTURE:
        raise BadPacket(f"camera: a picture of {len(parts[1])} bytes is larger than {MAX_PICTURE}")
    return PictureHeader.decode(parts[0]), parts[1]
