"""Presses of different depth are brought to one depth, and nothing else changes a stiffness."""

import numpy as np
import pytest

from operator_site.palpation.press_depth import at_one_depth
from operator_site.palpation.stiffness_field import Floats
from tests.unit.operator_site.palpation.made_ground import grid_m, ln_stiffness

DEPTH_M = 3e-3
PRESS_SD = 0.02


def pressed(exponent: float, depth_m: Floats, seed: int = 0) -> Floats:
    """Presses of a ball in a ground of some exponent, whose stiffness at DEPTH_M is that of `ln_stiffness`."""
    chance, places_m = np.random.default_rng(seed), grid_m()
    at_depth = ln_stiffness(places_m, np.random.default_rng(1), sd=0.0)
    true = at_depth + (exponent - 1.0) * np.log(depth_m / DEPTH_M)
    measured = true + PRESS_SD * chance.normal(size=len(places_m))
    return np.column_stack([places_m, measured, np.full(len(places_m), PRESS_SD**2), np.exp(true) * depth_m])


def uneven_m(seed: int = 2, sd: float = 0.12) -> Floats:
    """Depths of presses by a hand, m."""
    return DEPTH_M * np.exp(sd * np.random.default_rng(seed).normal(size=len(grid_m())))


@pytest.mark.parametrize("exponent", [1.3, 1.6, 1.9])
def test_the_ground_and_its_ball_appear_as_at_one_depth(exponent: float) -> None:
    depth_m, at_depth = uneven_m(), ln_stiffness(grid_m(), np.random.default_rng(1), sd=0.0)
    presses = pressed(exponent, depth_m)
    before, after = presses[:, 2] - at_depth, at_one_depth(presses)[:, 2] - at_depth
    assert np.std(after) < 0.7 * np.std(before)
    assert np.std(after) < 2.0 * exponent * PRESS_SD


def test_a_linear_law_needs_no_correction() -> None:
    presses = pressed(1.0, uneven_m())
    np.testing.assert_allclose(at_one_depth(presses)[:, 2], presses[:, 2], atol=2.0 * PRESS_SD)


def test_at_one_depth_the_ball_keeps_its_stiffness_although_the_force_follows_it() -> None:
    presses = pressed(1.6, np.full(len(grid_m()), DEPTH_M))
    np.testing.assert_allclose(at_one_depth(presses)[:, 2], presses[:, 2], atol=4.0 * PRESS_SD)


def test_the_deviation_grows_with_the_correction() -> None:
    presses = pressed(1.6, uneven_m())
    grown = at_one_depth(presses)[:, 3] / presses[:, 3]
    assert grown == pytest.approx(np.full(len(grown), grown[0]))
    assert 1.3**2 < grown[0] < 1.9**2


def test_one_force_and_unknown_forces_change_nothing() -> None:
    presses = pressed(1.6, uneven_m())
    for force_n in (0.0, 1.0):
        presses[:, 4] = force_n
        np.testing.assert_allclose(at_one_depth(presses)[:, 3], presses[:, 3])
    presses[:, 4] = 0.0
    np.testing.assert_array_equal(at_one_depth(presses), presses[:, :4])


def test_presses_without_a_force_stay_beside_others() -> None:
    presses = pressed(1.6, uneven_m())
    presses[::2, 4] = 0.0
    rows = at_one_depth(presses)
    np.testing.assert_array_equal(rows[::2], presses[::2, :4])
    assert (rows[1::2, 2] != presses[1::2, 2]).any()


@pytest.mark.parametrize("count", [1, 2])
def test_few_presses_stay_about_as_they_are(count: int) -> None:
    presses = pressed(1.6, uneven_m())[:count]
    np.testing.assert_allclose(at_one_depth(presses)[:, 2], presses[:, 2], atol=0.03)
