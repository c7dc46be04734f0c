"""The touch block: what is said of each finger, within what a packet may carry."""

import math
from dataclasses import replace

import numpy as np
import pytest

from common.wire.messages import TOUCH_BLOCK, TOUCH_COLUMN, TOUCH_HIGH, TOUCH_LOW, ExplorationMode, ThermalStatus
from common.wire.packets import BadPacket, Floats
from remote_site.identification.finger_touch import FingerTouch
from remote_site.identification.touch_block import touch_block
from remote_site.thermal.thermal_result import ThermalResult

PRESSED = FingerTouch(
    mode=ExplorationMode.QUIESCENT,
    contact=True,
    contact_force_n=1.2,
    surface_z_m=-0.001,
    stiffness_n_m=900.0,
    stiffness_ln_sd=0.03,
    damping_n_s_m=2.5,
    slope_x=0.02,
    slope_y=-0.03,
    k_stroke_v=2000.0,
    k_stroke_f=60.0,
    conductivity_w_mk=0.17,
    density_kg_m3=1400.0,
    specific_heat_j_kgk=900.0,
    thermal=ThermalResult(
        ThermalStatus.IDENTIFIED, probability=1.0, object_c=-3.0, object_c_sd=0.2, effusivity_ln_sd=0.1
    ),
    measuring=True,
    no_differences=0,
    speed_m_s=0.0,
    roughness_v=0.0,
    events=(),
)


def block(touch: FingerTouch) -> Floats:
    """The second finger's line."""
    return TOUCH_BLOCK.array(TOUCH_BLOCK.check(touch_block({1: touch}, 0.1, -0.2)))[1]


def test_each_value_stands_in_its_column() -> None:
    row = block(PRESSED)
    for name in ("mode", "contact", "contact_force_n", "surface_z_m", "stiffness_n_m", "stiffness_ln_sd", "slope_y"):
        assert row[TOUCH_COLUMN[name]] == np.float32(getattr(PRESSED, name)), name
    for name in ("damping_n_s_m", "k_stroke_v", "k_stroke_f", "conductivity_w_mk", "density_kg_m3"):
        assert row[TOUCH_COLUMN[name]] == np.float32(getattr(PRESSED, name)), name
    for name in ("object_c", "object_c_sd", "effusivity_ln_sd", "probability"):
        assert row[TOUCH_COLUMN[name]] == np.float32(getattr(PRESSED.thermal, name)), name
    assert row[TOUCH_COLUMN["thermal_status"]] == ThermalStatus.IDENTIFIED
    assert row[TOUCH_COLUMN["x_m"]] == np.float32(0.1)
    assert row[TOUCH_COLUMN["y_m"]] == np.float32(-0.2)


@pytest.mark.parametrize("far", [1e9, 1e300, math.inf])
def test_a_value_beyond_its_range_saturates_and_the_others_stay(far: float) -> None:
    usual = block(PRESSED)
    with np.errstate(over="ignore"):
        high = block(replace(PRESSED, stiffness_n_m=far))
        low = block(replace(PRESSED, surface_z_m=-far))
    for row, name, limit in ((high, "stiffness_n_m", TOUCH_HIGH), (low, "surface_z_m", TOUCH_LOW)):
        column = TOUCH_COLUMN[name]
        assert row[column] == limit[column]
        np.testing.assert_array_equal(np.delete(row, column), np.delete(usual, column))


def test_what_is_no_number_is_not_sent() -> None:
    with pytest.raises(BadPacket):
        TOUCH_BLOCK.check(touch_block({1: replace(PRESSED, surface_z_m=math.nan)}, 0.0, 0.0))


def test_fingers_that_are_not_in_use_are_zeros() -> None:
    assert not TOUCH_BLOCK.array(touch_block({}, 0.3, 0.3)).any()
