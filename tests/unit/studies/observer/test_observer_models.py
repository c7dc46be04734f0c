"""The two observers and the interval of a share, against numbers computed by other means."""

import math
from itertools import permutations

import numpy as np
import pytest
from scipy.stats import norm

from studies.observer.paper_tables import beside
from studies.observer.texture_comparison import BY_HAND
from studies.observer.texture_observer import Features, confusion, matching
from studies.observer.thermal_observer import Answers, answers, answers_about, cue


@pytest.mark.parametrize(
    ("difference", "percent"),
    [(1.42, (99, 1, 0)), (1.17, (97, 3, 0)), (0.99, (93, 7, 0)), (0.43, (56, 40, 4)), (0.25, (40, 52, 8))],
)
def test_shares_of_answers_for_a_difference_of_cues(difference: float, percent: tuple[int, int, int]) -> None:
    # The differences are given with two digits.
    assert [100.0 * share for share in answers(difference, lapse=0.0)] == pytest.approx(percent, abs=1.0)


def test_answers_follow_from_a_weber_fraction_alone() -> None:
    criterion, noise = math.log(1.43), math.log(1.43) / 0.82
    for difference in np.linspace(-2.0, 2.0, 9):
        felt = norm(difference, noise)
        expected = (felt.sf(criterion), felt.cdf(criterion) - felt.cdf(-criterion), felt.cdf(-criterion))
        assert answers(float(difference), lapse=0.0) == pytest.approx(expected, abs=1e-12)


def test_a_lapse_is_spread_evenly() -> None:
    sure = answers(5.0)
    assert sure == pytest.approx((0.98, 0.01, 0.01), abs=1e-6)
    assert sum(answers(0.3)) == pytest.approx(1.0)


def test_objects_turned_round_turn_the_answers_round() -> None:
    one, other = answers_about([-3.2, -2.9], [-1.2]), answers_about([-1.2], [-3.2, -2.9])
    assert one == pytest.approx((other.warmer, other.equal, other.colder))
    assert answers_about([-3.0], [-1.0]) == pytest.approx(answers(cue(-3.0) - cue(-1.0)))
    assert isinstance(one, Answers)


@pytest.mark.parametrize(
    ("count", "percent"),
    [
        (0, (0, 26)),
        (1, (0.2, 38)),
        (2, (2, 48)),
        (4, (10, 65)),
        (5, (15, 72)),
        (7, (28, 85)),
        (8, (35, 90)),
        (10, (52, 98)),
        (11, (62, 99.8)),
        (12, (74, 100)),
    ],
)
def test_intervals_of_twelve(count: int, percent: tuple[float, float]) -> None:
    row = beside(0.5, count, 12)
    for end, printed in zip(("low", "high"), percent, strict=True):
        assert row[f"interval_{end}_percent"] == pytest.approx(printed, abs=0.05 if printed % 1.0 else 0.51)


def test_a_prediction_is_inside_up_to_the_interval_s_end() -> None:
    low = 0.01 * beside(0.5, 11, 12)["interval_low_percent"]
    assert beside(low + 1e-9, 11, 12)["inside"]
    assert not beside(low - 1e-9, 11, 12)["inside"]
    assert beside(0.5, None, 12)["inside"] is None


@pytest.mark.long
def test_features_set_by_hand_are_matched_as_often_as_known() -> None:
    shares = matching(BY_HAND, BY_HAND, seed=3, draws=20_000, lapse=0.0)
    assert [100.0 * share for share in shares] == pytest.approx([59, 83, 50, 95, 94, 97], abs=1.5)


def test_the_pairing_is_the_one_of_least_squares() -> None:
    """One draw: the pairs that are found have the least sum of squares of all 720 pairings of what was felt."""
    found = confusion(BY_HAND, BY_HAND, seed=11, draws=1, lapse=0.0)
    chance, unit = np.random.default_rng(11), np.array([0.45, 1.0, 0.35, 1.0])
    values = [[f.ln_intensity, f.pattern, f.ln_period, f.irregularity] for f in BY_HAND]
    real = np.array(values) / unit + 0.5 * chance.standard_normal((6, 4))
    virtual = np.array(values) / unit + chance.standard_normal((6, 4))
    best = min(permutations(range(6)), key=lambda order: ((real - virtual[list(order)]) ** 2).sum())
    assert found.tolist() == np.eye(6)[list(best)].tolist()


def test_what_shifts_a_whole_side_changes_no_pair() -> None:
    louder = [Features(f.ln_intensity + 7.0, f.pattern, f.ln_period, f.irregularity) for f in BY_HAND]
    assert matching(BY_HAND, louder, 5, 500) == matching(BY_HAND, BY_HAND, 5, 500)


def test_surfaces_that_feel_alike_are_matched_by_chance_and_lapses_are_chance() -> None:
    alike = [Features(0.1 * place) for place in range(6)]
    far = [Features(100.0 * place) for place in range(6)]
    assert matching(far, far, 0, 200, lapse=0.0) == [1.0] * 6
    assert matching(far, far, 0, 200, lapse=0.3) == pytest.approx([0.7 + 0.05] * 6)
    assert np.mean(matching(alike, alike, 0, 3000)) < 0.3


def test_a_feature_that_does_not_differ_is_not_attended_to() -> None:
    stiff = [Features(f.ln_intensity, f.pattern, f.ln_period, f.irregularity, 6.0) for f in BY_HAND]
    own = [Features(f.ln_intensity, f.pattern, f.ln_period, f.irregularity, float(n)) for n, f in enumerate(BY_HAND)]
    assert matching(own, stiff, 5, 500) == matching(BY_HAND, BY_HAND, 5, 500)
