"""The posterior finds a nodule, states what it cannot know, and its probabilities hold on drawn grounds."""

import math

import numpy as np
import pytest
from scipy.spatial.distance import cdist

from operator_site.palpation.inclusion_model import contact_radius_m, energy_share, ln_lift
from operator_site.palpation.nodule_posterior import DIAMETERS_M, NODULE, RATIOS, TOPS_M, Nodule, Presses, nodule
from operator_site.palpation.stiffness_field import NARROW_M, matern

PROBE_M, SPREAD, PRESS = 4e-3, 0.04, 0.03


def presses(
    chance: np.random.Generator, hidden: tuple[float, float, float] | None, indentations_m: tuple[float, ...] = (2e-3,)
) -> Presses:
    """Presses every 5 mm with each indentation over a nodule of top, diameter (m) and ratio at 2, 1 mm, or none."""
    axis = np.arange(-0.02, 0.0201, 0.005)
    places = np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)
    each = len(places)
    places = np.concatenate([places] * len(indentations_m))
    indentation = np.repeat(indentations_m, each)
    covariance = SPREAD**2 * matern(cdist(places, places), NARROW_M) + 1e-9 * np.eye(len(places))
    value = np.linalg.cholesky(covariance) @ chance.normal(size=len(places)) + PRESS * chance.normal(size=len(places))
    if hidden is not None:
        top_m, diameter_m, ratio = hidden
        away = np.hypot(*(places - (0.002, 0.001)).T)
        for one in indentations_m:
            share = energy_share(away, top_m, 0.5 * diameter_m, contact_radius_m(PROBE_M, one))
            value += np.where(indentation == one, ln_lift(share, ratio), 0.0)
    return Presses(places, value + 6.5, np.full(len(places), PRESS**2), indentation)


def found(data: Presses) -> Nodule:
    answer = nodule(data, (0.0, 0.0), SPREAD, PROBE_M)
    assert answer is not None
    return answer


def drawn(chance: np.random.Generator) -> tuple[float, float, float]:
    top, diameter, ratio = (
        math.exp(chance.uniform(math.log(ends[0]), math.log(ends[-1]))) for ends in (TOPS_M, DIAMETERS_M, RATIOS)
    )
    return top, diameter, ratio


def test_a_nodule_near_the_surface_is_found_at_its_place() -> None:
    answer = found(presses(np.random.default_rng(1), (1e-3, 10e-3, 10.0)))
    assert answer.probability > 0.99
    assert math.dist((answer.x_m, answer.y_m), (0.002, 0.001)) < 1.5e-3
    assert answer.diameter.low < 10e-3 < answer.diameter.high
    assert not answer.ratio.known, "one force per place does not separate the ratio from the size"


@pytest.mark.long
def test_an_even_ground_has_a_nodule_less_probably_than_before() -> None:
    chance = np.random.default_rng(2)
    even = [found(presses(chance, None)).probability for _ in range(10)]
    assert np.mean(even) < NODULE


def test_nothing_can_be_said_about_a_deep_small_nodule() -> None:
    answer = found(presses(np.random.default_rng(3), (15e-3, 4e-3, 2.0)))
    assert answer.probability < 2.0 * NODULE
    assert [one.known for one in (answer.top, answer.diameter, answer.ratio)] == [False] * 3


@pytest.mark.parametrize("hidden", [(1e-3, 20e-3, 60.0), (1e-3, 4e-3, 1.3), (15e-3, 4e-3, 2.0), (1e-3, 30e-3, 20.0)])
def test_no_stated_value_is_beyond_the_range_of_the_prior(hidden: tuple[float, float, float]) -> None:
    answer = found(presses(np.random.default_rng(3), hidden))
    for one, prior in ((answer.top, TOPS_M), (answer.diameter, DIAMETERS_M), (answer.ratio, RATIOS)):
        stated = np.array([prior[0], one.low, one.middle, one.high, prior[-1]])
        assert (np.diff(stated) >= -1e-9 * stated[:-1]).all()


@pytest.mark.long
def test_stated_intervals_and_probabilities_hold() -> None:
    """Half the grounds have a nodule; the odds of NODULE are turned into even odds before they are compared."""
    chance = np.random.default_rng(4)
    covered, stated, true = [], [], []
    for number in range(160):
        hidden = drawn(chance) if number % 2 else None
        answer = found(presses(chance, hidden))
        odds = answer.probability / max(1.0 - answer.probability, 1e-12) * (1.0 - NODULE) / NODULE
        stated.append(odds / (1.0 + odds))
        true.append(hidden is not None)
        if hidden is not None:
            quantities = (answer.top, answer.diameter, answer.ratio)
            covered.append([one.low <= value <= one.high for one, value in zip(quantities, hidden, strict=True)])
    assert (np.mean(covered, axis=0) > 0.85).all()
    sure, unsure = np.array(stated) > 0.9, np.array(stated) < 0.5
    assert np.mean(np.array(true)[sure]) > 0.9
    assert np.mean(np.array(true)[unsure]) == pytest.approx(np.mean(np.array(stated)[unsure]), abs=0.12)


@pytest.mark.long
def test_two_indentations_say_more_about_depth_than_one_twice() -> None:
    deviations = [
        [found(presses(np.random.default_rng(seed), (4e-3, 12e-3, 5.0), pair)).top.ln_sd for seed in range(8)]
        for pair in ((2e-3, 2e-3 + 1e-7), (0.8e-3, 3e-3))
    ]
    assert np.mean(deviations[1]) < 0.9 * np.mean(deviations[0])


def test_too_few_presses_near_give_no_answer() -> None:
    data = presses(np.random.default_rng(5), None)
    assert nodule(data, (1.0, 1.0), SPREAD, PROBE_M) is None
