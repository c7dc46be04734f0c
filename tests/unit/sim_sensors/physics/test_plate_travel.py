"""A plate that strokes comes over new ground; one that trembles does not."""

import math

import pytest

from sim_sensors.physics.plate_travel import PLAY_M, PlateTravel

DT_S = 0.002


def test_a_trembling_plate_stays_where_it_is() -> None:
    ground = PlateTravel()
    for n in range(5000):
        ground.move(0.3 * PLAY_M * math.sin(0.02 * n), 0.3 * PLAY_M * math.cos(0.017 * n))
    assert ground.take_speed_m_s(10.0) == 0.0


@pytest.mark.parametrize(("x", "y"), [(1.0, 0.0), (-1.0, 0.0), (0.6, 0.8)])
def test_a_stroking_plate_comes_over_all_that_it_passes(x: float, y: float) -> None:
    ground = PlateTravel()
    for n in range(1001):
        ground.move(0.05 * DT_S * n * x, 0.05 * DT_S * n * y)
        if n == 500:
            ground.take_speed_m_s(1.0)
    assert ground.take_speed_m_s(1.0) == pytest.approx(0.05)


def test_where_it_turns_round_it_has_been_for_a_moment() -> None:
    ground = PlateTravel()
    for n in range(501):
        ground.move(0.05 * DT_S * n, 0.0)
    ground.take_speed_m_s(1.0)
    for n in range(501):
        ground.move(0.05 * (1.0 - DT_S * n), 0.0)
    assert ground.take_speed_m_s(1.0) == pytest.approx(0.05 - 2.0 * PLAY_M)
