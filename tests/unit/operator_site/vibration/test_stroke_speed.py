"""The speed of a stroke, also where poses come late or in a burst."""

import math

import pytest

from operator_site.vibration.stroke_speed import StrokeSpeed

SPEED_M_S = 0.05


def place(t_s: float) -> float:
    """Poses of an even stroke, as the exoskeleton reports them."""
    return round(SPEED_M_S * t_s / 2e-5) * 2e-5


@pytest.mark.parametrize("ticks", [1, 2], ids=["each tick", "every other tick"])
def test_an_even_stroke_has_its_speed_also_in_ticks_without_a_new_pose(ticks: int) -> None:
    speed = StrokeSpeed()
    poses_s = [0.002 * ticks * (n // ticks) for n in range(200)]
    steps = [speed.step(t_s, place(t_s), 0.0) for t_s in poses_s]
    assert steps[20:] == pytest.approx([SPEED_M_S] * 180, abs=0.0011)


def test_the_speed_is_that_of_both_directions_together() -> None:
    speed = StrokeSpeed()
    assert [speed.step(0.002 * n, 0.03 * 0.002 * n, -0.04 * 0.002 * n) for n in range(50)][-1] == pytest.approx(0.05)


@pytest.mark.parametrize("held_s", [0.01, 0.03, 0.06, 0.09])
@pytest.mark.parametrize("stale", [0, 1, 3])
def test_poses_that_were_held_up_make_no_leap(held_s: float, stale: int) -> None:
    """The line stands still, then reports some old poses and the newest, tick by tick."""
    speed, speeds, held_at_s = StrokeSpeed(), [], 0.1
    for n in range(150):
        now_s = 0.002 * n
        since_s = now_s - held_at_s
        if 0.0 <= since_s < held_s:
            came_s = measured_s = held_at_s
        elif held_s <= since_s < held_s + 0.002 * stale:
            came_s, measured_s = now_s, held_at_s + since_s - held_s
        else:
            came_s = measured_s = now_s
        speeds.append(speed.step(came_s, place(measured_s), 0.0))
    assert max(speeds[20:]) <= 2.5 * SPEED_M_S
    assert speeds[-1] == pytest.approx(SPEED_M_S, abs=0.0011)


@pytest.mark.parametrize("later_s", [0.2, -0.05])
def test_the_speed_restarts_after_a_long_silence_or_a_clock_set_back(later_s: float) -> None:
    speed = StrokeSpeed()
    for n in range(20):
        speed.step(0.002 * n, place(0.002 * n), 0.0)
    assert speed.step(0.038 + later_s, 0.5, 0.0) == 0.0


def test_the_first_pose_is_no_movement() -> None:
    assert StrokeSpeed().step(1.0, 0.3, 0.0) == 0.0
    assert not math.isnan(StrokeSpeed().step(math.inf, 0.3, 0.0))
