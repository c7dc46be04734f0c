import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.link.clock_offset import DRIFT, WINDOW, ClockOffset

delay = st.integers(0, 300_000_000)
trips = st.lists(st.tuples(st.integers(1, 60_000_000_000), delay, delay, delay), min_size=1, max_size=100)


@given(st.integers(-(10**17), 10**17), trips)
def test_the_true_offset_is_within_the_uncertainty_for_any_two_delays(
    offset_ns: int, rounds: list[tuple[int, int, int, int]]
) -> None:
    clock, now = ClockOffset(), 10**18
    for pause, there, stay, back in rounds:
        t1 = now + pause
        now = t1 + there + stay + back
        clock.add(t1, t1 + there + offset_ns, t1 + there + stay + offset_ns, now)
        assert clock.uncertainty_ns is not None
        assert abs(clock.offset_ns - offset_ns) <= clock.uncertainty_ns
        assert clock.round_trip_ns == there + back


@given(st.integers(-(10**12), 10**12), st.sampled_from([-DRIFT, DRIFT, DRIFT / 3]), trips)
def test_the_offset_stays_within_the_uncertainty_under_drift(
    offset_ns: int, drift: float, rounds: list[tuple[int, int, int, int]]
) -> None:
    def far(near_ns: int) -> int:
        return near_ns + offset_ns + int(near_ns * drift)

    clock, now = ClockOffset(), 0
    for pause, extra, stay, back in rounds:
        t1 = now + pause
        there = 50_000 + extra  # no way is shorter than what the clocks drift apart during the stay
        now = t1 + there + stay + back
        clock.add(t1, far(t1 + there), far(t1 + there + stay), now)
        assert clock.uncertainty_ns is not None
        assert abs(clock.offset_ns - (far(now) - now)) <= clock.uncertainty_ns + 2  # far() rounds


def test_one_fast_round_trip_is_remembered_until_it_leaves_the_window() -> None:
    clock = ClockOffset()
    clock.add(0, 1000, 1000, 2000)
    second = 10**6
    for n in range(WINDOW - 1):
        start = 10**6 * (n + 1)
        clock.add(start, start + 500_000, start + 500_000, start + second)
    assert clock.uncertainty_ns is not None
    assert clock.uncertainty_ns < 10_000
    clock.add(10**9, 10**9 + 500_000, 10**9 + 500_000, 10**9 + second)
    assert clock.uncertainty_ns >= 500_000


@pytest.mark.parametrize("times", [(10, 0, 0, 9), (0, 5, 4, 20), (0, 0, 30, 20)])
def test_times_that_run_backwards_are_refused(times: tuple[int, int, int, int]) -> None:
    clock = ClockOffset()
    with pytest.raises(ValueError, match="impossible round trip"):
        clock.add(*times)
    assert clock.uncertainty_ns is None


def test_a_clock_that_was_stepped_is_found_by_the_next_measurement() -> None:
    clock = ClockOffset()
    for number, offset_ns in enumerate((0, 0, 10**10, 10**10, 0)):
        t1 = 10**15 + 50_000_000 * number
        arrived = t1 + 500_000 + offset_ns
        clock.add(t1, arrived, arrived, t1 + 1_000_000)
        assert clock.offset_ns == offset_ns
    assert clock.steps == 2


def test_measurements_from_before_both_clocks_were_set_back_count_no_more() -> None:
    clock = ClockOffset()
    for begin_ns in (10**15, 10**14):
        for t1 in range(begin_ns, begin_ns + 10**9, 50_000_000):
            clock.add(t1, t1 + 500_000, t1 + 500_000, t1 + 1_000_000)
            assert clock.uncertainty_ns is not None
            assert 500_000 <= clock.uncertainty_ns <= 510_000
    assert clock.steps == 1
