"""Packets of the voice: what is sent is read, and nothing else is."""

import msgspec
import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.wire.packets import MAX_INTEGER, BadPacket
from common.wire.voice_messages import BIT_S, FRAME_S, MAX_SOUND, RATE_HZ, SAMPLES, VoicePacket, VoiceState

integers = st.integers(0, MAX_INTEGER)
packets = st.builds(
    VoicePacket,
    integers,
    integers,
    integers,
    integers,
    integers,
    integers,
    st.sampled_from(VoiceState),
    st.booleans(),
    st.booleans(),
    st.binary(max_size=MAX_SOUND),
)


@given(packets)
def test_a_packet_survives_the_wire(packet: VoicePacket) -> None:
    assert VoicePacket.decode(packet.encode()) == packet


@given(st.binary(max_size=300))
def test_other_bytes_are_refused(noise: bytes) -> None:
    with pytest.raises(BadPacket):
        VoicePacket.decode(noise)


@given(packets, st.integers(4, 10), st.sampled_from([-1, 1.5, "x", None, bytes(MAX_SOUND + 1), [1]]))
def test_a_wrong_field_is_refused(packet: VoicePacket, field: int, wrong: object) -> None:
    fields = msgspec.msgpack.decode(packet.encode())
    fields[field] = wrong
    with pytest.raises(BadPacket):
        VoicePacket.decode(msgspec.msgpack.encode(fields))


def test_a_sound_of_the_bit_rate_fits_twice() -> None:
    assert pytest.approx(RATE_HZ * FRAME_S) == SAMPLES
    assert pytest.approx(2 * BIT_S * FRAME_S / 8) == MAX_SOUND
