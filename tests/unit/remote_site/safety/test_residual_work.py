"""The work that a finger has left in its object, from its measurements."""

import itertools
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.limits import LEFT_J, LEFT_W
from remote_site.safety.residual_work import ResidualWork

DT = 0.002


@given(st.lists(st.tuples(st.floats(-0.01, 0.01), st.floats(0.0, 5.0)), min_size=2, max_size=20))
def test_residual_work_is_the_work_downwards_less_the_allowed_rate(places: list[tuple[float, float]]) -> None:
    left, expected_j = ResidualWork(), 0.0
    left.step(DT, *places[0])
    for (before_m, before_n), (z_m, force_n) in itertools.pairwise(places):
        left.step(DT, z_m, force_n)
        expected_j = max(0.0, expected_j + 0.5 * (before_n + force_n) * (before_m - z_m) - LEFT_W * DT)
        assert left.left_j == pytest.approx(expected_j, abs=1e-12)
        assert left.room_j == pytest.approx(max(0.0, LEFT_J - expected_j), abs=1e-12)


def test_residual_work_drains_in_the_air() -> None:
    left = ResidualWork()
    for z_m, force_n in ((0.0, 1.0), (-0.01, 1.0), (0.0, 0.0), (0.001, 0.0)):
        left.step(DT, z_m, force_n)
    assert left.left_j == pytest.approx(0.010 - 0.005 - 3.0 * LEFT_W * DT)


def test_a_finger_that_sinks_in_the_air_leaves_no_work() -> None:
    left = ResidualWork()
    for z_m, force_n in ((0.006, 0.0), (0.006, 0.0), (0.0, 0.0), (-0.001, 2.0)):
        left.step(DT, z_m, force_n)
    assert left.left_j == pytest.approx(0.5 * 2.0 * 0.001 - LEFT_W * DT)


@pytest.mark.parametrize("value", [math.nan, math.inf, -math.inf])
def test_nan_restarts_the_account(value: float) -> None:
    for wrong in ((value, 1.0), (0.0, value)):
        left = ResidualWork()
        assert (left.left_j, left.room_j) == (0.0, LEFT_J)
        left.step(DT, 0.0, 5.0)
        left.step(DT, -0.01, 5.0)
        assert left.left_j > 0.0
        left.step(DT, *wrong)
        assert left.left_j == 0.0
        left.step(DT, -1.0, 5.0)
        assert left.left_j == 0.0
        left.step(DT, -1.01, 5.0)
        assert left.left_j == pytest.approx(0.05 - LEFT_W * DT)
