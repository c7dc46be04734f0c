"""A wall as far as a device can show it."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from operator_site.safety.sampled_wall import SampledWall


@pytest.mark.parametrize(
    ("wall", "stiffest_n_m"),
    [(SampledWall(0.5, 0.001), 2.0 * 0.5 / 0.001), (SampledWall(2.0, 0.002, 0.004), 400.0)],
    ids=["of the publication, without delay", "a delay costs stiffness"],
)
def test_stiffest_wall(wall: SampledWall, stiffest_n_m: float) -> None:
    assert wall.stiffest_n_m == pytest.approx(stiffest_n_m)


@given(st.floats(0.0, 50.0), st.floats(1e-4, 0.1), st.floats(0.0, 0.1), st.floats(0.0, 1.0))
def test_stiffness_and_damping_share_the_devices_damping(damping: float, period_s: float, delay_s: float, share: float):
    wall = SampledWall(damping, period_s, delay_s)
    left = wall.damping_left_n_s_m(share * wall.stiffest_n_m)
    assert left == pytest.approx((1.0 - share) * damping, abs=1e-9)
    assert wall.damping_left_n_s_m(2.0 * wall.stiffest_n_m + 1.0) == 0.0


@pytest.mark.parametrize("wrong", [(-1.0, 0.001, 0.0), (0.5, 0.0, 0.0), (math.nan, 0.001, 0.0), (0.5, 0.001, math.inf)])
def test_an_impossible_device_is_refused(wrong: tuple[float, float, float]) -> None:
    with pytest.raises(ValueError, match="period above 0"):
        SampledWall(*wrong)
