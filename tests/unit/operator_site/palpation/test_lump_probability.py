"""Lumps and cords are probable where they are, an even ground has none, and stated probabilities hold."""

import numpy as np
import pytest

from operator_site.palpation.lump_probability import FEWEST_PLACES, UNKNOWN, LumpMap, lumps_of_field
from operator_site.palpation.stiffness_field import StiffnessField, lattice
from tests.unit.operator_site.palpation.made_ground import grid_m, ln_stiffness


def lump_map(lumps: str, seed: int, step_m: float = 0.004) -> LumpMap:
    places_m = grid_m(step_m=step_m)
    values = ln_stiffness(places_m, np.random.default_rng(seed), lumps)
    return LumpMap(StiffnessField(places_m, values, np.full(len(values), 1e-4)))


@pytest.mark.parametrize("lumps", ["ball", "cord"])
def test_a_stiff_place_is_a_lump_and_the_ground_beside_it_is_not(lumps: str) -> None:
    found = lump_map(lumps, 1)
    along_m = np.column_stack([np.full(5, 0.03), np.linspace(0.01, 0.05, 5) if lumps == "cord" else np.full(5, 0.03)])
    assert (found.probability(along_m) > 0.9).all()
    beside_m = lattice((0.045, 0.0), (0.06, 0.06), 0.004)
    assert (found.probability(beside_m) > 0.5).mean() < 0.05


@pytest.mark.parametrize("ratio", [3.0, 100.0, 1e4])
def test_a_very_stiff_place_is_a_lump(ratio: float) -> None:
    places_m = grid_m()
    inside = np.hypot(*(places_m - 0.03).T) < 0.008
    values = ln_stiffness(places_m, np.random.default_rng(1), "none", 0.005) + np.where(inside, np.log(ratio), 0.0)
    found = LumpMap(StiffnessField(places_m, values, np.full(len(values), 1e-6)))
    assert found.probability(np.array([[0.03, 0.03]]))[0] > 0.9


def test_an_even_ground_has_hardly_any_lump() -> None:
    cells_m = lattice((0.0, 0.0), (0.06, 0.06), 0.002)
    called = [(lump_map("none", seed, 0.006).probability(cells_m) > 0.5).mean() for seed in range(10)]
    assert np.mean(called) < 0.01


def test_a_place_far_from_every_press_has_the_prior_probability() -> None:
    assert lump_map("ball", 1).probability(np.array([[0.2, 0.2]]))[0] == pytest.approx(UNKNOWN)


def test_a_gap_of_a_raster_is_no_unknown_place() -> None:
    places_m = grid_m(step_m=0.01)
    values = ln_stiffness(places_m, np.random.default_rng(1), "none")
    found = lumps_of_field(StiffnessField(places_m, values, np.full(len(values), 1e-4)))
    gaps_m = 0.005 + grid_m(0.05, 0.01)
    assert np.median(found.probability(gaps_m)) < 0.2 * UNKNOWN
    assert found.probability(np.array([[0.2, 0.2]]))[0] == pytest.approx(UNKNOWN)


def test_the_spread_of_the_ground_needs_some_places() -> None:
    places_m = grid_m()[: FEWEST_PLACES - 1]
    with pytest.raises(ValueError, match=f"lump probabilities need {FEWEST_PLACES} places"):
        LumpMap(StiffnessField(places_m, np.full(len(places_m), 6.0), np.full(len(places_m), 1e-4)))


def test_a_large_map_is_searched_within_bounds() -> None:
    chance = np.random.default_rng(4)
    places_m = 0.3 * chance.random((3000, 2))
    found = LumpMap(StiffnessField(places_m, ln_stiffness(places_m, chance), np.full(3000, 1e-4)))
    assert len(found._searched_m) <= 600 + 256
