"""A picture in the recording and in the message for the page."""

import msgpack
import pytest
from hypothesis import given
from hypothesis import strategies as st

from operator_site.console.camera.camera_picture import HEADER, MAGIC, VERSION, Picture, follows

PICTURES = st.builds(
    Picture,
    st.integers(0, 2**32 - 1),
    st.floats(0.0, 1e9),
    st.floats(0.0, 10.0, width=32),
    st.booleans(),
    st.integers(16, 4096),
    st.integers(16, 4096),
    st.binary(max_size=50),
)


@given(PICTURES)
def test_the_record_gives_the_picture_back(picture: Picture) -> None:
    assert Picture.of_record(msgpack.packb(picture.record())) == picture


@given(PICTURES)
def test_the_message_has_a_header_of_24_bytes(picture: Picture) -> None:
    packed = picture.encode()
    assert HEADER.size == 24
    assert packed[24:] == picture.content
    assert HEADER.unpack(packed[:24]) == (
        MAGIC, VERSION, picture.is_key, picture.sequence, picture.captured_s, picture.uncertainty_s, picture.width,
        picture.height,
    )  # fmt: skip


@given(st.binary(max_size=60))
def test_a_damaged_record_is_an_error_of_value(payload: bytes) -> None:
    with pytest.raises(ValueError, match="console/camera"):
        Picture.of_record(payload)


def test_a_picture_needs_the_one_before_unless_it_is_a_key_picture() -> None:
    key, delta = (Picture(5, 1.0, 0.0, is_key, 160, 96, b"") for is_key in (True, False))
    assert follows(key, None)
    assert not follows(delta, None)
    assert [follows(delta, before) for before in (3, 4, 5)] == [False, True, False]
