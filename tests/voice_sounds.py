"""Sounds for tests of the voice."""

import itertools

import numpy as np
from numpy.typing import NDArray

RATE_HZ = 48_000


def loudest_hz(samples: NDArray[np.int16]) -> float:
    """Frequency of the strongest tone, Hz."""
    spectrum = np.abs(np.fft.rfft(samples * np.hanning(len(samples))))
    return float(np.argmax(spectrum) * RATE_HZ / len(samples))


def coded_tone(hz: float, count: int) -> list[bytes]:
    """As many sounds of a tone, coded with Opus."""
    from remote_site.voice.opus_codec import OpusEncoder
    from remote_site.voice.sound_source import tone

    encoder = OpusEncoder()
    return [encoder.encode(samples) for samples in itertools.islice(tone(hz), count)]


def decoded(coded: list[bytes]) -> NDArray[np.int16]:
    """The samples of coded sounds."""
    from remote_site.voice.opus_codec import OpusDecoder

    decoder = OpusDecoder()
    return np.concatenate([decoder.decode(one) for one in coded])
