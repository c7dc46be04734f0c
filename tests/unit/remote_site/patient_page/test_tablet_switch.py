"""The switch on a tablet: silent unless the page answers in time, and a press is never lost."""

import contextlib
import json
import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.limits import SWITCH_HOLD_S, SWITCH_SILENCE_S
from remote_site.patient_page.tablet_switch import MAX_TEXT, BadAnswer, PageAnswer, TabletSwitch

NOW_S = 100.0


def answer(at_s: float, *, pressed: bool = False, pain: int = 0) -> PageAnswer:
    return PageAnswer(at_s, pressed, pain)


def test_it_is_silent_before_the_first_answer_and_after_the_last() -> None:
    switch = TabletSwitch(slider=True)
    assert switch.report(NOW_S) is None
    switch.take(answer(NOW_S - 0.02), NOW_S)
    found = switch.report(NOW_S)
    assert found is not None
    assert (found.closed, found.pain_permille) == (True, 0)
    last_s = NOW_S - 0.02 + SWITCH_SILENCE_S
    assert switch.report(last_s - 0.001) is not None
    assert switch.report(last_s + 0.001) is None


def test_a_late_answer_is_no_sign_of_life_and_its_press_counts() -> None:
    switch = TabletSwitch(slider=False)
    switch.take(answer(NOW_S - SWITCH_SILENCE_S - 0.001), NOW_S)
    assert switch.report(NOW_S) is None
    switch.take(answer(NOW_S - 5.0, pressed=True), NOW_S)
    found = switch.report(NOW_S)
    assert found is not None
    assert (found.closed, found.pain_permille) == (False, None)


def test_a_press_is_reported_for_its_time_even_if_the_page_is_gone() -> None:
    switch = TabletSwitch(slider=False)
    switch.press(NOW_S)
    for after_s in (0.0, 0.5 * SWITCH_HOLD_S, SWITCH_HOLD_S - 0.001):
        found = switch.report(NOW_S + after_s)
        assert found is not None
        assert not found.closed
    assert switch.report(NOW_S + SWITCH_HOLD_S + 0.001) is None


def test_an_answer_to_the_future_and_an_older_one_move_nothing() -> None:
    switch = TabletSwitch(slider=True)
    switch.take(answer(NOW_S + 1.0, pain=7), NOW_S)
    assert switch.report(NOW_S) is None
    switch.take(answer(NOW_S - 0.01, pain=3), NOW_S)
    switch.take(answer(NOW_S - 0.05, pain=9), NOW_S)
    assert switch.pain == 3


@given(
    st.lists(st.tuples(st.floats(0.0, 0.3), st.floats(0.0, 0.5), st.booleans(), st.integers(0, 10)), max_size=30),
)
def test_closed_is_only_reported_on_a_fresh_answer_without_a_recent_press(
    answers: list[tuple[float, float, bool, int]],
) -> None:
    switch, now_s = TabletSwitch(slider=True), NOW_S
    asked_s, pressed_s = -math.inf, -math.inf
    for wait_s, age_s, pressed, pain in answers:
        now_s += wait_s
        report = switch.report(now_s)
        if report is not None and report.closed:
            assert now_s - asked_s <= SWITCH_SILENCE_S
            assert now_s - pressed_s > SWITCH_HOLD_S
        switch.take(answer(now_s - age_s, pressed=pressed, pain=pain), now_s)
        asked_s, pressed_s = max(asked_s, now_s - age_s), now_s if pressed else pressed_s
        if pressed:
            found = switch.report(now_s)
            assert found is not None
            assert not found.closed


@given(st.floats(allow_nan=False, allow_infinity=False), st.booleans(), st.integers(0, 10))
def test_a_whole_answer_is_read(at_s: float, pressed: bool, pain: int) -> None:
    text = json.dumps({"at_s": at_s, "pressed": pressed, "pain": pain})
    assert PageAnswer.decode(text) == PageAnswer(at_s, pressed, pain)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[]",
        "{}",
        "null",
        "[" * MAX_TEXT,
        " " * (MAX_TEXT + 1),
        '{"at_s": 1, "pressed": false}',
        '{"at_s": 1, "pressed": false, "pain": 0, "more": 1}',
        '{"at_s": NaN, "pressed": false, "pain": 0}',
        '{"at_s": true, "pressed": false, "pain": 0}',
        '{"at_s": "1", "pressed": false, "pain": 0}',
        '{"at_s": 1, "pressed": 0, "pain": 0}',
        '{"at_s": 1, "pressed": false, "pain": 11}',
        '{"at_s": 1, "pressed": false, "pain": -1}',
        '{"at_s": 1, "pressed": false, "pain": 1.5}',
        '{"at_s": 1, "pressed": false, "pain": true}',
    ],
)
def test_anything_else_is_a_bad_answer(text: str) -> None:
    with pytest.raises(BadAnswer):
        PageAnswer.decode(text)


@given(st.text())
def test_any_text_is_an_answer_or_a_bad_one(text: str) -> None:
    with contextlib.suppress(BadAnswer):
        PageAnswer.decode(text)
