import pickle

import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.buses.serial_messages import (
    MAX_FRAME,
    Frame,
    FrameReader,
    MessageId,
    TextureSamples,
    ThermalReading,
    encode_frame,
)

bytes_8 = st.integers(0, 255)
payloads = st.binary(max_size=MAX_FRAME - 4)
NEXT = encode_frame(0x55, 9, b"next")
NEXT_FRAME = Frame(0x55, 9, b"next")
SERIAL_BLOCKS = (
    "identify",
    "identity",
    "texture_samples",
    "thermal_reading",
    "heater_command",
    "tacttip_command",
    "tacttip_state",
)


@given(bytes_8, bytes_8, payloads)
def test_a_frame_comes_back_and_holds_no_zero_inside(message_id: int, sequence: int, payload: bytes) -> None:
    line = encode_frame(message_id, sequence, payload)
    assert line.index(0) == len(line) - 1
    assert len(line) == len(payload) + 6
    assert FrameReader().feed(line) == [Frame(message_id, sequence, payload)]


@given(st.lists(payloads, min_size=1, max_size=6), st.integers(1, 60))
def test_frames_come_in_any_pieces(contents: list[bytes], piece: int) -> None:
    line = b"".join(encode_frame(1, n, payload) for n, payload in enumerate(contents))
    reader, frames = FrameReader(), []
    for start in range(0, len(line), piece):
        frames += reader.feed(line[start : start + piece])
    assert [frame.payload for frame in frames] == contents
    assert (reader.damaged, reader.lost) == (0, 0)


@pytest.mark.parametrize("name", SERIAL_BLOCKS)
def test_one_damaged_byte_anywhere_never_yields_a_wrong_frame(golden: dict[str, bytes], name: str) -> None:
    line = golden[name]
    (good,) = FrameReader().feed(line)
    for position in range(len(line) - 1):
        for damage in range(1, 256):
            broken = bytearray(line)
            broken[position] ^= damage
            reader = FrameReader()
            frames = reader.feed(bytes(broken) + NEXT)
            assert frames == [NEXT_FRAME], (position, damage)
            assert reader.damaged >= 1
    for damage in range(1, 256):  # the delimiter itself: this frame and the next become one
        reader = FrameReader()
        assert reader.feed(line[:-1] + bytes((damage,)) + NEXT + NEXT) in ([NEXT_FRAME], [good, NEXT_FRAME])
        assert reader.damaged == 1


@given(payloads, st.data())
def test_a_burst_within_the_data_never_yields_a_wrong_frame(payload: bytes, data: st.DataObject) -> None:
    line = bytearray(encode_frame(7, 7, payload))
    position = data.draw(st.integers(1, len(line) - 2))
    # A byte of data that stays data: what COBS makes of it is one wrong byte, which this CRC always sees.
    damage = data.draw(st.integers(1, 255).filter(lambda d: line[position] ^ d))
    code_bytes, at = set(), 0
    while line[at]:
        code_bytes.add(at)
        at += line[at]
    if position in code_bytes:
        return
    line[position] ^= damage
    assert FrameReader().feed(bytes(line) + NEXT) == [NEXT_FRAME]


@given(st.lists(st.binary(max_size=700), max_size=8))
def test_any_bytes_are_survived_and_the_next_good_frame_is_read(chunks: list[bytes]) -> None:
    reader = FrameReader()
    for chunk in chunks:
        reader.feed(chunk)
    assert reader.feed(b"\0" + NEXT)[-1:] == [NEXT_FRAME]


def test_a_babbling_line_fills_no_memory_and_lost_frames_are_counted_across_the_turn_of_the_sequence() -> None:
    reader = FrameReader()
    for _ in range(1000):
        reader.feed(b"\x55" * 4096)
    assert len(pickle.dumps(reader)) < 4 * MAX_FRAME
    assert reader.damaged >= 1000
    reader.feed(b"\0")
    for sequence in (253, 254, 1, 2):
        reader.feed(encode_frame(1, sequence))
    assert reader.lost == 2


@pytest.mark.parametrize(
    ("message_id", "sequence", "payload"), [(256, 0, b""), (-1, 0, b""), (1, 256, b""), (1, 0, bytes(MAX_FRAME - 3))]
)
def test_an_invalid_frame_is_not_encoded(message_id: int, sequence: int, payload: bytes) -> None:
    with pytest.raises(ValueError, match=r"range|longer"):
        encode_frame(message_id, sequence, payload)


def test_reports_of_one_kind_are_decoded_and_bad_ones_are_counted() -> None:
    good, later = (ThermalReading(time_us, 2000, 1500, 0, -250) for time_us in (7, 10_007))
    line = b"".join(
        encode_frame(message_id, sequence, payload)
        for sequence, (message_id, payload) in enumerate(
            [
                (MessageId.THERMAL_READING, good.encode()),
                (MessageId.TEXTURE_SAMPLES, TextureSamples(7, bytes(20)).encode()),
                (MessageId.THERMAL_READING, b"short"),
                (0x7F, b"unknown"),
                (MessageId.THERMAL_READING, later.encode()),
            ]
        )
    )
    reader = FrameReader()
    found = [report for at in range(0, len(line), 5) for report in reader.reports(line[at : at + 5], ThermalReading)]
    assert found == [good, later]
    assert (reader.malformed, reader.damaged, reader.lost) == (1, 0, 0)


def test_a_report_of_the_same_measurement_is_counted_and_skipped() -> None:
    reader, found = FrameReader(), []
    for sequence, time_us in enumerate((0xFFFFFFFF, 0xFFFFFFFF, 0, 0, 0, 10_000, 5)):
        payload = ThermalReading(time_us, 2000, 1500, 0, sequence).encode()
        found += reader.reports(encode_frame(MessageId.THERMAL_READING, sequence, payload), ThermalReading)
    assert [report.heater_permille for report in found] == [0, 2, 5, 6]
    assert (reader.repeated, reader.lost) == (3, 0)


def test_repeated_frames_are_counted_and_are_no_lost_ones() -> None:
    reader = FrameReader()
    first, second = encode_frame(0x40, 255, b"a"), encode_frame(0x40, 0, b"b")
    reader.feed(first + second)
    assert (reader.repeated, reader.lost) == (0, 0)
    reader.feed(second + second)
    assert (reader.repeated, reader.lost) == (2, 0)
