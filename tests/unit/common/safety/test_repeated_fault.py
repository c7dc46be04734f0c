"""A plate that faults name repeatedly gets no drive but a small test's, and is freed by nothing but that test."""

import math

import pytest

from common.safety.repeated_fault import (
    CALM_SHARE,
    PULSE_S,
    REPEATED_S,
    ROUND_S,
    SPACING_S,
    TEST_EVERY_S,
    WINDOW_S,
    RepeatedFault,
)

T = 1 / 32
ROUND = math.ceil(ROUND_S / T)
"""Ticks from the start of a round to the start of the next."""
DRIVE, LEAST_K, CALM_K = 0.25, 0.5, CALM_SHARE * 0.5
OFF = [0.0] * ROUND
COOLS, HEATS, ENDS = (math.ceil(s / T) for s in (WINDOW_S, WINDOW_S + PULSE_S, WINDOW_S + 2.0 * PULSE_S))
PULSE = [0.0] * COOLS + [-DRIVE] * (HEATS - COOLS) + [DRIVE] * (ENDS - HEATS) + [0.0] * (ROUND - ENDS)
"""Drive of a round that tests."""
LITTLE_K = 1 / 128


class Plate:
    """A plate that two faults have named, with a clock; its reading is what the test says."""

    def __init__(self) -> None:
        self.logic, self.t_s = RepeatedFault(DRIVE, LEAST_K), 100.0
        for _ in range(2):
            self.logic.named(self.t_s)

    def step(self, plate_c: float = 33.0, free: bool = True) -> float:
        drive = self.logic.step(self.t_s, plate_c, free)
        self.t_s += T
        return drive

    def round(self, change_k: float = 0.0) -> list[float]:
        """A round whose reading drifts and has a second difference; between the averages it is anything."""
        averages_c, drives = (33.0, 34.0 - change_k / 2.0, 35.0), []
        for tick in range(ROUND):
            window = int(T * tick / SPACING_S)
            averaged = T * tick - window * SPACING_S < WINDOW_S
            drives.append(self.step(averages_c[window] if averaged else 50.0))
        return drives


@pytest.mark.parametrize(
    ("later_s", "again"),
    [(0.0, True), (REPEATED_S, True), (math.nextafter(REPEATED_S, 1e9), False), (-5.0, True), (math.nan, True)],
)
def test_a_fault_soon_after_the_one_before_needs_a_test(later_s: float, again: bool) -> None:
    """So does one at a time that is none, or after a clock was set back: it is not known to be long ago."""
    logic = RepeatedFault(DRIVE, LEAST_K)
    assert not logic.needs_test
    assert not logic.named(0.0)
    assert logic.named(later_s) is logic.needs_test is again


def test_the_time_counts_from_the_last_fault_and_frees_no_plate() -> None:
    logic = RepeatedFault(DRIVE, LEAST_K)
    assert [logic.named(k * (REPEATED_S + 1.0)) for k in range(3)] == [False] * 3
    assert logic.named(2.5 * REPEATED_S)
    assert logic.named(10.0 * REPEATED_S)


def test_a_plate_that_needs_no_test_gets_no_pulse() -> None:
    plate = Plate()
    plate.logic = RepeatedFault(DRIVE, LEAST_K)
    assert [plate.round() for _ in range(2)] == [OFF] * 2


@pytest.mark.parametrize(("change_k", "frees"), [(LEAST_K, True), (LEAST_K - LITTLE_K, False), (-LEAST_K, False)])
def test_a_calm_round_then_a_pulse_that_moves_the_plate_frees_it(change_k: float, frees: bool) -> None:
    plate = Plate()
    assert plate.round() == OFF
    assert plate.round(change_k) == PULSE
    assert plate.logic.needs_test
    plate.step()
    assert plate.logic.needs_test is not frees


def test_a_pulse_begins_turns_and_ends_at_its_times_and_an_average_ends_before_them() -> None:
    plate = Plate()
    rounds = [
        [(0.0, 33.0, 0.0), (SPACING_S + 0.1, 33.0, 0.0), (2.0 * SPACING_S + 0.1, 33.0, 0.0)],
        [
            (0.0, 33.0, 0.0),
            (0.0, 33.0, 0.0),  # twice at a time
            (WINDOW_S, 10.0, -DRIVE),
            (WINDOW_S + PULSE_S, 33.0 - LEAST_K / 2.0, DRIVE),
            (WINDOW_S + 2.0 * PULSE_S, 50.0, 0.0),
            (2.0 * SPACING_S + 0.1, 33.0, 0.0),
            (ROUND_S, 33.0, 0.0),
        ],
    ]
    for begin_s, course in zip((-ROUND_S, 0.0), rounds, strict=True):
        assert plate.logic.needs_test
        for since_s, plate_c, drive in course:
            assert plate.logic.step(begin_s + since_s, plate_c, True) == drive
    assert not plate.logic.needs_test


def test_the_round_after_a_test_is_without_drive_at_any_start() -> None:
    plate = Plate()
    assert (plate.round(), plate.round()) == (OFF, PULSE)
    plate.t_s += 2.0 * TEST_EVERY_S
    assert (plate.round(), plate.round()) == (OFF, PULSE)


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_plate_that_moves_by_itself_is_not_tested(sign: float) -> None:
    plate = Plate()
    for change_k in (CALM_K + LITTLE_K, LEAST_K, CALM_K):
        assert plate.round(sign * change_k) == OFF
    assert plate.round() == PULSE, "the round before was calm enough"


@pytest.mark.parametrize(("early_ticks", "tested"), [(0, True), (1, False)])
@pytest.mark.parametrize("interrupted", [False, True])
def test_from_a_pulse_to_the_next_is_a_set_time(early_ticks: int, tested: bool, interrupted: bool) -> None:
    """Also after a pulse that was interrupted; and each needs a calm round of its own before."""
    plate = Plate()
    plate.round()
    began_s = plate.t_s
    if interrupted:
        plate.step()
        plate.logic.interrupt()
    else:
        assert plate.round() == PULSE
    assert plate.round() == OFF
    plate.logic.interrupt()
    plate.t_s = began_s + TEST_EVERY_S - T * (ROUND + early_ticks)
    assert plate.round() == OFF
    assert plate.round() == (PULSE if tested else OFF)
    plate.logic.interrupt()
    plate.t_s += TEST_EVERY_S
    assert (plate.round(), plate.round()) == (OFF, PULSE)


@pytest.mark.parametrize("way", ["not free", "no reading", "a fault", "clock set back"])
@pytest.mark.parametrize("tick", [1, COOLS + 1, ROUND - 1])
def test_an_interrupted_pulse_ends_and_counts(way: str, tick: int) -> None:
    plate = Plate()
    plate.round()
    assert [plate.step() for _ in range(tick)] == PULSE[:tick]
    if way == "a fault":
        plate.logic.named(plate.t_s)
    elif way == "clock set back":
        plate.t_s -= 10.0
    assert plate.step(math.nan if way == "no reading" else 33.0, way != "not free") == 0.0
    assert [plate.step() for _ in range(3 * ROUND)] == 3 * OFF
    assert plate.logic.needs_test
