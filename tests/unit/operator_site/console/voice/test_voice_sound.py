"""Sounds for pages and recordings: what is packed is read, and nothing else is."""

import struct

import msgpack
import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.wire.voice_messages import MAX_SOUND
from operator_site.console.voice.voice_sound import (
    HEADER,
    MAGIC,
    PAGE_HEADER,
    VERSION,
    VoiceSound,
    clock_message,
    read_page_sound,
)

seconds = st.floats(-1e9, 1e9, allow_nan=False, exclude_min=True, exclude_max=True)
contents = st.binary(min_size=1, max_size=MAX_SOUND)


@given(st.sampled_from(["from_remote", "to_remote"]), st.integers(0, 2**62), seconds, contents)
def test_a_record_comes_back(direction: str, sequence: int, captured_s: float, content: bytes) -> None:
    sound = VoiceSound(direction, sequence, captured_s, 0.001, content)  # type: ignore[arg-type]
    assert VoiceSound.of_record(msgpack.packb(sound.record())) == sound


@pytest.mark.parametrize(
    "changed", [{"direction": "up"}, {"sequence": "1"}, {"captured_s": None}, {"content": 7}, {"more": 1}]
)
def test_a_damaged_record_is_refused(changed: dict[str, object]) -> None:
    sound = VoiceSound("to_remote", 1, 2.0, 0.001, b"opus")
    with pytest.raises(ValueError, match="console/voice"):
        VoiceSound.of_record(msgpack.packb(sound.record() | changed))
    with pytest.raises(ValueError, match="console/voice"):
        VoiceSound.of_record(b"\xc1")


def test_a_message_for_a_page_has_a_header_of_28_bytes() -> None:
    packed = VoiceSound("from_remote", 2**32 + 5, 12.5, 0.25, b"opus").encode(13.0)
    assert HEADER.size == 28
    assert struct.unpack("<HBBIddf4s", packed) == (MAGIC, VERSION, 0, 5, 12.5, 13.0, 0.25, b"opus")
    assert len(clock_message(3.0)) == HEADER.size


@given(st.integers(0, 2**32 - 1), seconds, contents)
def test_a_pages_sound_is_read(sequence: int, captured_s: float, content: bytes) -> None:
    packed = PAGE_HEADER.pack(MAGIC, VERSION, sequence, captured_s) + content
    sound = read_page_sound(packed)
    assert (sound.sequence, sound.captured_s, sound.content) == (sequence, captured_s, content)


@pytest.mark.parametrize(
    "packed",
    [
        b"",
        b"binary",
        PAGE_HEADER.pack(MAGIC, VERSION, 1, 1.0),
        PAGE_HEADER.pack(MAGIC, VERSION, 1, 1.0) + bytes(MAX_SOUND + 1),
        PAGE_HEADER.pack(MAGIC, VERSION + 1, 1, 1.0) + b"opus",
        PAGE_HEADER.pack(MAGIC - 1, VERSION, 1, 1.0) + b"opus",
        PAGE_HEADER.pack(MAGIC, VERSION, 1, float("nan")) + b"opus",
        PAGE_HEADER.pack(MAGIC, VERSION, 1, float("inf")) + b"opus",
        PAGE_HEADER.pack(MAGIC, VERSION, 1, -1e300) + b"opus",
    ],
)
def test_another_message_is_refused(packed: bytes) -> None:
    with pytest.raises(ValueError, match=r"sound"):
        read_page_sound(packed)
