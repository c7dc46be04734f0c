"""A telemanipulator that does not obey is found at its margins and times, one place at a time."""

import math
from collections.abc import Sequence

import pytest

from common.faults.texts import fault_text
from common.fingers import FINGERS
from remote_site.safety.following_error import (
    FRESH_S,
    HEIGHT_MARGIN_M,
    PERSIST_S,
    PLANE_MARGIN_M,
    STOPPING_S,
    FollowingError,
)
from remote_site.safety.servo import LONGEST_TICK_S, SERVO_N_M
from remote_site.safety.sliding_extrema import MEMORY_S

DT = 0.95 * LONGEST_TICK_S
NAMES = ("hand's x", "hand's y", *FINGERS)
HERE, IN_THE_AIR = (0.0,) * 7, (0.0,) * 5
MARGINS_M = (PLANE_MARGIN_M,) * 2 + (HEIGHT_MARGIN_M,) * 5


def place(number: int, value_m: float) -> list[float]:
    return [value_m if number == i else 0.0 for i in range(7)]


def pressing(number: int, force_n: float) -> list[float]:
    return place(number, force_n)[2:]


def sent(place_m: Sequence[float] = HERE, released: bool = False) -> FollowingError:
    """One that was sent to a place."""
    follow = FollowingError()
    assert follow.step(PERSIST_S, 0.0, place_m, IN_THE_AIR) is None
    follow.commanded(0.0, place_m, released)
    return follow


def found(follow: FollowingError, place_m: Sequence[float], force_n: Sequence[float] = IN_THE_AIR) -> str:
    """The text of what is wrong with a place after PERSIST_S, and not earlier; empty when nothing is."""
    doubt_s = 0.0
    for _ in range(10):
        assert follow.step(DT, 0.0, place_m, force_n) is None
        doubt_s += DT
    return fault_text(follow.step(PERSIST_S - doubt_s, 0.0, place_m, force_n))


@pytest.mark.parametrize("number", range(7))
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_each_place_may_be_off_by_its_margin_and_no_more(number: int, sign: float) -> None:
    margin_m = MARGINS_M[number]
    assert found(sent(), place(number, sign * margin_m)) == ""
    off = f"{NAMES[number]}: does not obey: {1e3 * margin_m + 1.0:.1f} mm off its set-points"
    wrong = found(sent(), place(number, sign * (margin_m + 0.001)))
    assert wrong == f"telemanipulator: {off}, at most {1e3 * margin_m:.1f} mm"


@pytest.mark.parametrize("number", range(7))
def test_a_place_is_judged_by_the_range_of_its_set_points(number: int) -> None:
    margin_m = MARGINS_M[number]
    for is_m, wrong in ((-margin_m, False), (0.02 + margin_m, False), (0.0201 + margin_m, True), (0.1, True)):
        follow = sent()
        follow.commanded(MEMORY_S, place(number, 0.02), False)
        assert bool(found(follow, place(number, is_m))) == wrong
    follow = sent()
    follow.commanded(1.01 * MEMORY_S, place(number, 0.02), False)
    assert "20.0 mm off its set-points" in found(follow, HERE)


@pytest.mark.parametrize("number", range(7))
def test_a_force_bends_its_own_finger_upwards_only(number: int) -> None:
    bent_m = 2.0 / SERVO_N_M
    for pressed in range(2, 7):
        force_n = pressing(pressed, 2.0)
        own_m = bent_m if pressed == number else 0.0
        assert found(sent(), place(number, MARGINS_M[number] + own_m), force_n) == ""
        assert "5.0 mm off its set-points" in found(sent(), place(number, 0.005 + own_m), force_n)
        assert found(sent(), place(number, -MARGINS_M[number] - 1e-6), force_n)
        assert found(sent(), place(number, MARGINS_M[number] + 1e-6), pressing(pressed, -2.0))
        assert found(sent(), place(number, -MARGINS_M[number]), pressing(pressed, -2.0)) == ""


def test_an_unused_finger_may_stand_anywhere_and_the_hand_may_not() -> None:
    for number in range(7):
        for absent in range(5):
            follow, taking_part = sent(), [finger != absent for finger in range(5)]
            for _ in range(12):
                wrong = follow.step(DT, 0.0, place(number, 0.1), IN_THE_AIR, taking_part)
            assert (wrong is None) == (number == absent + 2)


def test_the_first_place_that_is_off_is_named() -> None:
    for number in range(7):
        is_m = [-margin_m if i < number else 0.5 for i, margin_m in enumerate(MARGINS_M)]
        assert f"{NAMES[number]}: does not obey: 500.0 mm off its set-points" in found(sent(), is_m)


def test_places_and_forces_of_another_length_are_refused() -> None:
    off = place(6, 0.5)
    for wrong in ((HERE[1:], IN_THE_AIR), (off, IN_THE_AIR[1:]), (off, IN_THE_AIR, (True,) * 4)):
        with pytest.raises(ValueError, match="zip"):
            sent().step(DT, 0.0, *wrong)
    with pytest.raises(ValueError, match="zip"):
        sent().commanded(DT, HERE[1:], False)
    for forces in (IN_THE_AIR[1:], (*IN_THE_AIR, 0.0)):
        follow = sent()
        follow.step(DT, 1.0, HERE, forces)
        with pytest.raises(ValueError, match="zip"):
            follow.commanded(DT, HERE, True)


def test_only_fresh_reports_count_and_a_good_one_restarts_the_count() -> None:
    off = place(0, 0.1)
    follow = sent()
    for _ in range(10):
        assert follow.step(DT, FRESH_S, off, IN_THE_AIR) is None
    for age_s in (math.nextafter(FRESH_S, 1.0), 1.0):
        assert follow.step(DT, age_s, off, IN_THE_AIR) is None
    assert follow.step(DT, FRESH_S, off, IN_THE_AIR) is not None
    assert follow.step(DT, 1.0, off, IN_THE_AIR) is None
    for good, force_n in ((HERE, IN_THE_AIR), (place(2, 0.003), pressing(2, 2.0))):
        assert follow.step(DT, 0.0, off, IN_THE_AIR) is not None
        assert follow.step(DT, 0.0, good, force_n) is None
        assert found(follow, off)


def test_after_a_pause_one_report_counts_as_one_tick() -> None:
    follow = sent()
    for _ in range(9):
        assert follow.step(1.0, 0.0, place(0, 0.1), IN_THE_AIR) is None
    follow.step(1.0, 0.0, place(0, 0.1), IN_THE_AIR)
    assert follow.step(1.0, 0.0, place(0, 0.1), IN_THE_AIR) is not None


def test_nothing_is_wrong_before_the_first_set_point() -> None:
    assert found(FollowingError(), place(0, 9.0)) == ""


def release(follow: FollowingError, begin_s: float, rest_m: Sequence[float], force_n: Sequence[float]) -> None:
    """Let go, come to rest at a place after STOPPING_S, and stay there as long as set-points are remembered."""
    for t_s, is_m in ((begin_s, HERE), (begin_s + 0.99 * STOPPING_S, rest_m), (begin_s + STOPPING_S, place(0, 0.5))):
        follow.step(DT, 1.0, is_m, force_n)
        follow.commanded(t_s, HERE, True)
    follow.commanded(begin_s + STOPPING_S + 1.01 * MEMORY_S, HERE, True)


@pytest.mark.parametrize("number", range(7))
@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_released_hand_stays_at_its_place_of_rest(number: int, sign: float) -> None:
    rest_m, follow = place(number, 0.02 * sign), sent()
    for begin_s in (1.0, 5.0):
        release(follow, begin_s, rest_m, IN_THE_AIR)
        expected_m = rest_m if number < 2 or sign > 0.0 else HERE  # no finger may sink below its set-point
        off_m = [value_m + off_m for value_m, off_m in zip(expected_m, place(number, 0.005), strict=True)]
        assert found(follow, expected_m) == ""
        assert f"{NAMES[number]}: does not obey: 5.0 mm off its set-points" in found(follow, off_m)
        assert found(follow, expected_m) == ""
        follow.commanded(begin_s + 2.0, HERE, False)


@pytest.mark.parametrize("number", range(2, 7))
def test_a_released_finger_comes_to_rest_where_its_servo_was_held_off(number: int) -> None:
    follow = sent()
    release(follow, 1.0, place(number, 0.02), pressing(number, 5.0))
    assert found(follow, place(number, 0.015 - HEIGHT_MARGIN_M)) == ""
    assert "2.5 mm off its set-points" in found(follow, place(number, 0.0125))


def test_a_release_at_a_time_of_nan_is_never_judged() -> None:
    follow = sent()
    for k in range(20):
        is_m = place(0, 0.1 * k)
        follow.step(DT, 0.0, is_m, IN_THE_AIR)
        follow.commanded(math.nan, HERE, True)
        assert follow.step(DT, 0.0, is_m, IN_THE_AIR) is None
