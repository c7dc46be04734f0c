"""A session has the fastest rates that its machine holds, and never slower ones than the default."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.runtime.machine import Machine
from teletaction.session import session_rates
from teletaction.session.session_rates import (
    COSTS,
    DEFAULT,
    FASTER,
    FITS,
    Rates,
    fitting_here,
    fitting_rates,
    session_takes,
)


@pytest.mark.parametrize(
    ("step_us", "idle", "others", "rates"),
    [
        (50.0, 2.0, 0.0, FASTER[0]),
        (120.0, 2.0, 0.0, FASTER[1]),
        (250.0, 2.0, 0.0, DEFAULT),
        (250.0, 16.0, 0.0, DEFAULT),
        (50.0, 0.1, 0.0, DEFAULT),
        (50.0, 2.0, 1.4, DEFAULT),  # room is left for what else will run
    ],
)
def test_a_faster_and_idler_machine_gets_faster_rates(step_us: float, idle: float, others: float, rates: Rates) -> None:
    assert fitting_rates(Machine(1e-6 * step_us, idle), others) == rates


@given(st.floats(10e-6, 1e-3), st.floats(0.0, 64.0))
def test_chosen_rates_leave_idle_time(step_s: float, idle: float) -> None:
    rates = fitting_rates(Machine(step_s, idle))
    assert rates == DEFAULT or sum(session_takes(rates, step_s).values()) <= FITS * idle


def test_each_process_of_a_session_has_a_cost() -> None:
    assert set(session_takes(DEFAULT, 1e-4)) == set(COSTS)


def test_the_default_stays_where_idle_time_is_unknown(monkeypatch: pytest.MonkeyPatch) -> None:
    def unknown() -> Machine:
        raise FileNotFoundError("/proc/stat")

    monkeypatch.setattr(session_rates.Machine, "measured", unknown)
    assert fitting_here(console=False) == DEFAULT


@pytest.mark.parametrize("text", ["", "500", "1,2,3", "fast,slow", "250,nan", "99,500", "250,1001"])
def test_rates_are_read_as_written_and_bad_rates_are_refused_with_an_example(text: str) -> None:
    assert Rates.read(str(FASTER[0])) == FASTER[0]
    with pytest.raises(ValueError, match="--rates"):
        Rates.read(text)
