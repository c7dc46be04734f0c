"""A block of floats is judged as one whole number: it must come out as it would float by float."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from common.wire.packets import BadPacket, FingerBlock, N

BLOCK = FingerBlock({"from_zero": (0, 10.5), "symmetric": (-0.66, 0.66), "both": (-50, 150), "code": (0, 3)}, ["code"])
COLUMNS = len(BLOCK.names)

edges = [
    float(np.nextafter(np.float32(v), np.float32(way))) for v in (0, 0.66, 10.5, -50, 150, 3) for way in (-999, 999)
]
odd = [0.0, -0.0, np.nan, -np.nan, np.inf, -np.inf, 1e-45, -1e-45, 0.66, -0.66, 10.5, -50.0, 150.0, 1.0, 2.5, 3.0]
floats = st.one_of(st.sampled_from([*odd, *edges]), st.floats(width=32), st.sampled_from([0.0, 1.0, 2.0]))


@given(st.lists(floats, min_size=N * COLUMNS, max_size=N * COLUMNS))
@example([0.0] * (N * COLUMNS))
def test_the_whole_number_agrees_with_each_float(values: list[float]) -> None:
    block = np.array(values, dtype="<f4").reshape(N, COLUMNS)
    codes = block[:, 3]
    good = bool(((block >= BLOCK.low) & (block <= BLOCK.high)).all()) and bool((codes == np.floor(codes)).all())
    try:
        checked = BLOCK.check(block.tobytes())
    except BadPacket:
        assert not good
    else:
        assert good
        assert BLOCK.array(checked).tobytes() == block.tobytes()


@given(st.integers(0, N - 1), st.integers(0, COLUMNS - 1), floats)
def test_one_wrong_float_among_good_ones_is_found(finger: int, column: int, value: float) -> None:
    block = np.ones((N, COLUMNS), dtype="<f4") * np.array([1.0, 0.5, 20.0, 1.0], dtype="<f4")
    block[finger, column] = value
    in_range = BLOCK.low[column] <= block[finger, column] <= BLOCK.high[column]
    if in_range and (column != 3 or float(value).is_integer()):
        assert np.array_equal(BLOCK.array(BLOCK.check(block.tobytes())), block)
    else:
        with pytest.raises(BadPacket):
            BLOCK.check(block.tobytes())
