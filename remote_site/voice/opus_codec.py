"""Encodes and decodes sounds with Opus (RFC 6716) by libopus: one channel, 48 kHz, frames of 20 ms."""

import itertools
from fractions import Fraction

import av
import numpy as np
from av.error import FFmpegError
from numpy.typing import NDArray

from common.wire.voice_messages import BIT_S, FRAME_S, RATE_HZ, SAMPLES

Samples = NDArray[np.int16]
"""Samples of one sound, (960,)."""
FORMAT, LAYOUT = "s16", "mono"
"""Form of samples, as the library names it."""


class OpusEncoder:
    """Encoder of one talker, with a constant bit rate."""

    def __init__(self) -> None:
        self._codec = av.AudioCodecContext.create("libopus", "w")
        self._codec.sample_rate, self._codec.format, self._codec.layout = RATE_HZ, FORMAT, LAYOUT
        self._codec.bit_rate = BIT_S
        self._codec.options = {"frame_duration": f"{1e3 * FRAME_S:g}", "vbr": "off", "application": "voip"}
        self._count = itertools.count()

    def encode(self, samples: Samples) -> bytes:
        """Return one frame of the codec."""
        return b"".join(bytes(packet) for packet in self._codec.encode(frame_of(samples, next(self._count))))


class OpusDecoder:
    """Decoder of one talker."""

    def __init__(self) -> None:
        self._codec = av.AudioCodecContext.create("libopus", "r")
        self._codec.sample_rate, self._codec.format, self._codec.layout = RATE_HZ, FORMAT, LAYOUT

    def decode(self, content: bytes) -> Samples:
        """Return the samples of a frame; raises ValueError where it is no frame of 20 ms."""
        try:
            blocks = [frame.to_ndarray().reshape(-1) for frame in self._codec.decode(av.Packet(content))]
        except FFmpegError as error:
            raise ValueError(f"no sound: {error}") from None
        samples: Samples = np.concatenate([np.empty(0, np.int16), *blocks])
        if len(samples) != SAMPLES:
            raise ValueError(f"a sound of {len(samples)} samples instead of {SAMPLES}")
        return samples


def frame_of(samples: Samples, number: int) -> av.AudioFrame:
    """Return the samples of the sound with a number as a frame of the library."""
    frame = av.AudioFrame.from_ndarray(samples[None], format=FORMAT, layout=LAYOUT)
    frame.sample_rate, frame.time_base = RATE_HZ, Fraction(1, RATE_HZ)
    frame.pts = number * SAMPLES
    return frame
