"""Forces and pain answers become presses, each with its own report."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.tenderness.presses import LATEST_S, LONGEST_S, PAINFUL, PressFinder
from tests.unit.common.tenderness.made import finder, press


def test_a_press_keeps_its_forces_its_place_and_its_report():
    found = finder()
    changed = press(found, start_s=10.0, level_n=3.0, threshold_n=2.0, reaction_s=0.6, x_m=0.01, y_m=0.02)
    (one,) = found.presses
    assert changed == [one, one], "a report begins and ends"
    assert one.painful
    assert one.risen_s == pytest.approx(12.6, abs=0.02)
    assert one.fallen_s > one.risen_s
    assert one.answer == 4.0
    assert one.peak_n[0] == pytest.approx(2.9, abs=0.02)
    assert (one.x_m[0], one.y_m[0]) == (0.01, 0.02)
    assert one.forces_n(np.array([12.0, 0.0, 99.0]))[:, 0] == pytest.approx([2.0, 0.0, 0.0], abs=0.03)


def test_a_press_without_pain_has_no_report():
    found = finder()
    assert press(found, start_s=0.0, level_n=1.0, threshold_n=2.0) == []
    assert [each.painful for each in found.presses] == [False]


def test_a_late_report_belongs_to_the_press_before_and_one_too_late_to_none():
    for late_s, painful in ((LATEST_S - 0.1, True), (LATEST_S + 0.1, False)):
        found = finder()
        for t_s in np.arange(0.0, 1.0, 0.01):
            found.step(float(t_s), [2.0], [0.0], [0.0], 0.0)
        found.step(1.0, [0.0], [0.0], [0.0], 0.0)
        touched = found.step(1.0 + late_s, [0.0], [0.0], [0.0], 3.0)
        assert (touched is not None) == painful
        assert found.presses[0].painful == painful


def test_a_report_before_any_press_belongs_to_none_and_its_end_too():
    found = finder()
    assert found.step(0.0, [0.0], [0.0], [0.0], 3.0) is None
    assert found.step(1.0, [0.0], [0.0], [0.0], 0.0) is None


def test_an_unknown_answer_changes_no_report():
    found = finder()
    for t_s in np.arange(0.0, 2.0, 0.01):
        found.step(float(t_s), [2.0], [0.0], [0.0], 4.0 if t_s > 1.0 else 0.0)
    assert found.step(2.0, [2.0], [0.0], [0.0], math.nan) is None
    assert math.isnan(found.presses[0].fallen_s)
    assert found.step(2.1, [2.0], [0.0], [0.0], 6.0) is None
    assert found.presses[0].answer == 6.0


def test_a_long_press_is_split_and_old_presses_are_dropped():
    found = finder(3)
    for t_s in np.arange(0.0, 5.5 * LONGEST_S, 0.1):
        found.step(float(t_s), [2.0], [0.0], [0.0], 0.0)
    assert len(found.presses) == 3
    assert all(each.time_s[-1] - each.time_s[0] <= LONGEST_S + 0.2 for each in found.presses)


_SAMPLES = st.lists(
    st.tuples(st.floats(0.001, 1.0), st.floats(0.0, 5.0), st.sampled_from([0.0, 1.0, 10.0, math.nan])), max_size=200
)


@given(_SAMPLES)
def test_every_report_begins_within_the_reaction_times_of_its_press(samples):
    found, t_s = PressFinder(1000), 0.0
    for dt_s, force_n, answer in samples:
        t_s += dt_s
        found.step(t_s, [force_n], [0.0], [0.0], answer)
    for each in found.presses:
        assert each.time_s == sorted(each.time_s)
        assert each.peak_n[0] == max(each.peak_n[0], *(force for (force,) in each.force_n))
        if each.painful:
            assert each.answer >= PAINFUL
            assert each.risen_s > each.time_s[0]
            assert not each.fallen_s < each.risen_s
