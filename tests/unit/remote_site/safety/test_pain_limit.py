"""The patient's pain lowers the force limit, and nothing but a person raises it again."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.limits import PAIN_LEAST_N, PAIN_SHARE
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
