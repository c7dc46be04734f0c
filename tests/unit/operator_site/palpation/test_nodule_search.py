"""The search finds a nodule in its place, calls an even ground empty, and takes breathing away."""

import math

import numpy as np
import pytest

from operator_site.palpation.inclusion_model import contact_radius_m, energy_share, ln_lift
from operator_site.palpation.lump_probability import LumpMap, lumps_of_field, lumps_of_presses
from operator_site.palpation.nodule_search import MOST_SEARCHED, RIGHT_WHEN_SURE, NoduleSearch, one_stiffness
from operator_site.palpation.stiffness_field import StiffnessField
from studies.nodules.press_numbers import FEWEST_STEPS, press_numbers
from tests.unit.operator_site.palpation.made_ground import grid_m, ln_stiffness

MIDDLE_M = (0.03, 0.03)
CONTACT_N, PROBE_M, SINCE_S = 0.075, 6e-3, 0.1 * np.arange(1, 9)


def search(lumps: str, seed: int = 1, step_m: float = 0.006) -> NoduleSearch:
    places_m = grid_m(step_m=step_m)
    value = ln_stiffness(places_m, np.random.default_rng(seed), lumps)
    return NoduleSearch(one_stiffness(places_m, value, np.full(len(value), 1e-4)))


def pressed(breath_m: float, top_m: float | None = None) -> tuple[np.ndarray, ...]:
    """Places, depths, forces and times of contact of presses on breathing ground, with a nodule of 15 mm or none."""
    chance = np.random.default_rng(2)
    places_m = grid_m()
    away_m = np.hypot(*(places_m - MIDDLE_M).T)
    depth_m = 3e-3 * np.arange(1, 9) / 8
    contact_s = 1.5 * np.arange(len(places_m))
    start = 2.0 * math.pi * 15.0 / 60.0 * contact_s[:, None]
    rise_m = breath_m * (np.sin(start + 2.0 * math.pi * 15.0 / 60.0 * SINCE_S) - np.sin(start))
    contact_m = 1e-3
    force_n = CONTACT_N * ((depth_m + rise_m + contact_m) / contact_m) ** 2.0
    if top_m is not None:
        share = energy_share(away_m, top_m, 7.5e-3, contact_radius_m(PROBE_M, 2e-3))
        force_n *= np.exp(ln_lift(share, 8.0))[:, None]
    return places_m, depth_m, force_n * (1.0 + 0.01 * chance.normal(size=force_n.shape)), contact_s


def numbers_of(breath_m: float, top_m: float | None = None):  # type: ignore[no-untyped-def]
    places_m, depth_m, force_n, contact_s = pressed(breath_m, top_m)
    return press_numbers(places_m, depth_m, force_n, CONTACT_N, PROBE_M, SINCE_S, contact_s)


@pytest.mark.long
def test_a_lump_is_found_at_its_place() -> None:
    found = search("ball")
    best = max(found.nodules, key=lambda one: one.probability)
    assert best.probability > 0.9 * RIGHT_WHEN_SURE
    assert math.dist((best.x_m, best.y_m), MIDDLE_M) < 2e-3
    assert found.probability([MIDDLE_M])[0] > 0.9 * RIGHT_WHEN_SURE
    assert found.probability([(0.05, 0.05)])[0] < 0.1


def test_an_even_ground_has_hardly_any_nodule() -> None:
    highest = [search("none", seed).probability(grid_m()).max() for seed in range(5)]
    assert np.median(highest) < 0.2


def test_contact_and_exponent_of_the_median_press_are_found() -> None:
    numbers = numbers_of(0.0)
    assert numbers.contact_m == pytest.approx(1e-3, rel=0.1)
    assert numbers.exponent == pytest.approx(2.0, rel=0.05)


@pytest.mark.long
def test_breathing_is_taken_away_and_hides_no_nodule() -> None:
    still, breathing = NoduleSearch(numbers_of(0.0)), NoduleSearch(numbers_of(0.4e-3))
    raw = numbers_of(0.4e-3).value
    assert np.std(breathing.steady[1]) < 0.3 * np.std(raw[1])
    assert breathing.probability(grid_m()).max() < 0.2
    assert still.probability(grid_m()).max() < 0.2
    found = NoduleSearch(numbers_of(0.4e-3, 5e-3))
    assert found.probability([MIDDLE_M])[0] > 0.9 * RIGHT_WHEN_SURE


def test_a_press_that_ended_early_says_nothing_about_the_depth_beyond() -> None:
    places_m, depth_m, force_n, contact_s = pressed(0.0)
    force_n[3, 6:] = np.nan
    numbers = press_numbers(places_m, depth_m, force_n, CONTACT_N, PROBE_M, SINCE_S, contact_s)
    assert numbers.variance[1, 3] > 10.0 > 1e-2 > numbers.variance[0, 3]


def test_a_press_needs_some_readings() -> None:
    places_m, depth_m, force_n, contact_s = pressed(0.0)
    few = FEWEST_STEPS - 1
    with pytest.raises(ValueError, match=f"a press needs {FEWEST_STEPS} readings"):
        press_numbers(places_m, depth_m[:few], force_n[:, :few], CONTACT_N, PROBE_M, SINCE_S[:few], contact_s)


def test_a_large_map_is_searched_within_bounds() -> None:
    chance = np.random.default_rng(4)
    places_m = 0.3 * chance.random((256, 2))
    found = NoduleSearch(one_stiffness(places_m, ln_stiffness(places_m, chance, "none"), np.full(256, 1e-3)))
    assert len(found._sites_m) <= MOST_SEARCHED


@pytest.mark.long
def test_lump_probabilities_take_deep_nodules_from_the_search() -> None:
    numbers = numbers_of(0.2e-3, 7e-3)
    found = lumps_of_presses(numbers)
    assert found.nodules
    assert found.probability([MIDDLE_M])[0] > 0.9 * RIGHT_WHEN_SURE
    field = StiffnessField(numbers.places_m, numbers.value[1], numbers.variance[1])
    assert found.probability([MIDDLE_M])[0] > LumpMap(field).probability([MIDDLE_M])[0]


def test_a_field_is_searched_as_presses_with_one_stiffness() -> None:
    places_m = grid_m()
    value = ln_stiffness(places_m, np.random.default_rng(1), "ball")
    found = lumps_of_field(StiffnessField(places_m, value, np.full(len(value), 1e-4)))
    assert found.probability([MIDDLE_M])[0] > 0.9 * RIGHT_WHEN_SURE
