"""A plate that does not follow its drive is found at the named times, and not sooner."""

from collections.abc import Callable

import pytest

from common.faults.fault import FaultCode
from common.limits import DOSE_ABOVE_C, PLATE_HEATING_K_S
from operator_site.safety.operator_gate import LONGEST_CHECK_S
from operator_site.safety.plate_following import (
    AGAINST_K,
    CHECK_S,
    LAG_S,
    STILL_HEATED_S,
    STILL_HOT_S,
    STILL_K,
    STILL_S,
    PlateFollowing,
)

AGAINST = FaultCode.PLATE_AGAINST_DRIVE
UNDRIVEN = FaultCode.PLATE_NOT_FOLLOWING
UNCHANGED = FaultCode.PLATE_UNMOVED
STILL = FaultCode.PLATE_STILL_DRIVEN
STILL_HOT = FaultCode.PLATE_STILL_HOT
STILL_HEATED = FaultCode.PLATE_STILL_HEATED
LONGEST_S = 5.0
OfTime = Callable[[float], float]


def first_fault(drive: OfTime, reading_c: OfTime, dt_s: float) -> tuple[float | None, FaultCode | None]:
    """When a fault is found, s after the first reading, and which."""
    follow = PlateFollowing()
    for tick in range(round(LONGEST_S / dt_s) + 1):
        wrong = follow.step(dt_s, drive(tick * dt_s), reading_c(tick * dt_s))
        if wrong:
            return tick * dt_s, wrong
    return None, None


def always(value: float) -> OfTime:
    return lambda _t_s: value


def flickers(t_s: float) -> float:
    """A reading with noise of little more than half a count, of a plate that does nothing."""
    return 33.0 + 0.011 * (round(t_s / 0.05) % 2)


def ramp(rate_k_s: float) -> OfTime:
    return lambda t_s: 33.0 + rate_k_s * t_s


def at_first(value: float, then: float = 0.0, until_s: float = 1.0) -> OfTime:
    return lambda t_s: value if t_s < until_s else then


def follows(drive: float, until_s: float = 1.0) -> OfTime:
    """A plate that changes by what it is driven by, later by the lag, and then holds."""
    return lambda t_s: 33.0 + drive * PLATE_HEATING_K_S * min(max(0.0, t_s - LAG_S), until_s)


@pytest.mark.parametrize(
    ("drive", "reading_c", "fault", "fine_s", "coarse_s"),
    [
        (always(1.0), flickers, UNDRIVEN, 0.63, 0.60),
        (always(0.7), ramp(0.3), UNDRIVEN, 1.21, None),
        (always(1.0), ramp(0.6), UNDRIVEN, 0.63, 0.60),
        (always(-1.0), ramp(-0.5), UNDRIVEN, 1.29, 1.30),
        (always(0.65), flickers, None, None, None),
        (always(-1.0), ramp(-0.3), UNDRIVEN, 0.87, 0.85),
        (always(-1.0), ramp(3.0), UNDRIVEN, 0.87, 0.85),
        (always(-0.8), flickers, None, None, None),
        (at_first(1.0, -1.0, until_s=0.5), flickers, UNDRIVEN, 1.48, 1.45),
        (at_first(1.0, until_s=0.5), flickers, None, None, None),
        (always(1.0), ramp(-3.0), AGAINST, 0.57, 0.55),
        (always(0.55), ramp(-2.5), AGAINST, 1.45, 1.45),
        (always(0.45), ramp(-2.5), None, None, None),
        (always(0.0), ramp(4.0), None, None, None),
        (always(1.0), ramp(4.0), None, None, None),
        (always(-0.5), always(33.0), UNCHANGED, 0.56, 0.60),
        (at_first(0.3, 0.6), follows(0.3), UNCHANGED, 1.70, 1.75),
        (at_first(0.1, -0.4), follows(0.1), UNCHANGED, 1.75, 1.75),
        (always(1.0), always(33.0), STILL, 0.28, 0.30),
        (always(0.2), always(33.0), STILL, 0.91, 0.90),
        (always(-0.1), always(33.0), STILL, 3.50, 3.50),
        (at_first(0.3, -0.1), follows(0.3), STILL, 2.58, 2.75),
        (at_first(-0.3, 0.0), follows(-0.2), STILL, 4.34, 4.90),
        (always(-0.05), always(33.0), None, None, None),
        (always(0.05), always(33.0), STILL_HEATED, 3.01, 3.05),
        (always(0.0), always(DOSE_ABOVE_C + 0.01), STILL_HOT, 1.00, 1.00),
        (always(0.0), always(DOSE_ABOVE_C), None, None, None),
    ],
)
def test_each_fault_is_found_in_its_time_whether_checked_often_or_not(drive, reading_c, fault, fine_s, coarse_s):
    """Checked every 10 ms, or every 50 ms as a loop does that is late."""
    for dt_s, found_s in ((CHECK_S, fine_s), (LONGEST_CHECK_S, coarse_s)):
        found = first_fault(drive, reading_c, dt_s)
        assert found == (None if found_s is None else pytest.approx(found_s), fault if found_s else None)


@pytest.mark.parametrize(("drive", "reading_c", "at_s"), [(0.0, 41.0, STILL_HOT_S), (0.01, 33.0, STILL_HEATED_S)])
def test_a_reading_that_stands_still_as_long_as_the_limit_is_a_fault(drive, reading_c, at_s):
    assert first_fault(always(drive), always(reading_c), 0.25)[0] == at_s


@pytest.mark.parametrize(
    ("dt_s", "drive", "moved_k", "fault"),
    [
        (0.5, 1.0, -AGAINST_K, AGAINST),
        (0.5, 1.0, -0.99 * AGAINST_K, None),
        (STILL_S, -0.9, 0.0, UNCHANGED),
        (1.0, 0.18, 0.0, UNCHANGED),  # 0.3 K expected
        (1.0, 0.179, 0.0, STILL),  # as its drive changed by 0.5 K
        (0.8, 25.0 / 128.0, 0.0, STILL),  # driven by 0.5 K
        (0.8, 24.9 / 128.0, 0.0, None),
        (0.8, 45.0 / 64.0, 0.02, UNDRIVEN),  # 1 K expected
        (0.8, 44.9 / 64.0, 0.02, None),
        (0.8, 1.0, 0.511, UNDRIVEN),
        (0.8, 1.0, 0.512, None),  # a fifth of what is expected
    ],
)
def test_a_value_at_the_limit_is_judged_by_the_limit(dt_s, drive, moved_k, fault):
    """One long step, with numbers that meet each limit without rounding."""
    follow = PlateFollowing()
    follow.step(dt_s, drive, 0.0)
    assert follow.step(dt_s, drive, moved_k) == fault


def test_a_reading_is_the_same_that_differs_by_no_more_than_noise():
    for moved_k, still in ((STILL_K, True), (1.001 * STILL_K, False)):
        follow = PlateFollowing()
        faults = [follow.step(CHECK_S, 0.05, moved_k * (tick % 2)) for tick in range(400)]
        assert (STILL_HEATED in faults) == still


def test_a_quiet_plate_that_was_at_rest_for_long_may_be_heated():
    follow, heated_s, plate_c = PlateFollowing(), 10.0, 33.0
    for tick in range(1200):
        since_s = tick * CHECK_S - heated_s
        if since_s > 0.1:
            plate_c = 33.0 + 0.4 * (since_s - 0.1)
        assert follow.step(CHECK_S, 0.1 if since_s >= 0.0 else 0.0, plate_c) is None


def test_the_rate_follows_the_reading_with_a_tenth_of_a_second():
    follow = PlateFollowing()
    assert not follow.started
    for tick in range(8):
        follow.step(0.05, 0.0, 33.0 + 2.0 * 0.05 * tick)
        assert follow.started
        assert follow.rate_k_s == pytest.approx(2.0 * (1.0 - (0.1 / 0.15) ** tick))
