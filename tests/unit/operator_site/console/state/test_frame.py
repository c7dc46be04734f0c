"""The picture's bytes: they come back as they were, and nothing else is taken for one."""

import contextlib
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from common.wire.packets import LinkState
from operator_site.console.state.fingers_now import FIELDS
from operator_site.console.state.frame import BadFrame, Flags, Frame, Kind, Priority
from operator_site.console.state.signals import BINS, SIGNALS

fives = st.tuples(*[st.booleans()] * 5)
flags = st.builds(
    Flags, st.sampled_from(LinkState), st.sampled_from(Priority), st.booleans(), st.booleans(), fives, fives, fives
)
floats = st.floats(width=32)
pictures = st.builds(
    Frame,
    sequence=st.integers(0, 2**32 - 1),
    time_s=st.floats(-1e9, 1e9),
    flags=flags,
    fingers=arrays(np.float32, (5, len(FIELDS)), elements=floats),
    bins=st.integers(0, 3).flatmap(lambda n: arrays(np.float32, (n, 5 * len(SIGNALS), 2), elements=floats)),
    session=st.integers(0, 2**32 - 1),
    kind=st.sampled_from((Kind.PICTURE, Kind.WHOLE)),
)
PLAIN = Frame(7, 12.5, Flags(), np.zeros((5, len(FIELDS)), np.float32))


@given(pictures)
def test_a_picture_comes_back(picture: Frame) -> None:
    packed = picture.encode()
    read = Frame.decode(packed)
    assert read.encode() == packed
    assert (read.sequence, read.time_s, read.flags, read.session, read.kind) == (
        picture.sequence,
        picture.time_s,
        picture.flags,
        picture.session,
        picture.kind,
    )
    assert np.array_equal(read.fingers, picture.fingers, equal_nan=True)
    assert np.array_equal(read.bins, picture.bins, equal_nan=True)


@given(pictures, st.data())
def test_a_damaged_picture_is_refused_or_is_another_picture(picture: Frame, data: st.DataObject) -> None:
    packed = bytearray(picture.encode())
    for _ in range(data.draw(st.integers(1, 4))):
        at = data.draw(st.integers(0, len(packed) - 1))
        if data.draw(st.booleans()):
            packed[at] = data.draw(st.integers(0, 255))
        else:
            del packed[max(1, at) :]
    with contextlib.suppress(BadFrame):
        Frame.decode(bytes(packed))


@given(st.binary(max_size=600))
def test_any_bytes_raise_only_bad_picture(packed: bytes) -> None:
    with contextlib.suppress(BadFrame):
        Frame.decode(packed)


def changed(at: int, value: bytes) -> bytes:
    packed = PLAIN.encode()
    return packed[:at] + value + packed[at + len(value) :]


@pytest.mark.parametrize(
    "packed",
    [
        b"",
        PLAIN.encode()[:-4],
        PLAIN.encode() + bytes(4),
        changed(0, b"\0"),
        changed(2, b"\2"),
        changed(3, b"\2"),
        changed(3, b"\4"),
        changed(12, b"\7"),
        changed(13, b"\x20"),
        changed(16, np.array([np.nan]).tobytes()),
        changed(24, np.array([0.0], np.float32).tobytes()),
        changed(28, b"\1\0"),
        changed(30, b"\4"),
        changed(31, b"\6"),
    ],
)
def test_what_is_no_picture_is_refused(packed: bytes) -> None:
    with pytest.raises(BadFrame):
        Frame.decode(packed)


def test_blocks_stand_where_typed_arrays_can_view_them() -> None:
    bins = np.full((2, 25, 2), 7.0, np.float32)
    packed = replace(PLAIN, fingers=np.full((5, len(FIELDS)), 3.0, np.float32), bins=bins).encode()
    assert len(packed) == 32 + 240 + 2 * 200
    assert packed[:4] == bytes([0xA7, 0x7E, 1, 1])
    assert np.frombuffer(packed, "<f4", 60, 32).tolist() == [3.0] * 60
    assert np.frombuffer(packed, "<f4", 100, 272).tolist() == [7.0] * 100
    assert len(replace(PLAIN, bins=np.zeros((BINS, 25, 2), np.float32)).encode()) == 272 + 60_000
