"""A punctual loop shows the stiffness of its period, and a late loop shows less while it is late."""

import math

import pytest

from operator_site.force.loop_stiffness import LONGEST_S, LoopStiffness
from operator_site.safety.sampled_wall import SampledWall

WALL = SampledWall(2.0, 0.002, 0.004)
"""400 N/m."""


def run(held: LoopStiffness, times_s: list[float]) -> None:
    for t_s in times_s:
        held.step(t_s, t_s - 0.001)


def every(period_s: float, begin_s: float, end_s: float) -> list[float]:
    return [begin_s + period_s * i for i in range(round((end_s - begin_s) / period_s))]


def test_a_punctual_loop_or_one_pause_shows_the_full_wall() -> None:
    held = LoopStiffness(WALL)
    run(held, every(0.002, 0.0, 1.0) + every(0.002, 1.010, 2.0))
    assert held.wall is WALL
    run(held, [2.0 + LONGEST_S + 0.001, 2.0 + LONGEST_S + 0.003])
    assert held.wall is WALL


def test_a_loop_that_runs_ten_of_forty_milliseconds_shows_a_softer_wall_and_then_the_old_one() -> None:
    held = LoopStiffness(WALL)
    run(held, [0.04 * slice_ + t_s for slice_ in range(25) for t_s in every(0.002, 0.0, 0.010)])
    mean_s = (4 * 0.002**2 + 0.032**2) / 0.040
    assert held.wall.stiffest_n_m == pytest.approx(2.0 / (0.5 * mean_s + 0.004), rel=0.1)
    run(held, every(0.002, 1.0, 3.0))
    assert held.wall is WALL


def test_a_loop_at_half_its_rate_shows_the_wall_of_its_period() -> None:
    held = LoopStiffness(WALL)
    run(held, every(0.004, 0.0, 2.0))
    assert held.wall.stiffest_n_m == pytest.approx(2.0 / (0.002 + 0.004), rel=0.01)


def test_heights_that_come_late_hold_a_force_longer_as_a_late_loop_does() -> None:
    held = LoopStiffness(WALL)
    for t_s in every(0.002, 0.0, 1.0):
        held.step(t_s, 0.030 * math.floor(t_s / 0.030))
    assert held.wall.stiffest_n_m == pytest.approx(2.0 / (0.015 + 0.004), rel=0.1)


def test_a_clock_that_was_set_back_and_heights_that_never_come_change_nothing() -> None:
    held = LoopStiffness(WALL)
    run(held, [1.0, 1.002, 0.5, 0.502])
    for t_s in every(0.002, 0.504, 0.7):
        held.step(t_s, math.nan)
    assert held.wall is WALL
