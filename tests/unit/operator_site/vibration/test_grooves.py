"""Impulses of a patterned surface: one by one, or folded into a mean."""

import math

import pytest

from operator_site.vibration.grooves import OVER_S, Grooves

TICK_S = 0.002
DECAY_PER_S = 60.0
AMPLITUDE = 400.0


def stroked(rate_hz: float, seconds: float = 2.0, grooves: Grooves | None = None, start_s: float = 0.0) -> list[float]:
    """What the pattern adds at each tick."""
    grooves = grooves or Grooves()
    added, crossed = [], 0
    for tick in range(round(seconds / TICK_S)):
        t_s = start_s + tick * TICK_S
        grooves.step(t_s, DECAY_PER_S)
        while crossed / rate_hz <= t_s - start_s + 1e-9:
            grooves.cross(AMPLITUDE, round((start_s + crossed / rate_hz) * 1e9), DECAY_PER_S)
            crossed += 1
        added.append(grooves.rad_s)
    return added


@pytest.mark.parametrize("rate_hz", [1.0, 5.0, 10.0, 15.0, 19.0])
def test_slow_grooves_stay_impulses(rate_hz: float) -> None:
    added = stroked(rate_hz)
    rises = sum(b > a + 0.5 * AMPLITUDE for a, b in zip([0.0, *added], added, strict=False))
    assert rises == math.floor(1.9999 * rate_hz) + 1


@pytest.mark.parametrize("rate_hz", [22.0, 25.0, 40.0, 100.0])
def test_fast_grooves_become_an_even_speed_of_the_same_mean(rate_hz: float) -> None:
    late = stroked(rate_hz)[500:]
    assert max(late) == pytest.approx(min(late))
    assert late[0] == pytest.approx(min(AMPLITUDE * rate_hz / DECAY_PER_S, 1047.2), rel=0.01)


def test_folding_has_hysteresis_and_ends_with_the_pattern() -> None:
    grooves = Grooves()
    stroked(25.0, 1.0, grooves)
    assert grooves.folded
    stroked(17.0, 1.0, grooves, start_s=1.0)
    assert grooves.folded
    stroked(12.0, 1.0, grooves, start_s=2.0)
    assert not grooves.folded
    stroked(25.0, 1.0, grooves, start_s=3.0)
    grooves.step(4.0 + OVER_S, DECAY_PER_S)
    assert (grooves.folded, grooves.rad_s) == (False, 0.0)


def test_one_groove_that_comes_early_folds_nothing() -> None:
    grooves = Grooves()
    for number, time_s in enumerate((0.0, 0.1, 0.2, 0.24, 0.34)):
        grooves.step(time_s, DECAY_PER_S)
        grooves.cross(AMPLITUDE, round(time_s * 1e9), DECAY_PER_S)
        assert not grooves.folded, number


def test_grooves_that_arrive_together_are_separated_by_their_own_times() -> None:
    """Ten a second, but the link was away for half a second."""
    grooves = Grooves()
    grooves.step(0.5, DECAY_PER_S)
    for number in range(5):
        grooves.cross(AMPLITUDE, round(0.1e9 * number), DECAY_PER_S)
    assert not grooves.folded
    assert grooves.rad_s <= 1047.3


def test_a_surface_without_a_decay_has_the_usual_one() -> None:
    grooves = Grooves()
    grooves.step(0.0, 0.0)
    grooves.cross(AMPLITUDE, 0, 0.0)
    grooves.step(0.02, 0.0)
    assert grooves.rad_s == pytest.approx(AMPLITUDE * math.exp(-1.2))
