"""The limits that hold back the heater of one thermal sensor, each at its bound."""

import math

import pytest

from common.limits import GAP_S, SENSOR_PLATE_C
from common.safety.repeated_fault import REPEATED_S
from remote_site.safety.heater_limits import (
    AGAINST_WORK_S,
    HOLDING_DRIVE,
    LOOK_AHEAD_S,
    RATE_LAG_S,
    SENSOR_HIGH_C,
    SENSOR_LOW_C,
    SILENT_K,
    SILENT_WORK_S,
    HeaterLimits,
)
from remote_site.safety.holding_loss import WINDOW_S
from remote_site.safety.slow_heating import LEAST_RATE_K_S

BELOW_LOW_C, ABOVE_HIGH_C = math.nextafter(SENSOR_LOW_C, -9.0), math.nextafter(SENSOR_HIGH_C, 99.0)


class Plate:
    """The limits of one heater, with a clock."""

    def __init__(self) -> None:
        self.limits, self.t_s = HeaterLimits(), 0.0

    def step(
        self, plate_c: float, dt_s: float = 0.0, drive: float = 0.0, age_s: float = 0.0, ambient_c: float = math.nan
    ) -> HeaterLimits:
        self.t_s += dt_s
        self.limits.step(self.t_s, dt_s, drive, plate_c, ambient_c, age_s)
        return self.limits


def test_nothing_is_known_at_the_beginning() -> None:
    limits = HeaterLimits()
    assert (limits.known, limits.spent, limits.too_hot, limits.repeated.needs_test) == (False,) * 4


@pytest.mark.parametrize(
    ("plate_c", "age_s", "known"),
    [
        (SENSOR_LOW_C, 0.0, True),
        (SENSOR_HIGH_C, GAP_S, True),
        (BELOW_LOW_C, 0.0, False),
        (ABOVE_HIGH_C, 0.0, False),
        (33.0, math.nextafter(GAP_S, 1.0), False),
        (33.0, -1e-9, False),
        (math.nan, 0.0, False),
        (33.0, math.nan, False),
    ],
)
def test_a_reading_is_known_when_fresh_and_plausible(plate_c: float, age_s: float, known: bool) -> None:
    plate = Plate()
    for before in (False, True):
        if before:
            assert plate.step(33.0).known is True
        assert plate.step(plate_c, age_s=age_s).known is known


def test_a_plate_without_a_rate_is_judged_by_its_reading() -> None:
    assert Plate().step(SENSOR_PLATE_C).too_hot is False
    assert Plate().step(math.nextafter(SENSOR_PLATE_C, 99.0)).too_hot is True


@pytest.mark.parametrize("rate_k_s", [0.9, 8.0])
@pytest.mark.parametrize("off_k", [-0.01, 0.01])
def test_a_warming_plate_is_judged_by_its_extrapolated_temperature(rate_k_s: float, off_k: float) -> None:
    plate, share = Plate(), 0.5  # of the rate, after RATE_LAG_S; then three quarters
    reached_c = SENSOR_PLATE_C + off_k - share * LOOK_AHEAD_S * rate_k_s
    plate.step(reached_c - RATE_LAG_S * rate_k_s)
    assert plate.step(reached_c, RATE_LAG_S).too_hot is (off_k > 0.0)
    plate, share = Plate(), 0.75
    reached_c = SENSOR_PLATE_C + off_k - share * LOOK_AHEAD_S * rate_k_s
    for before in (2.0, 1.0):
        plate.step(reached_c - before * RATE_LAG_S * rate_k_s, RATE_LAG_S)
    assert plate.step(reached_c, RATE_LAG_S).too_hot is (off_k > 0.0)


def test_a_plate_that_cools_is_judged_by_its_reading() -> None:
    plate = Plate()
    plate.step(SENSOR_PLATE_C + 2.0)
    assert plate.step(SENSOR_PLATE_C + 0.5, 0.1).too_hot is True
    assert plate.step(SENSOR_PLATE_C - 0.5, 0.1).too_hot is False


def test_the_rate_restarts_when_a_reading_returns() -> None:
    plate = Plate()
    for reading_c in (33.0, 35.0, math.nan):
        plate.step(reading_c, 0.1)
    assert plate.step(SENSOR_PLATE_C - 0.1, 0.1).too_hot is False


@pytest.mark.parametrize("answers_k", [SILENT_K, -SILENT_K, 0.29, -0.29, 0.0])
def test_drive_without_an_answer_of_the_reading_demands_a_test(answers_k: float) -> None:
    plate, drive = Plate(), HOLDING_DRIVE + 0.2
    plate.step(0.0)
    assert not plate.step(0.0, SILENT_WORK_S / 0.2, drive).repeated.needs_test
    answered = abs(answers_k) >= SILENT_K
    assert plate.step(answers_k, 0.01, drive).repeated.needs_test is not answered
    plate.step(answers_k, SILENT_WORK_S / 0.2 - 0.02, -drive)
    assert plate.limits.repeated.needs_test is not answered
    assert plate.step(answers_k, 0.02, drive).repeated.needs_test is True


@pytest.mark.parametrize("drive", [0.45, -1.0])
def test_a_plate_that_runs_away_from_its_drive_demands_a_test(drive: float) -> None:
    """A Peltier element that is wired in reverse would cool the plate to below 0 C, or heat it to its limit."""
    plate, tick_s = Plate(), 0.01
    for tick in range(700):
        demanded = plate.step(30.0 - drive * 5.0 * tick * tick_s, tick_s, drive).repeated.needs_test
        driven_s = (tick + 1) * tick_s * (abs(drive) - HOLDING_DRIVE)
        if abs(driven_s - AGAINST_WORK_S) > tick_s:
            assert demanded is (driven_s > AGAINST_WORK_S)


def test_a_plate_that_follows_its_drive_after_a_lag_needs_no_test() -> None:
    plate, plate_c = Plate(), 30.0
    for seconds, rate_k_s, drive in ((0.7, -5.0, 1.0), (5.0, 5.0, 1.0), (0.7, 5.0, -1.0), (2.0, -5.0, -1.0)):
        for _ in range(round(100 * seconds)):
            plate_c += 0.01 * rate_k_s
            assert not plate.step(plate_c, 0.01, drive).repeated.needs_test


def test_drive_that_holds_a_temperature_needs_no_answer_and_makes_up_for_more() -> None:
    plate = Plate()
    for drive, seconds in ((HOLDING_DRIVE, 100.0), (1.0, 0.7), (0.0, 2.0), (1.0, 0.4), (HOLDING_DRIVE, 9.0)):
        assert not plate.step(33.0, seconds, drive).repeated.needs_test
    assert plate.step(33.0, 0.5, 1.0).repeated.needs_test


def held(contact: float, ambient_c: float = 23.0, seconds: float = 4.0 * WINDOW_S) -> Plate:
    """Hold a reading of 10 K above 23 C on a plate of 1 % a kelvin, with this contact of its resistor."""
    plate = Plate()
    for tick in range(round(100 * seconds)):
        # The reading's noise shows that it is not stuck.
        plate.step(33.0 + 0.02 * (tick % 3), 0.01, 0.1 / contact, ambient_c=ambient_c)
    return plate


def test_a_resistor_that_has_loosened_on_a_warm_plate_demands_a_test() -> None:
    assert not held(1.0).limits.repeated.needs_test
    assert held(0.6).limits.repeated.needs_test
    assert not held(0.6, ambient_c=math.nan).limits.repeated.needs_test


def test_the_drive_of_a_test_is_not_that_which_holds_a_temperature() -> None:
    plate = held(0.6, seconds=2.0 * WINDOW_S + 0.05)
    assert plate.limits.repeated.needs_test
    for _ in range(2000):
        plate.step(33.0, 0.01, 0.15, ambient_c=23.0)
    plate.limits.repeated.needs_test = False
    assert not plate.step(33.0, 0.01, 0.0, ambient_c=23.0).repeated.needs_test


def test_a_demanded_test_is_not_demanded_again_without_further_drive() -> None:
    """Each demand restarts the test: a heater that answers again must come to its end."""
    plate = Plate()
    plate.step(33.0)
    assert plate.step(33.0, 1.0, 1.0).repeated.needs_test
    plate.limits.repeated.needs_test = False
    assert not plate.step(33.0, 0.01, 1.0).repeated.needs_test


def test_each_time_a_reading_becomes_implausible_is_one_fault() -> None:
    for after_s, repeated in ((REPEATED_S, True), (REPEATED_S + 1.0, False)):
        plate = Plate()
        for dt_s, reading_c in ((0.0, 99.0), (0.0, math.nan), (0.0, 33.0), (0.0, 33.0)):
            assert not plate.step(reading_c, dt_s).repeated.needs_test
        assert plate.step(99.0, after_s).repeated.needs_test is repeated


@pytest.mark.parametrize(("rate_k_s", "tested"), [(LEAST_RATE_K_S + 0.1, False), (LEAST_RATE_K_S - 0.1, True)])
def test_a_reading_that_rises_too_slowly_at_full_drive_demands_a_test(rate_k_s: float, tested: bool) -> None:
    plate, dt_s = Plate(), 0.01
    for tick in range(round(2.0 / dt_s)):
        plate.step(15.0 + rate_k_s * tick * dt_s, dt_s, drive=1.0)
    assert plate.limits.repeated.needs_test is tested
