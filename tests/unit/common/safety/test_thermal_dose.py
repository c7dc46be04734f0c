"""Skin gets no more than the limit's dose within its window, and the dose is forgotten no earlier than that."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.limits import DOSE_ABOVE_C, DOSE_LIMIT_K_S, DOSE_WINDOW_S
from common.safety.thermal_dose import BIN_S, COAST_S, RESUME_SHARE, ThermalDose

WARM_C, MILD_C, COLD_C = DOSE_ABOVE_C + 2.0, DOSE_ABOVE_C + 0.25, DOSE_ABOVE_C - 10.0
SPENT_S = (DOSE_LIMIT_K_S - 2.0 * COAST_S) / 2.0
"""Dose is spent after this time at WARM_C."""


def spent_at(dose: ThermalDose, begin_s: float, plate_c: float = WARM_C, step_s: float = 0.25) -> float:
    """For how long it is as warm before the dose is spent, s."""
    ticks = 0
    while not dose.step(begin_s + step_s * ticks, plate_c):
        ticks += 1
        assert ticks < 10_000
    return step_s * ticks


def test_the_dose_is_spent_when_the_expected_rest_would_exceed_the_limit() -> None:
    assert spent_at(ThermalDose(), 0.0) == SPENT_S
    assert spent_at(ThermalDose(), -1e6) == SPENT_S
    before = ThermalDose()
    assert not before.step(0.0, COLD_C)
    assert spent_at(before, 0.25) == SPENT_S - 0.25, "it may have been as warm since the reading before"


def test_a_cool_plate_gives_no_dose() -> None:
    dose = ThermalDose()
    assert not any(dose.step(0.25 * tick, DOSE_ABOVE_C) for tick in range(10_000))
    assert spent_at(dose, 2500.0) == SPENT_S - 0.25


def test_a_dose_that_never_reaches_the_limit_within_the_window_is_never_spent() -> None:
    most_c = DOSE_ABOVE_C + DOSE_LIMIT_K_S / (DOSE_WINDOW_S + 2.0 * BIN_S + COAST_S)
    dose = ThermalDose()
    assert not any(dose.step(0.25 * tick, most_c - 0.001) for tick in range(10_000))


@pytest.mark.parametrize(
    ("step_s", "forgotten_s"),
    [
        (BIN_S, 5.0),  # of 18 K s, 2 K s in each second from 1 s on
        (BIN_S / 4.0, 3.0),  # of 16.5 K s, 1.5 K s in the first second, then 2 K s in each
    ],
)
def test_the_dose_is_available_again_when_half_of_it_has_left_the_window(step_s: float, forgotten_s: float) -> None:
    """A second's dose is forgotten when all of that second is older than the window."""
    dose = ThermalDose()
    back_s = spent_at(dose, 0.0, step_s=step_s) + step_s
    while dose.step(back_s, COLD_C):
        back_s += step_s
    assert back_s == forgotten_s + DOSE_WINDOW_S + BIN_S + step_s
    dose.step(back_s + 2.0 * DOSE_WINDOW_S, COLD_C)
    assert spent_at(dose, back_s + 2.0 * DOSE_WINDOW_S) == SPENT_S


@pytest.mark.parametrize(("first_c", "second_c"), [(MILD_C, COLD_C), (COLD_C, MILD_C)])
@pytest.mark.parametrize(("over_k", "spent"), [(2.5, True), (2.375, False)])
def test_a_gap_counts_at_the_hotter_end_for_no_more_than_the_window(
    first_c: float, second_c: float, over_k: float, spent: bool
) -> None:
    dose = ThermalDose()
    assert not dose.step(0.0, first_c)
    assert not dose.step(1e6, second_c)  # of 20 K s, 15 K s are counted
    assert dose.step(1e6, DOSE_ABOVE_C + over_k) is spent


def test_a_clock_that_was_set_back_adds_nothing_and_takes_nothing() -> None:
    dose = ThermalDose()
    assert not any(dose.step(0.25 * tick, WARM_C) for tick in range(17))
    assert not dose.step(-50.0, WARM_C)
    assert spent_at(dose, -50.0) == SPENT_S - 4.0


readings = st.lists(st.tuples(st.floats(0.0, 20.0), st.floats(35.0, 48.0)), min_size=1, max_size=60)


@given(readings)
def test_dose_of_the_last_minute_is_never_more_than_counted(course: list[tuple[float, float]]) -> None:
    """Between two readings the plate was as hot as the hotter; what it gives for COAST_S more is counted before."""
    dose, t_s, parts, before_k, spent = ThermalDose(), 0.0, list[tuple[float, float, float]](), 0.0, False
    for number, (step_s, plate_c) in enumerate(course):
        over_k = max(0.0, plate_c - DOSE_ABOVE_C)
        t_s += step_s
        if number:
            parts.append((t_s - step_s, t_s, max(before_k, over_k)))
        share = RESUME_SHARE if spent else 1.0
        counted = {
            window_s: sum(k * max(0.0, end_s - max(begin_s, t_s - window_s)) for begin_s, end_s, k in parts)
            + COAST_S * over_k
            for window_s in (DOSE_WINDOW_S, DOSE_WINDOW_S + 20.0 + 2.0 * BIN_S)
        }
        least, most = counted.values()
        spent = dose.step(t_s, plate_c)
        if spent:
            assert most >= share * DOSE_LIMIT_K_S - 1e-9
        else:
            assert least < share * DOSE_LIMIT_K_S + 1e-9
        before_k = over_k
