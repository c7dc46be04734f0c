"""The time at which the operator's hand was over a place, for any delay to the remote site."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from remote_site.devices.sensor_frame import HandPlace
from remote_site.identification.touch_events import KEPT_S, MOST, NEAR_M, HandPath

MS = 1_000_000
START_NS = 5_000_000_000


def stroked(hand: HandPath, speed_m_s: float, seconds: float) -> None:
    for ms in range(0, round(1e3 * seconds), 2):
        hand.step(HandPlace(START_NS + ms * MS, 1e-3 * ms * speed_m_s, 0.02))


@pytest.mark.parametrize("lost", [0.0, 0.5])
def test_the_time_of_a_place_is_interpolated_between_two_packets(lost: float) -> None:
    hand, rng = HandPath(), np.random.default_rng(1)
    for ms in range(0, 400, 2):
        if rng.random() >= lost:
            hand.step(HandPlace(START_NS + ms * MS, 1e-4 * ms, 0.02))
    assert hand.when_ns(0.0301, 0.02) == pytest.approx(START_NS + 301 * MS, abs=1000)


def test_after_a_turn_the_pass_with_the_delay_of_earlier_grooves_counts() -> None:
    """To and fro at 100 mm/s, followed 60 ms late: each place is passed twice within 0.2 s."""
    hand = HandPath()
    place = [1e-4 * (ms % 200 if ms % 400 < 200 else 200 - ms % 200) for ms in range(2000)]
    for ms in range(0, 2000, 2):
        hand.step(HandPlace(START_NS + ms * MS, place[ms], 0.0))
        late = ms - 60
        if late > 200 and late % 10 == 0 and late % 200 not in (0, 10, 190):
            assert hand.when_ns(place[late], 0.0) == pytest.approx(START_NS + late * MS, abs=MS)


def test_a_hand_that_rests_was_there_until_now() -> None:
    hand = HandPath()
    stroked(hand, 0.0, 0.3)
    assert hand.when_ns(0.0, 0.02) == pytest.approx(START_NS + 298 * MS, abs=2 * MS)


def test_where_the_hand_never_was_the_newest_motion_counts() -> None:
    hand = HandPath()
    stroked(hand, 0.1, 0.2)
    assert hand.when_ns(0.01, 0.02 + 1.1 * NEAR_M) == START_NS + 198 * MS


def test_a_path_is_bounded_when_its_clock_hardly_moves() -> None:
    hand = HandPath()
    hand.step(HandPlace(START_NS, 0.5, 0.0))
    for ns in range(1, 5 * MOST):
        hand.step(HandPlace(START_NS + ns, 0.0, 0.0))
        if ns == MOST - 1:
            assert hand.when_ns(0.5, 0.0) == START_NS
    assert hand.when_ns(0.5, 0.0) == START_NS + 5 * MOST - 1


def test_the_path_is_whole_over_any_length() -> None:
    hand, kept = HandPath(), round(KEPT_S / 0.001)
    for ms in range(6 * MOST):
        hand.step(HandPlace(START_NS + ms * MS, 1e-4 * ms, 0.0))
        if ms >= kept and ms % 97 == 0:
            earliest = ms - kept + 1
            assert hand.when_ns(1e-4 * earliest, 0.0) == pytest.approx(START_NS + earliest * MS, abs=1000)


def test_an_empty_path_gives_no_time() -> None:
    hand = HandPath()
    assert hand.when_ns(0.0, 0.0) == 0
    stroked(hand, 0.1, 0.2)
    hand.step(None)
    assert hand.when_ns(0.01, 0.02) == 0


@given(st.lists(st.tuples(st.integers(0, 2**62), st.floats(-0.7, 0.7), st.floats(-0.7, 0.7)), max_size=30))
def test_any_motion_gives_a_time_of_its_own_last_moments(places: list[tuple[int, float, float]]) -> None:
    hand = HandPath()
    for time_ns, x_m, y_m in places:
        hand.step(HandPlace(time_ns, x_m, y_m))
        found_ns = hand.when_ns(0.0, 0.0)
        assert time_ns - KEPT_S * 1e9 - 1e4 <= found_ns <= time_ns
