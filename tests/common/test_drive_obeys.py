from hypothesis import given
from hypothesis import strategies as st

from common.drive_obeys import MEMORY_S, PERSIST_S, DriveObeys

TICK_S = 0.002


@given(st.lists(st.integers(-1000, 1000), min_size=1, max_size=200), st.integers(0, 60))
def test_whoever_applies_what_was_told_a_while_ago_is_never_doubted(told: list[int], late_ticks: int) -> None:
    obeys = DriveObeys("the heater")
    for tick, drive in enumerate(told):
        obeys.told(tick * TICK_S, drive)
        assert obeys.reported(tick * TICK_S, told[max(0, tick - late_ticks)] if tick >= late_ticks else 0) == ""


def test_no_drive_is_always_right() -> None:
    obeys = DriveObeys("the heater")
    for tick in range(500):
        obeys.told(tick * TICK_S, 700)
        assert obeys.reported(tick * TICK_S, 0) == ""


def test_a_stuck_drive_is_found_soon_and_a_single_wrong_report_is_not() -> None:
    obeys, found_s = DriveObeys("the heater"), None
    for tick in range(500):
        t_s = tick * TICK_S
        obeys.told(t_s, tick % 7)
        applied = 1000 if tick == 100 or t_s >= 0.5 else tick % 7
        if obeys.reported(t_s, applied):
            found_s = found_s or t_s
    assert found_s is not None
    assert 0.5 + PERSIST_S <= found_s <= 0.5 + MEMORY_S + PERSIST_S


def test_a_drive_that_stays_after_its_command_is_long_over_is_found() -> None:
    obeys = DriveObeys("the heater")
    obeys.told(0.0, 300)
    obeys.told(1.0, 0)
    words = [obeys.reported(1.0 + tick * TICK_S, 300) for tick in range(200)]
    assert words[0] == ""
    assert words[-1] == "the heater is driven with 300, never asked for"


def test_a_module_that_reports_nothing_costs_no_memory_however_long_it_is_told() -> None:
    obeys = DriveObeys("the drive")
    for n in range(10_000):
        obeys.told(n * 0.002, n % 1000)
    assert len(obeys._told) <= 2 + MEMORY_S / 0.002
    assert obeys.reported(20.0, 999) == ""
    assert obeys.reported(20.1, 500) == ""
    assert "500" in [obeys.reported(20.1 + tick * TICK_S, 500) for tick in range(100)][-1]


def test_a_site_that_stood_still_between_two_reads_doubts_nobody() -> None:
    """Both reads are of reports that waited; only the first was late, and what it told is long over."""
    obeys = DriveObeys("the motor")
    obeys.told(0.0, 836)
    for tick in range(100):
        obeys.told(0.5 + tick * TICK_S, tick)
    assert obeys.reported(0.75, 836) == ""
    assert obeys.reported(0.75 + 2.0 * PERSIST_S, 836) == ""
    assert obeys.reported(0.752 + 2.0 * PERSIST_S, 99) == ""
