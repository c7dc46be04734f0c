"""The search finds a nodule in its place, calls an even ground empty, and takes breathing away."""

import math

import numpy as np
import pytest

from operator_site.palpation.lump_probability import LumpMap, lumps_of_field, lumps_of_presses
from operator_site.palpation.nodule_search import MOST_SEARCHED, RIGHT_WHEN_SURE, NoduleSearch, one_stiffness
from operator_site.palpation.stiffness_field import StiffnessField
from tests.unit.operator_site.palpation.made_ground import grid_m, ln_stiffness
from tests.unit.studies.nodules.breathing_presses import MIDDLE_M, numbers_of


def search(lumps: str, seed: int = 1, step_m: float = 0.006) -> NoduleSearch:
    places_m = grid_m(step_m=step_m)
    value = ln_stiffness(places_m, np.random.default_rng(seed), lumps)
    return NoduleSearch(one_stiffness(places_m, value, np.full(len(value), 1e-4)))


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


@pytest.mark.long
def test_breathing_is_taken_away_and_hides_no_nodule() -> None:
    still, breathing = NoduleSearch(numbers_of(0.0)), NoduleSearch(numbers_of(0.4e-3))
    raw = numbers_of(0.4e-3).value
    assert np.std(breathing.steady[1]) < 0.3 * np.std(raw[1])
    assert breathing.probability(grid_m()).max() < 0.2
    assert still.probability(grid_m()).max() < 0.2
    found = NoduleSearch(numbers_of(0.4e-3, 5e-3))
    assert found.probability([MIDDLE_M])[0] > 0.9 * RIGHT_WHEN_SURE


def test_no_further_nodule_is_suspected_beneath_one_that_was_taken_away() -> None:
    found, places_m = search("ball"), np.array([MIDDLE_M, (0.01, 0.05)])
    np.testing.assert_allclose(found.taken(places_m), [1.0, 0.0], atol=0.01)
    assert found.ln_ratio(places_m)[0] < 0.0


def test_presses_are_predicted_near_others_and_open_far_from_them() -> None:
    found = search("none")
    near, far = found.presses.places_m[40], (1.0, 1.0)
    shares, covariance, noise = found.ground.unpressed(np.array([near, far]))
    assert shares[:, 0].argmax() == 40
    assert shares[:, 0].sum() == pytest.approx(1.0, abs=0.01)
    assert covariance[0, 0] < noise[0] < covariance[1, 1]


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
