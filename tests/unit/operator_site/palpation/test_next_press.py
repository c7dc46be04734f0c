"""The next press goes where the least is known, then to undecided places, and several presses are spread."""

import numpy as np
import pytest
from scipy.spatial.distance import cdist

from operator_site.palpation.lump_probability import search_of_field
from operator_site.palpation.next_press import MOST_CANDIDATES, next_presses
from operator_site.palpation.nodule_search import NoduleSearch
from operator_site.palpation.stiffness_field import StiffnessField
from tests.unit.operator_site.palpation.made_ground import grid_m, ln_stiffness

LOW_M, HIGH_M = (0.0, 0.0), (0.06, 0.06)


def search(places_m: np.ndarray, lumps: str = "ball", seed: int = 1) -> NoduleSearch:
    values = ln_stiffness(places_m, np.random.default_rng(seed), lumps)
    return search_of_field(StiffnessField(places_m, values, np.full(len(values), 1e-4)))


def test_ground_that_was_not_pressed_comes_first() -> None:
    half = grid_m(step_m=0.006)
    half = half[half[:, 0] <= 0.03]
    (place,) = next_presses(search(half, "none"), LOW_M, HIGH_M)
    assert place[0] > 0.036


def test_several_presses_are_apart_and_inside() -> None:
    places = next_presses(search(grid_m(step_m=0.03)), LOW_M, HIGH_M, 5)
    assert cdist(places, places)[np.triu_indices(5, 1)].min() > 0.006
    assert (places >= 0.0).all()
    assert (places <= 0.06).all()


def test_a_suspicious_place_comes_before_a_decided_one() -> None:
    """On an even grid of presses the next one goes to the lump's edge."""
    (place,) = next_presses(search(grid_m(step_m=0.006)), LOW_M, HIGH_M)
    assert 0.003 < np.hypot(*(place - 0.03)) < 0.010


@pytest.mark.parametrize("seed", range(1, 5))
def test_a_found_lump_is_not_pressed_in_its_middle(seed: int) -> None:
    places = next_presses(search(grid_m(step_m=0.006), seed=seed), LOW_M, HIGH_M, 3)
    assert cdist(places, [(0.03, 0.03)]).min() > 0.004


def test_the_number_of_candidates_is_bounded() -> None:
    places = next_presses(search(grid_m()), (-1.0, -1.0), (1.0, 1.0), 2 * MOST_CANDIDATES)
    assert len(places) <= MOST_CANDIDATES


def test_a_rectangle_without_extent_gives_its_place() -> None:
    assert next_presses(search(grid_m()), (0.0301, 0.0301), (0.0301, 0.0301)).tolist() == [[0.0301, 0.0301]]


def test_between_presses_on_a_line_there_are_places_along_it() -> None:
    line = StiffnessField([(0.0005 + 1e-4 * (n % 3), 0.004 * n) for n in range(10)], [6.0] * 10, [1e-3] * 10)
    places = next_presses(search_of_field(line), line.places_m.min(axis=0), line.places_m.max(axis=0), 3)
    assert len({*places[:, 1].tolist()}) == 3
