"""The patient's pain lowers the force limit, and nothing but a person raises it again."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.limits import PAIN_LEAST_N, PAIN_SHARE
from common.tenderness.presses import LONGEST_S
from common.tenderness.reaction import ReactionTime
from remote_site.safety.pain_limit import PainLimit
from tests.unit.common.tenderness.made import press


class Recorded(PainLimit):
    """Keeps every limit."""

    def __init__(self):
        super().__init__()
        self.limits_n = []

    def step(self, *values):
        super().step(*values)
        self.limits_n.append(self.limit_n)


def test_no_pain_no_limit():
    limit = Recorded()
    press(limit, start_s=0.0, level_n=3.0, threshold_n=4.0)
    assert set(limit.limits_n) == {math.inf}


def test_the_limit_follows_the_patients_threshold():
    limit = Recorded()
    press(limit, start_s=0.0, level_n=4.0, threshold_n=2.0, reaction_s=0.6)
    reported_n, ended_n = dict.fromkeys(limit.limits_n).keys() - {math.inf}, limit.limit_n
    assert max(reported_n) > ended_n, "at the report the reaction time is not known yet"
    assert max(reported_n) <= PAIN_SHARE * 2.6, "it is below the force at the report"
    assert ended_n == pytest.approx(PAIN_SHARE * 2.0, abs=0.2)
    assert limit.reaction.sd_s < ReactionTime().sd_s, "the end has shown it"


def test_a_higher_threshold_does_not_raise_it_and_a_lower_one_lowers_it():
    limit = Recorded()
    press(limit, start_s=0.0, level_n=4.0, threshold_n=2.0)
    before_n = limit.limit_n
    press(limit, start_s=20.0, level_n=4.0, threshold_n=3.0)
    assert limit.limit_n == before_n
    press(limit, start_s=40.0, level_n=4.0, threshold_n=1.0)
    assert limit.limit_n < before_n


def test_the_lowest_limit_still_finds_the_surface():
    limit = PainLimit()
    press(limit, start_s=0.0, level_n=1.0, threshold_n=0.35)
    assert limit.limit_n == PAIN_LEAST_N


def test_pain_that_lasts_during_a_press_lowers_it_again_and_again():
    limit, limits_n = PainLimit(), []
    for tick in range(1000):
        t_s = 0.01 * tick
        limit.step(t_s, [1.5], [0.0], [0.0], 4.0 if t_s > 2.0 else 0.0)
        limits_n.append(limit.limit_n)
    assert limits_n[250] == pytest.approx(PAIN_SHARE * 1.5)
    assert limits_n[330] == pytest.approx(PAIN_SHARE**2 * 1.5)
    assert limits_n[-1] == PAIN_LEAST_N
    assert limits_n == sorted(limits_n, reverse=True)


def test_reports_keep_place_threshold_and_answer():
    limit = PainLimit()
    press(limit, start_s=0.0, level_n=4.0, threshold_n=2.0, reaction_s=0.6, x_m=0.01, y_m=0.02, lightly_n=0.1)
    (report,) = limit.reports
    assert (report.x_m, report.y_m, report.answer) == (0.01, 0.02, 4.0)
    assert report.threshold_n == pytest.approx(2.0, abs=0.25)


def test_only_an_act_ends_it():
    limit = PainLimit()
    press(limit, start_s=0.0, level_n=4.0, threshold_n=2.0)
    mean_s = limit.reaction.mean_s
    limit.end()
    assert limit.limit_n == math.inf
    assert limit.reaction.mean_s == mean_s


@given(
    st.lists(
        st.tuples(st.floats(0.001, 1.0), st.floats(0.0, 5.0), st.sampled_from([0.0, 1.0, 10.0, math.nan])),
        max_size=200,
    )
)
def test_whatever_happens_the_limit_never_rises(samples):
    limit, t_s, before_n = PainLimit(), 0.0, math.inf
    for dt_s, force_n, answer in samples:
        t_s += dt_s
        limit.step(t_s, [force_n, 0.5 * force_n], [0.0, 0.02], [0.0, 0.0], answer)
        assert PAIN_LEAST_N <= limit.limit_n <= before_n
        before_n = limit.limit_n


def pressed(limit, force_n, pain, seconds=30.0):
    """Step with a force and an answer of each time, s; return the last limit."""
    for tick in range(round(100 * seconds)):
        t_s = 0.01 * tick
        limit.step(t_s, [force_n(t_s)], [0.0], [0.0], pain(t_s))
    return limit.limit_n


def test_pain_that_lasts_beyond_a_split_of_the_press_lowers_it_again():
    assert pressed(PainLimit(), lambda t_s: 2.0, lambda t_s: 4.0 * (t_s > LONGEST_S - 0.5)) == PAIN_LEAST_N


def test_a_report_that_is_too_early_for_its_press_lowers_it_too():
    limit = PainLimit()
    assert pressed(limit, lambda t_s: 3.0, lambda t_s: 6.0 * (t_s > 0.2), 1.0) == pytest.approx(PAIN_SHARE * 3.0)
    assert pressed(PainLimit(), lambda t_s: 3.0, lambda t_s: 6.0 * (t_s > 0.2)) == PAIN_LEAST_N


def test_a_report_that_is_too_early_and_lasts_until_no_finger_presses_sets_the_lowest_limit():
    def force_n(t_s):
        return 3.0 if t_s < 0.15 else 0.2

    assert pressed(PainLimit(), force_n, lambda t_s: 6.0 * (t_s > 0.2), 1.0) == PAIN_LEAST_N


def test_of_several_fingers_the_lightest_counts_in_a_report_that_is_too_early_too():
    limit = PainLimit()
    for tick in range(100):
        limit.step(0.01 * tick, [3.0, 1.0, 0.1], [0.0] * 3, [0.0] * 3, 6.0 * (tick > 20))
    assert limit.limit_n == pytest.approx(PAIN_SHARE * 1.0)


def test_a_second_report_during_one_press_lowers_it_again():
    def pain(t_s):
        return 4.0 * (3.0 < t_s < 3.5 or t_s > 8.0)

    once_n, twice_n = (pressed(PainLimit(), lambda t_s: 1.5, pain, seconds) for seconds in (7.9, 8.1))
    assert twice_n == pytest.approx(PAIN_SHARE * once_n)


def test_the_next_press_lowers_it_while_the_pain_of_an_earlier_one_is_still_reported():
    def force_n(t_s):
        return 0.0 if 4.0 < t_s < 8.0 else 2.0

    lifted_n, again_n = (pressed(PainLimit(), force_n, lambda t_s: 4.0 * (t_s > 3.0), s) for s in (7.9, 8.1))
    assert again_n == pytest.approx(PAIN_SHARE * lifted_n)


def test_more_pain_than_before_every_press_lowers_it_until_it_is_as_before():
    def force_n(t_s):
        return 2.0 if 5.0 < t_s < 9.0 else 0.0

    def pain(t_s):
        return 6.0 if 7.0 < t_s < 9.5 else 3.0

    limit = PainLimit()
    assert pressed(limit, force_n, pain, 7.1) == pytest.approx(PAIN_SHARE * 2.0)
    lowered_n = pressed(limit := PainLimit(), force_n, pain, 9.4)
    assert lowered_n == pytest.approx(PAIN_SHARE**2 * 2.0), "once more 1.2 s later"
    (report,) = limit.reports
    assert report.answer == 6.0
    assert pressed(PainLimit(), lambda t_s: max(force_n(t_s), 1.0 * (t_s > 12.0)), pain) == lowered_n


def test_pain_from_before_every_press_says_nothing_about_a_press():
    assert pressed(PainLimit(), lambda t_s: 2.0 * (t_s > 5.0), lambda t_s: 3.0) == math.inf
