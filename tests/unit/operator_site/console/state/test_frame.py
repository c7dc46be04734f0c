"""The picture's bytes hold all of its contents where typed arrays can view them."""

from dataclasses import replace

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from common.wire.packets import LinkState
from operator_site.console.state.fingers_now import FIELDS
from operator_site.console.state.frame import Flags, Frame, Kind, Priority
from operator_site.console.state.signals import BINS, SIGNALS
from tests.unit.operator_site.console.page_messages import read_frame

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
NONE = (False,) * 5
PLAIN = Frame(
    7,
    12.5,
    Flags(LinkState.DISCONNECTED, Priority.NONE, False, False, NONE, NONE, NONE),
    np.zeros((5, len(FIELDS)), np.float32),
    np.empty((0, 5 * len(SIGNALS), 2), np.float32),
    0,
    Kind.PICTURE,
)


@given(pictures)
def test_a_picture_comes_back(picture: Frame) -> None:
    packed = picture.encode()
    read = read_frame(packed)
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


def test_blocks_stand_where_typed_arrays_can_view_them() -> None:
    bins = np.full((2, 25, 2), 7.0, np.float32)
    packed = replace(PLAIN, fingers=np.full((5, len(FIELDS)), 3.0, np.float32), bins=bins).encode()
    assert len(packed) == 32 + 240 + 2 * 200
    assert packed[:4] == bytes([0xA7, 0x7E, 1, 1])
    assert np.frombuffer(packed, "<f4", 60, 32).tolist() == [3.0] * 60
    assert np.frombuffer(packed, "<f4", 100, 272).tolist() == [7.0] * 100
    assert len(replace(PLAIN, bins=np.zeros((BINS, 25, 2), np.float32)).encode()) == 272 + 60_000
