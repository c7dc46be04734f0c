"""The reaction time and the threshold are found from the beginnings and ends of reports."""

import pytest

from common.tenderness.reaction import REACTIONS_S, ReactionTime
from tests.unit.common.tenderness.made import finder, press


def learned(reaction_s, presses=4, **how):
    found, reaction = finder(), ReactionTime()
    for number in range(presses):
        press(found, start_s=20.0 * number, level_n=4.0, threshold_n=2.0, reaction_s=reaction_s, **how)
        reaction.learn(found.presses[-1])
    return found, reaction


def test_without_a_report_every_reaction_time_is_possible():
    reaction = ReactionTime()
    assert reaction.mean_s == pytest.approx(0.75)
    assert reaction.sd_s == pytest.approx(0.27, abs=0.01)
    assert reaction.probabilities.sum() == pytest.approx(1.0)
    assert (REACTIONS_S[0], REACTIONS_S[-1]) == (0.3, 1.2)


@pytest.mark.parametrize("reaction_s", [0.35, 0.6, 0.9, 1.15])
def test_a_reaction_time_is_found_with_its_uncertainty(reaction_s):
    _, reaction = learned(reaction_s, presses=8)
    assert reaction.sd_s < 0.5 * ReactionTime().sd_s
    assert abs(reaction.mean_s - reaction_s) < 0.05 + 2.0 * reaction.sd_s


def test_the_threshold_is_the_force_one_reaction_time_before_the_report():
    found, reaction = learned(0.9)
    low_n, middle_n, high_n = (reaction.threshold_n(found.presses[-1], share) for share in (0.1, 0.5, 0.9))
    assert low_n <= middle_n <= high_n
    assert middle_n == pytest.approx(2.0, abs=0.15)


def test_of_several_fingers_the_lightest_that_touches_sets_the_threshold():
    found, reaction = learned(0.6, lightly_n=0.8)
    assert reaction.threshold_n(found.presses[-1], 0.5) == pytest.approx(0.8, abs=0.01)
    found, reaction = learned(0.6, lightly_n=0.1)
    assert reaction.threshold_n(found.presses[-1], 0.5) == pytest.approx(2.0, abs=0.15), "it does not touch"


def test_a_report_before_which_nothing_touched_has_no_threshold():
    found, reaction = learned(0.6, presses=1)
    (one,) = found.presses
    one.risen_s = one.time_s[0]
    assert reaction.threshold_n(one, 0.5) == 0.0


def test_one_report_that_ends_late_does_not_mislead():
    found, reaction = learned(0.6, presses=6)
    one = found.presses[-1]
    one.fallen_s += 1.0
    before_s = reaction.mean_s
    reaction.learn(one)
    assert reaction.mean_s == pytest.approx(before_s, abs=0.1)
