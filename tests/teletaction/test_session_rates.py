"""A session has the fastest rates that its machine holds, and never slower ones than the default."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.machine import Machine
from teletaction import session_rates
from teletaction.session_rates import COSTS, DEFAULT, FASTER, FITS, Rates, fitting_here, fitting_rates, session_takes

QUICK = Machine(step_s=50e-6, idle=2.0)


def test_an_idle_quick_machine_gets_the_fastest_rates() -> None:
    assert fitting_rates(QUICK) == FASTER[0]


def test_a_machine_between_gets_rates_between() -> None:
    assert fitting_rates(Machine(120e-6, 2.0)) == FASTER[1]


@pytest.mark.parametrize("machine", [Machine(250e-6, 2.0), Machine(50e-6, 0.1), Machine(250e-6, 16.0)])
def test_a_slow_or_busy_machine_keeps_the_default(machine: Machine) -> None:
    assert fitting_rates(machine) == DEFAULT


def test_what_else_will_run_is_left_room_for() -> None:
    assert fitting_rates(QUICK, others=1.4) == DEFAULT


@given(st.floats(10e-6, 1e-3), st.floats(0.0, 64.0))
def test_rates_that_are_chosen_leave_a_part_of_what_is_idle(step_s: float, idle: float) -> None:
    rates = fitting_rates(Machine(step_s, idle))
    assert rates == DEFAULT or sum(session_takes(rates, step_s).values()) <= FITS * idle


def test_each_process_of_a_session_has_a_cost() -> None:
    assert set(session_takes(DEFAULT, 1e-4)) == set(COSTS)


def test_where_idle_time_is_not_counted_the_default_stays(monkeypatch: pytest.MonkeyPatch) -> None:
    def unknown() -> Machine:
        raise FileNotFoundError("/proc/stat")

    monkeypatch.setattr(session_rates.Machine, "measured", unknown)
    assert fitting_here(console=False) == DEFAULT


def test_rates_are_read_as_they_are_written() -> None:
    assert Rates.read(str(FASTER[0])) == FASTER[0]


@pytest.mark.parametrize("text", ["", "500", "1,2,3", "fast,slow", "250,nan", "99,500", "250,1001"])
def test_bad_rates_are_refused_with_what_to_write(text: str) -> None:
    with pytest.raises(ValueError, match="--rates"):
        Rates.read(text)
