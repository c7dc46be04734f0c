"""Rendering input goes into a recording and comes back without a bit changed."""

import msgpack
import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.wire.packets import N
from operator_site.recorded_rows import RenderingInput
from tests.unit.common.any_fault import faults

ANY = st.floats()
FIVE = st.tuples(*[ANY] * N)


INPUTS = st.builds(
    RenderingInput,
    time_s=st.floats(allow_nan=False, allow_infinity=False),
    session=st.integers(0, 2**63 - 1),
    fault_cleared=st.booleans(),
    engaged=st.booleans(),
    gap_ns=st.none() | st.integers(0, 2**62),
    touch=st.none() | st.integers(0, 2**62),
    x_m=ANY,
    y_m=ANY,
    z_m=FIVE,
    pose_s=ANY,
    heights_s=ANY,
    plate_c=FIVE,
    plate_age_s=FIVE,
    device_faults=st.lists(faults, max_size=3).map(tuple),
)


@pytest.mark.long
@given(INPUTS)
def test_packed_input_is_unpacked_to_the_last_bit(put_in: RenderingInput) -> None:
    packed = put_in.pack()
    again = RenderingInput.unpack(packed)
    assert again.pack() == packed  # NaN equals nothing, its bytes do
    assert repr(again) == repr(put_in)


@pytest.mark.parametrize("packed", [msgpack.packb(3), msgpack.packb([1.0] * 13), msgpack.packb({}), b""])
def test_input_of_another_form_is_refused(packed: bytes) -> None:
    with pytest.raises(ValueError, match=r"rendering input|incomplete"):
        RenderingInput.unpack(packed)
