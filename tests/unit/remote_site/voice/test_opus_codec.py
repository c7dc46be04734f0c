"""The codec: a tone comes through, at a constant bit rate, and what is no sound is refused."""

import itertools
from contextlib import suppress

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.wire.voice_messages import BIT_S, FRAME_S, MAX_SOUND, RATE_HZ
from remote_site.voice.opus_codec import OpusDecoder, OpusEncoder
from remote_site.voice.sound_source import LOUDNESS, tone
from tests.voice_sounds import loudest_hz


@pytest.mark.parametrize("hz", [200.0, 440.0, 1000.0, 3000.0])
def test_a_tone_comes_through_at_the_bit_rate(hz: float) -> None:
    encoder, decoder = OpusEncoder(), OpusDecoder()
    coded = [encoder.encode(samples) for samples in itertools.islice(tone(hz), 100)]
    assert {len(one) for one in coded} == {round(BIT_S * FRAME_S / 8)}
    heard = np.concatenate([decoder.decode(one) for one in coded])[RATE_HZ // 2 :]
    assert loudest_hz(heard) == pytest.approx(hz, abs=2.0)
    assert np.sqrt(2.0 * np.mean(np.square(heard / 32767.0))) == pytest.approx(LOUDNESS, rel=0.2)


def test_noise_is_no_larger_than_a_packet_takes() -> None:
    encoder = OpusEncoder()
    noise = np.random.default_rng(1).integers(-32768, 32767, (20, 960)).astype(np.int16)
    assert all(len(encoder.encode(samples)) <= MAX_SOUND for samples in noise)


@given(st.binary(min_size=1, max_size=MAX_SOUND))
def test_any_bytes_are_a_sound_or_refused(content: bytes) -> None:
    decoder = OpusDecoder()
    with suppress(ValueError):
        assert decoder.decode(content).shape == (960,)
    coded = OpusEncoder().encode(next(tone(440.0)))
    assert decoder.decode(coded).shape == (960,)
