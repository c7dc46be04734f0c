"""Encodes pictures as VP8 (RFC 6386) with libvpx, for live use: no picture waits for a later one."""

from fractions import Fraction
from typing import NamedTuple

import av
from av.video.frame import PictureType

KEY_S = 5.0
"""Longest time between two key pictures, s: a recording can be entered at each of them."""


class Encoded(NamedTuple):
    """An encoded picture, and whether it can be decoded by itself."""

    data: bytes
    is_key: bool


class VideoEncoder:
    """Encoder of one size, rate and bit rate; the first picture is a key picture."""

    def __init__(self, width: int, height: int, rate_hz: float, bit_s: int) -> None:
        """Open the codec for pictures of an even size, pixels, at a rate, Hz, and a bit rate, bit/s."""
        self.width, self.height = width, height
        self._codec = av.CodecContext.create("libvpx", "w")
        self._codec.width, self._codec.height = width, height
        self._codec.pix_fmt = "yuv420p"
        self._codec.time_base = Fraction(1, 1000)
        self._codec.framerate = Fraction(rate_hz).limit_denominator(100)
        self._codec.bit_rate = bit_s
        self._codec.thread_count = 1
        self._codec.options = {
            "deadline": "realtime",
            "cpu-used": "8",
            "lag-in-frames": "0",
            "auto-alt-ref": "0",
            "error-resilient": "1",
            "g": str(max(1, round(KEY_S * rate_hz))),
            "minrate": str(bit_s),
            "maxrate": str(bit_s),
            "bufsize": str(bit_s // 2),
        }

    def encode(self, frame: av.VideoFrame, time_ns: int, key: bool) -> Encoded | None:
        """Encode a picture of any size and format; None where the codec leaves it out to keep its bit rate.

        Its time, ns, is later than that of the picture before; `key` asks for a key picture.
        """
        own = frame.reformat(self.width, self.height, "yuv420p")
        own.pts, own.time_base = time_ns // 1_000_000, Fraction(1, 1000)
        own.pict_type = PictureType.I if key else PictureType.NONE
        packets = self._codec.encode(own)
        if not packets:
            return None
        return Encoded(b"".join(bytes(packet) for packet in packets), any(packet.is_keyframe for packet in packets))
