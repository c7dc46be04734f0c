"""Times at which grooves are felt: each once, in order, as far behind the hand as the one before it."""

import time
from collections import deque

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.wire.messages import MAX_EVENTS, Event, EventKind
from operator_site.vibration.grooves import LONGEST_WAIT_S, MEMORY_S, GrooveTiming
from operator_site.vibration.vibration import PlayedEvents

TICK_S = 0.002
START_S = 100.0


def groove(ident: int, hand_s: float, finger: int = 1) -> Event:
    return Event(ident, EventKind.GROOVE, finger, 1, round(hand_s * 1e9), 400.0)


def felt(crossed_s: list[float], came_s: list[float], until_s: float) -> dict[int, float]:
    """When each groove is felt, by its number, that was crossed and then came at these times."""
    timing, times, coming = GrooveTiming(), dict[int, float](), deque(enumerate(came_s))
    for tick in range(round((until_s - START_S) / TICK_S)):
        t_s, fresh = START_S + tick * TICK_S, []
        while coming and coming[0][1] <= t_s:
            number, _ = coming.popleft()
            fresh.append(groove(number, crossed_s[number]))
        for event in timing.step(t_s, fresh):
            assert event.ident not in times
            times[event.ident] = t_s
    return times


@pytest.mark.parametrize("seed", range(4))
def test_a_regular_grating_stays_one_over_a_jittering_lossy_link(seed: int) -> None:
    rng = np.random.default_rng(seed)
    crossed = [START_S + 0.1 + 0.070 * n for n in range(100)]
    ready = np.array(crossed) + 0.020 + rng.uniform(0.0, 0.012, len(crossed))
    lost = rng.random(len(crossed)) < 0.1
    came = list(np.maximum.accumulate(ready + lost * 0.020))
    at = felt(crossed, came, START_S + 8.0)
    assert list(at) == list(range(100))
    felt_s, came_s = np.diff([at[n] for n in range(30, 100)]), np.diff(came[30:])
    assert np.mean(np.abs(felt_s - 0.070) < 2.1 * TICK_S) > 0.9
    assert np.mean(np.abs(came_s - 0.070) < 2.1 * TICK_S) < 0.75
    assert came_s.std() > 3.0 * felt_s.std()


def test_nothing_waits_where_nothing_is_late() -> None:
    crossed = [START_S + 0.1 + 0.070 * n for n in range(20)]
    at = felt(crossed, [t_s + 0.010 for t_s in crossed], START_S + 2.0)
    assert [at[n] - crossed[n] for n in range(20)] == pytest.approx([0.010] * 20, abs=TICK_S)


def test_a_very_late_groove_is_felt_at_once_and_delays_others_only_briefly() -> None:
    crossed = [START_S + 0.1 + 0.070 * n for n in range(90)]
    came = [t_s + (0.200 if n == 20 else 0.010) for n, t_s in enumerate(crossed)]
    came[20:] = list(np.maximum.accumulate(came[20:]))
    at = felt(crossed, came, START_S + 8.0)
    assert at[20] == pytest.approx(came[20], abs=TICK_S)
    assert max(at[n] - max(came[n], crossed[n] + 0.010) for n in range(90)) <= LONGEST_WAIT_S + TICK_S
    forgotten = next(n for n in range(90) if crossed[n] > came[20] + MEMORY_S)
    assert at[forgotten] - crossed[forgotten] == pytest.approx(0.010, abs=TICK_S)


def test_a_tap_waits_for_nothing_and_earlier_grooves_are_not_felt_after_it() -> None:
    timing = GrooveTiming()
    assert timing.step(1.050, [groove(1, 1.0)])  # 50 ms late: the pace
    assert timing.step(1.110, [groove(2, 1.1), groove(3, 1.1, finger=2)]) == []
    tap = Event(4, EventKind.TAP, 1, 1, round(1.11e9), 0.1)
    assert [event.ident for event in timing.step(1.112, [tap])] == [2, 4]
    assert [event.ident for event in timing.step(1.152, [])] == [3]


def test_without_a_time_of_the_hand_or_with_an_impossible_one_nothing_waits() -> None:
    timing = GrooveTiming()
    assert timing.step(1.050, [groove(1, 1.0)])
    strange = [groove(2, 0.0), groove(3, 50.0)]
    assert timing.step(9.0, strange) == strange


def test_grooves_that_wait_when_outputs_come_to_rest_are_never_felt() -> None:
    timing = GrooveTiming()
    assert timing.step(1.050, [groove(1, 1.0)])
    assert timing.step(1.110, [groove(2, 1.1)]) == []
    timing.clear()
    assert timing.step(1.5, []) == []


@pytest.mark.long
@given(
    gaps=st.lists(st.floats(0.002, 0.2), min_size=1, max_size=40),
    lates=st.lists(st.floats(0.0, 0.09), min_size=40, max_size=40),
    repeats=st.integers(1, 3),
)
def test_each_groove_is_felt_once_and_in_order_over_any_link(
    gaps: list[float], lates: list[float], repeats: int
) -> None:
    crossed = list(START_S + np.cumsum(gaps))
    came = list(np.maximum.accumulate([t_s + late_s for t_s, late_s in zip(crossed, lates, strict=False)]))
    played, timing, order = PlayedEvents(), GrooveTiming(), []
    end_s = came[-1] + 0.3
    for tick in range(round((end_s - START_S) / TICK_S)):
        t_s = START_S + tick * TICK_S
        events = [groove(n, crossed[n]) for n in range(len(came)) if t_s - repeats * TICK_S < came[n] <= t_s]
        order += [event.ident for event in timing.step(t_s, played.new(events))]
    assert order == list(range(len(came)))


@given(st.lists(st.tuples(st.integers(0, 900), st.lists(st.integers(0, 200), max_size=3)), max_size=60))
def test_the_delay_is_that_of_the_largest_and_the_smallest_recent_age(steps: list[tuple[int, list[int]]]) -> None:
    timing, t_s, ages, number = GrooveTiming(), START_S, list[tuple[float, float]](), 0
    for later_ms, ages_ms in steps:
        t_s += 1e-3 * later_ms
        fresh = [groove(number := number + 1, t_s - 1e-3 * age_ms) for age_ms in ages_ms]
        ages += [(t_s, age_s) for event in fresh if (age_s := t_s - event.hand_ns * 1e-9) >= 0.0]
        waited = timing.waits
        timing.step(t_s, fresh)
        ages = [(came_s, age_s) for came_s, age_s in ages if t_s - MEMORY_S <= came_s]
        recent = [age_s for _, age_s in ages]
        if recent and (fresh or waited):
            assert timing.behind_s == min(max(recent), min(recent) + LONGEST_WAIT_S)


def test_a_tick_costs_little_however_many_grooves_come() -> None:
    timing, number, t_s, worked_s = GrooveTiming(), 0, START_S, 0.0
    for _ in range(1600):
        t_s += TICK_S
        fresh = [groove(number := number + 1, t_s - 0.020 - 0.030 * (number % 2)) for _ in range(MAX_EVENTS)]
        began_s = time.process_time()
        timing.step(t_s, fresh)
        worked_s += time.process_time() - began_s
    assert worked_s < 1600 * 0.5 * TICK_S
