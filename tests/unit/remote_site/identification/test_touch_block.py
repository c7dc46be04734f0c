"""The touch block of a packet: all values are within their ranges."""

import math

import numpy as np
import pytest

from common.fingers import FINGERS
from common.wire.messages import NO_TOUCH, TOUCH_BLOCK, TOUCH_COLUMN, TOUCH_HIGH, TOUCH_LOW, TouchRow
from common.wire.packets import BadPacket, Floats
from remote_site.identification.perception import touch_block

PRESSED = NO_TOUCH._replace(contact=1.0, contact_force_n=1.2, surface_z_m=-0.001, stiffness_n_m=900.0, object_c=-3.0)


def packed(row: TouchRow) -> bytes:
    """The block of a second finger."""
    return touch_block([NO_TOUCH, row, *[NO_TOUCH] * (len(FINGERS) - 2)])


def block(row: TouchRow) -> Floats:
    """The second finger's line."""
    return TOUCH_BLOCK.array(TOUCH_BLOCK.check(packed(row)))[1]


def test_each_value_stands_in_its_column() -> None:
    np.testing.assert_array_equal(block(PRESSED), np.array(PRESSED, dtype=np.float32))


@pytest.mark.parametrize("far", [1e9, 1e300, math.inf])
def test_a_value_beyond_its_range_saturates_and_the_others_stay(far: float) -> None:
    usual = block(PRESSED)
    with np.errstate(over="ignore"):
        high = block(PRESSED._replace(stiffness_n_m=far))
        low = block(PRESSED._replace(surface_z_m=-far))
    for row, name, limit in ((high, "stiffness_n_m", TOUCH_HIGH), (low, "surface_z_m", TOUCH_LOW)):
        column = TOUCH_COLUMN[name]
        assert row[column] == limit[column]
        np.testing.assert_array_equal(np.delete(row, column), np.delete(usual, column))


def test_nan_and_infinity_are_not_sent() -> None:
    with pytest.raises(BadPacket):
        TOUCH_BLOCK.check(packed(PRESSED._replace(surface_z_m=math.nan)))
