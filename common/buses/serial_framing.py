"""Serial frames: COBS between zero bytes, with message id, sequence number and CRC-16.

    frame = COBS(id u8, sequence u8, payload, crc u16 little endian), 0x00

A frame contains no zero byte, so a reader resynchronises at the next zero after any damage. The CRC is
CRC-16/CCITT-FALSE over id, sequence and payload.
"""

import binascii
from dataclasses import dataclass, field
from types import FunctionType
from typing import NamedTuple

try:  # compiled, where there is a wheel for the machine; both give the same bytes
    from corncobs import DecodeError, decode, encode
except ImportError:
    from cobs.cobs import DecodeError, decode, encode

COMPILED = not isinstance(encode, FunctionType)
"""Whether COBS is compiled here; a pure Python form is slower."""
MAX_FRAME = 250
"""Maximum size of a frame before COBS, bytes: one COBS block. It also bounds the buffer on a line without zeros."""
_CRC_INIT = 0xFFFF


class Frame(NamedTuple):
    """One checked frame."""

    message_id: int
    sequence: int
    payload: bytes


def encode_frame(message_id: int, sequence: int, payload: bytes = b"") -> bytes:
    """Wrap one message for the line.

    Raises:
        ValueError: the id or the sequence number is not a byte, or the payload is too long.
    """
    if len(payload) + 4 > MAX_FRAME:
        raise ValueError(f"payload of {len(payload)} bytes is longer than {MAX_FRAME - 4}")
    body = bytes((message_id, sequence)) + payload
    crc = binascii.crc_hqx(body, _CRC_INIT)
    return bytes(encode(body + crc.to_bytes(2, "little"))) + b"\0"


@dataclass(slots=True)
class FrameReader:
    """Turns chunks of bytes into frames; counts damaged and lost frames."""

    damaged: int = 0
    """Number of byte sequences between two zeros that were no valid frame."""
    lost: int = 0
    """Number of frames that were sent, by the sequence numbers, and not read."""
    _pending: bytes = b""
    _sequence: int | None = field(default=None)

    def feed(self, chunk: bytes) -> list[Frame]:
        """Take a chunk of any length; return the frames that it completes."""
        *pieces, self._pending = (self._pending + chunk).split(b"\0")
        if len(self._pending) > 2 * MAX_FRAME:
            self._pending = self._pending[-MAX_FRAME:]
            self.damaged += 1
        frames = []
        for piece in pieces:
            if not piece:
                continue
            body = _checked(piece)
            if not body:
                self.damaged += 1
                continue
            sequence = body[1]
            if self._sequence is not None:
                self.lost += (sequence - self._sequence - 1) & 0xFF
            self._sequence = sequence
            frames.append(Frame(body[0], sequence, body[2:]))
        return frames


def _checked(piece: bytes) -> bytes:
    """Return id, sequence and payload from the bytes between two zeros; empty where they are no frame."""
    try:
        body = bytes(decode(piece))
    except DecodeError:
        return b""
    if not 4 <= len(body) <= MAX_FRAME:
        return b""
    checked = body[:-2]
    return checked if binascii.crc_hqx(checked, _CRC_INIT) == body[-1] << 8 | body[-2] else b""
