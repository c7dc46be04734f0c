"""A loop that does not hold its rate reports this and the reason."""

import os
import subprocess
import sys
import time

import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.runtime.periodic_loop import PeriodicLoop
from common.runtime.rate_monitor import HELD, HELD_AGAIN, WINDOW_S, RateMonitor, Spent, spent

RATE_HZ = 500.0
LOOP = PeriodicLoop(1.0 / RATE_HZ)


def looks(shares: list[float], waited: float | None = 0.0) -> list[dict[str, object]]:
    """Reports after each second, in which the loop made this share of its ticks."""
    held, ticks, reports = RateMonitor(RATE_HZ), 0, []
    for second, share in enumerate([0.0, *shares]):
        ticks += round(share * RATE_HZ)
        wait_s = None if waited is None else waited * second
        reports.append(held.look(100.0 + second, Spent(ticks, 0.25 * second, wait_s)))
    return reports[1:]


def test_a_loop_on_time_reports_only_its_rate_and_at_first_nothing() -> None:
    reports = RateMonitor(RATE_HZ).look(3.0, Spent(0, 0.0, None))
    assert reports == {"rate_hz": None, "wanted_hz": RATE_HZ, "works": None, "behind": "", "behind_s": 0.0}
    assert looks([1.0] * 10)[-1] == {
        "rate_hz": 500.0,
        "wanted_hz": RATE_HZ,
        "works": 0.25,
        "behind": "",
        "behind_s": 0.0,
    }


def test_a_missed_rate_is_reported_with_the_use_of_the_time() -> None:
    reports = looks([0.8] * 8, waited=0.7)
    assert [bool(each["behind"]) for each in reports] == [False] * 4 + [True] * 4
    words = "400 of 500 ticks a second; it works 25% of the time and waits for a processor 70%"
    assert reports[-1] == {"rate_hz": 400.0, "wanted_hz": RATE_HZ, "works": 0.25, "behind": words, "behind_s": 3.0}
    assert [each["works"] for each in reports] == [None] * 4 + [0.25] * 4
    without_waiting = "400 of 500 ticks a second; it works 25% of the time"
    assert looks([0.8] * 8, waited=None)[-1]["behind"] == without_waiting, "the system does not report waiting"


def test_it_is_over_soon_after_the_rate_is_held_again_and_its_time_is_counted() -> None:
    reports = looks([1.0] * 5 + [0.5] * 10 + [1.0] * 10)
    assert not reports[-1]["behind"]
    assert 10.0 <= float(str(reports[-1]["behind_s"])) <= 10.0 + WINDOW_S


def test_one_short_stop_is_ignored_and_the_limit_has_hysteresis() -> None:
    assert not any(each["behind"] for each in looks([1.0] * 5 + [0.8] + [1.0] * 5))
    between = 0.5 * (HELD + HELD_AGAIN)
    assert not any(each["behind"] for each in looks([between] * 10))
    assert all(each["behind"] for each in looks([0.5] * 5 + [between] * 10)[4:])


@given(st.lists(st.floats(0.0, 1.0), min_size=6, max_size=30))
def test_only_the_last_seconds_count_for_being_behind(shares: list[float]) -> None:
    reports = looks(shares)
    for second in range(round(WINDOW_S), len(shares) + 1):
        made = sum(round(share * RATE_HZ) for share in shares[second - round(WINDOW_S) : second])
        share = made / (WINDOW_S * RATE_HZ)
        assert reports[second - 1]["rate_hz"] == pytest.approx(share * RATE_HZ, abs=0.06)
        if share < HELD:
            assert reports[second - 1]["behind"]
        if share >= HELD_AGAIN:
            assert not reports[second - 1]["behind"]


def test_a_thread_that_waits_for_a_processor_is_seen_to() -> None:
    """Two that want one processor: each works half of the time, and waits for the other half."""
    allowed = os.sched_getaffinity(0)
    one = min(allowed)
    code = f"import os; os.sched_setaffinity(0, {{{one}}}); print('begun', flush=True)\nwhile True: pass"
    with subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True) as other:
        assert other.stdout is not None
        assert other.stdout.readline() == "begun\n"
        os.sched_setaffinity(0, {one})
        try:
            before, end_s = spent(LOOP), time.monotonic() + 0.5
            while time.monotonic() < end_s:
                pass
            after = spent(LOOP)
        finally:
            os.sched_setaffinity(0, allowed)
            other.kill()
    assert after.worked_s > before.worked_s
    if before.waited_s is None or after.waited_s is None:
        pytest.skip("this system does not count how long a thread waits")
    assert after.waited_s - before.waited_s > 0.05
