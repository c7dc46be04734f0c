"""A VP8 stream of two seconds for tests, in `tests/vp8_stream.ivf`, made by `python -m tests.vp8_stream` with PyAV.

It shows a bright square that moves over a dark ground: 160 x 96 pixels, 15 pictures a second, a key picture a second.
"""

import struct
from pathlib import Path
from typing import NamedTuple

import numpy as np

IVF = Path(__file__).with_suffix(".ivf")
WIDTH, HEIGHT, HZ, SECONDS = 160, 96, 15, 2
_HEAD, _PICTURE = struct.Struct("<4sHH4sHHIIII"), struct.Struct("<IQ")


class Coded(NamedTuple):
    """One picture of the stream."""

    is_key: bool
    content: bytes


def pictures() -> list[Coded]:
    """The pictures of the stream, in order."""
    data, found = IVF.read_bytes(), []
    at = _HEAD.size
    while at < len(data):
        size, _ = _PICTURE.unpack_from(data, at)
        content = data[at + _PICTURE.size : at + _PICTURE.size + size]
        found.append(Coded(not content[0] & 1, content))  # RFC 6386, section 9.1
        at += _PICTURE.size + size
    return found


def main() -> None:
    """Write the stream."""
    import av

    with av.open(str(IVF), "w", format="ivf") as file:
        stream = file.add_stream("libvpx", rate=HZ, options={"deadline": "good", "crf": "40", "lag-in-frames": "0"})
        stream.width, stream.height, stream.pix_fmt, stream.bit_rate = WIDTH, HEIGHT, "yuv420p", 60_000
        stream.gop_size = HZ
        for number in range(HZ * SECONDS):
            image = np.full((HEIGHT, WIDTH, 3), (20, 40, 60), dtype=np.uint8)
            left = 4 * number
            image[32:64, left : left + 32] = (230, 200, 40)
            for packet in stream.encode(av.VideoFrame.from_ndarray(image, format="rgb24")):
                file.mux(packet)
        for packet in stream.encode():
            file.mux(packet)
    print(f"{IVF.stat().st_size} bytes")


if __name__ == "__main__":
    main()
