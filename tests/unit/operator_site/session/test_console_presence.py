"""A missing or hidden console pauses the session in time."""

from hypothesis import given
from hypothesis import strategies as st

from operator_site.session.console_presence import ConsolePresence

MS = 1_000_000
T0 = 5_000_000 * MS


def away(attendance: ConsolePresence, from_ms: int, to_ms: int) -> str:
    """The first reason to pause in these ms of being engaged."""
    for ms in range(from_ms, to_ms, 2):
        if reason := attendance.step(T0 + ms * MS, engaged=True):
            return reason
    return ""


def test_no_console_is_needed_where_none_is_required() -> None:
    assert away(ConsolePresence(0.0), 0, 60_000) == ""


def test_an_acting_console_that_is_silent_pauses_the_session() -> None:
    attendance = ConsolePresence(3.0)
    attendance.step(T0, engaged=False)
    for ms in range(0, 10_000, 1000):
        attendance.report(T0 + ms * MS, seen=True)
        assert away(attendance, ms, ms + 1000) == ""
    assert away(attendance, 10_000, 12_000) == ""
    assert away(attendance, 12_000, 12_010) == "console was silent for 3 s"


def test_a_hidden_console_does_not_count() -> None:
    attendance = ConsolePresence(3.0)
    attendance.step(T0, engaged=False)
    for ms in range(0, 4000, 500):
        attendance.report(T0 + ms * MS, seen=False)
        reason = away(attendance, ms, ms + 500)
        assert reason == ("" if ms < 3000 else "console was hidden for 3 s")


def test_a_console_has_its_time_to_appear_after_engaging() -> None:
    attendance = ConsolePresence(3.0)
    attendance.report(T0, seen=True)
    attendance.step(T0 + 60_000 * MS, engaged=False)
    assert away(attendance, 60_000, 63_000) == ""
    assert away(attendance, 63_000, 63_010) == "console was silent for 3 s"


@given(st.integers(-(10**6), 10**6))
def test_a_clock_that_is_set_back_pauses_no_later_than_it_should(step_ms: int) -> None:
    attendance = ConsolePresence(3.0)
    attendance.report(T0, seen=True)
    at_ms = min(0, step_ms)
    assert away(attendance, at_ms, at_ms + 3004) != "" or step_ms > 0
