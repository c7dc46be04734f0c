"""An estimate that moves further than its uncertainty allows is found, and one that settles is not."""

import pytest

from remote_site.thermal.estimate_drift import FROM_S, HELD_S, MOST_SD, EstimateDrift

TICK_S = 0.1
LIMIT_K = MOST_SD * 0.4 * 2.0**0.5
"""Largest difference of two estimates with a standard deviation of 0.4 K."""


def drifts(estimates_c: list[float], from_s: float = FROM_S) -> list[bool]:
    drift = EstimateDrift()
    return [drift.step(from_s + TICK_S * k, object_c, 0.4) for k, object_c in enumerate(estimates_c)]


def test_an_estimate_that_becomes_certain_within_its_uncertainty_does_not_drift() -> None:
    drift = EstimateDrift()
    assert not any(drift.step(0.1 * k, 24.0 + 1.0 / k, 1.5 / k) for k in range(1, 60))


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_one_that_leaves_an_earlier_one_slowly_drifts(sign: float) -> None:
    course = [24.0 + sign * 0.029 * LIMIT_K * k for k in range(60)]
    first = drifts(course).index(True)
    assert first == 35 + round(HELD_S / TICK_S) - 1


def test_single_solutions_far_off_are_no_drift() -> None:
    course = [24.0] * 60
    course[7] = course[8] = 40.0
    assert not any(drifts(course))


def test_early_estimates_do_not_count() -> None:
    assert not any(drifts([40.0] + [24.0] * 40, from_s=FROM_S - TICK_S))
