"""The field follows the presses, knows less away from them, and stays within its bounds of size."""

import math

import numpy as np
import pytest

from operator_site.palpation import stiffness_field
from operator_site.palpation.stiffness_field import MOST_PLACES, StiffnessField
from tests.unit.operator_site.palpation.made_ground import GROUND_LN, grid_m, ln_stiffness


def field(places_m: np.ndarray, values: np.ndarray, variance: float = 1e-4) -> StiffnessField:
    return StiffnessField(places_m, values, np.full(len(values), variance))


def test_one_press_is_known_at_its_place_and_less_the_farther_away() -> None:
    one = field(np.zeros((1, 2)), np.array([GROUND_LN]))
    mean, sd = one.at(np.array([[0.0, 0.0], [0.002, 0.0], [0.005, 0.0], [0.01, 0.0], [0.05, 0.0]]))
    np.testing.assert_allclose(mean, GROUND_LN, atol=1e-9)
    assert sd[0] < 0.15
    assert (np.diff(sd) > 0.0).all()


def test_the_stated_deviation_holds_between_presses() -> None:
    """Two thirds of the errors are within one deviation, over many grounds of the kernel's own kind."""
    outside = []
    for seed in range(12):
        chance = np.random.default_rng(seed)
        places_m = 0.05 * chance.random((120, 2))
        covariance = 0.2**2 * stiffness_field.correlation(stiffness_field.cdist(places_m, places_m))
        values = GROUND_LN + np.linalg.cholesky(covariance + 1e-9 * np.eye(120)) @ chance.normal(size=120)
        mean, sd = field(places_m[:60], values[:60] + 0.02 * chance.normal(size=60)).at(places_m[60:])
        outside.append(np.abs(values[60:] - mean) > sd)
    assert 0.22 < np.mean(outside) < 0.42


def test_a_tilt_of_the_ground_is_no_excess() -> None:
    places_m = grid_m()
    chance = np.random.default_rng(1)
    flat = field(places_m, ln_stiffness(places_m, chance, "none")).excess(places_m).mean
    lump = field(places_m, ln_stiffness(places_m, chance)).excess(places_m).mean
    assert np.abs(flat).max() < 0.1
    assert lump.max() == pytest.approx(0.45, abs=0.15)


def test_presses_at_one_place_are_merged_and_their_disagreement_widens_the_deviation() -> None:
    near_m = np.array([[0.0001, 0.0001], [0.0003, 0.0002]])
    agree, disagree = (field(near_m, np.array([GROUND_LN, GROUND_LN + off])) for off in (0.001, 0.6))
    assert len(agree.places_m) == len(disagree.places_m) == 1
    assert disagree.at(near_m[:1]).sd[0] > 2.0 * agree.at(near_m[:1]).sd[0]


def test_many_presses_stay_within_the_bound_and_keep_the_shape() -> None:
    chance = np.random.default_rng(2)
    places_m = 0.1 * chance.random((5000, 2))
    bounded = field(places_m, ln_stiffness(places_m, chance))
    assert len(bounded.places_m) <= MOST_PLACES
    high, low = bounded.at(np.array([[0.03, 0.03], [0.03, 0.06]])).mean
    assert high - low > 0.2


def test_merging_keeps_the_height_of_a_lump(monkeypatch: pytest.MonkeyPatch) -> None:
    places_m = grid_m(0.06, 0.003)
    values, middle_m = ln_stiffness(places_m, np.random.default_rng(4)), np.array([[0.03, 0.03]])
    merged = field(places_m, values, 4e-4)
    assert len(merged.places_m) <= MOST_PLACES < len(places_m)
    monkeypatch.setattr(stiffness_field, "MOST_PLACES", len(places_m))
    every = field(places_m, values, 4e-4)
    assert len(every.places_m) == len(places_m)
    assert merged.excess(middle_m).mean[0] > 0.9 * every.excess(middle_m).mean[0]
    assert merged.excess(middle_m).sd[0] < 1.2 * every.excess(middle_m).sd[0]


@pytest.mark.parametrize(
    ("places", "value", "variance"),
    [(np.zeros((0, 2)), 1.0, 1.0), (np.zeros((2, 2)), math.nan, 1.0), (np.zeros((2, 2)), 1.0, 0.0)],
)
def test_no_field_of_nothing_or_of_impossible_numbers(places: np.ndarray, value: float, variance: float) -> None:
    with pytest.raises(ValueError, match="a field of stiffness needs places"):
        StiffnessField(places, np.full(len(places), value), np.full(len(places), variance))
