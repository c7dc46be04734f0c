"""A touch is sent when a column changes by its step, or a text, an event or a state changes."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.link.deadband import HEIGHT_M, PLANE_M, TOUCH_STEPS, motion_perceptible, touch_perceptible
from common.wire.messages import NO_TOUCH, TOUCH_FIELDS, TOUCH_RANGES, Event, EventKind, MotionRow, Touch, pack_rows
from common.wire.packets import LinkState

INDEX = 1
TAP = Event(7, EventKind.TAP, INDEX, 10, 5, 0.1)


def touch(
    state: LinkState = LinkState.ENGAGED,
    materials: tuple[str, ...] = ("",) * 5,
    events: tuple[Event, ...] = (),
    **values: float,
) -> Touch:
    """A touch of the index finger."""
    rows = [NO_TOUCH._replace(**values) if finger == INDEX else NO_TOUCH for finger in range(5)]
    return Touch(1, 1, 1, state, pack_rows(rows), materials, events)


def test_an_equal_touch_is_not_sent_and_neither_is_the_end_of_old_events() -> None:
    assert not touch_perceptible(touch(), touch())
    assert not touch_perceptible(touch(events=(TAP,)), touch())
    assert not touch_perceptible(touch(events=(TAP,)), touch(events=(TAP,)))


def test_changes_of_state_names_texts_and_events_are_sent_at_once() -> None:
    for name in ("mode", "contact", "thermal_status"):
        assert touch_perceptible(touch(), touch(**{name: 1.0}))
        assert touch_perceptible(touch(**{name: 1.0}), touch())
    assert touch_perceptible(touch(), touch(state=LinkState.FAULT))
    assert touch_perceptible(touch(), touch(materials=("", "pvc", "", "", "")))
    assert touch_perceptible(touch(), touch(events=(TAP,)))
    assert touch_perceptible(touch(events=(TAP,)), touch(events=(TAP, TAP._replace(ident=8))))
    assert touch_perceptible(touch(events=(TAP,)), touch(events=(TAP._replace(ident=8),)))


@given(st.sampled_from(sorted(TOUCH_STEPS)), st.floats(1e-3, 1.0), st.floats(-2.0, 2.0))
def test_a_number_is_sent_exactly_when_it_differs_by_more_than_its_step(name: str, at: float, times: float) -> None:
    assert tuple(TOUCH_STEPS) == TOUCH_FIELDS, "every column has its step"
    low, high = TOUCH_RANGES[name]
    share, least = TOUCH_STEPS[name]
    was = low + at * (high - low)
    step = max(least, share * abs(was))
    now = was + times * step
    if low <= now <= high and step > 0.0 and abs(abs(times) - 1.0) > 0.01:
        assert touch_perceptible(touch(**{name: was}), touch(**{name: now})) is (abs(times) > 1.0)


@pytest.mark.parametrize(("column", "step_m"), [(0, PLANE_M), (1, PLANE_M), (2, HEIGHT_M)])
@pytest.mark.parametrize("finger", range(5))
def test_motion_counts_in_any_direction_of_any_finger(finger: int, column: int, step_m: float) -> None:
    expected = [MotionRow(0.0, 0.0, 0.0)] * 5
    for share in (-1.01, -0.99, 0.99, 1.01):
        true = np.zeros((5, 3))
        true[finger, column] = share * step_m
        assert motion_perceptible(expected, [MotionRow(*row) for row in true.tolist()]) is (abs(share) > 1.0)
