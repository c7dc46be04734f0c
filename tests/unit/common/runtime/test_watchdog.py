"""A loop that stands still ends its process; one that only waits for its turn does not."""

import os
import signal
import subprocess
import sys
import threading
import time

import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.runtime.watchdog import EXIT_CODE, WAKE_UP_S, LoopWatchdog, Standstill
from common.timing.timeouts import SITE_WATCHDOG_S

MOST = round(SITE_WATCHDOG_S / WAKE_UP_S)
PROGRAM = """
import logging, os, signal, sys, threading, time
from common.logs import log_to_stderr
from common.runtime.watchdog import LoopWatchdog
log_to_stderr("remote")
ticks = 0
def a_tick_that_hangs():
    {hang}
with LoopWatchdog(lambda: ticks):
    for ticks in range(50):
        time.sleep(0.002)
    print("ticked", flush=True)
    a_tick_that_hangs()
    print("continued", flush=True)
"""


def start(hang: str) -> "subprocess.Popen[str]":
    return subprocess.Popen(
        [sys.executable, "-c", PROGRAM.format(hang=hang)],
        stdin=subprocess.PIPE,  # never written to: a read waits without end
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


@given(st.lists(st.tuples(st.integers(0, 3), st.booleans()), max_size=200))
def test_the_watchdog_trips_exactly_after_its_number_of_idle_wake_ups(between: list[tuple[int, bool]]) -> None:
    standstill = Standstill()
    ticks = still = 0
    standstill.wake_up(ticks, starved=False)
    for more, starved in between:
        ticks += more
        still = 0 if more else still + (not starved)
        assert standstill.wake_up(ticks, starved) is (still >= MOST)


def test_a_loop_without_a_processor_does_not_count_as_hanging() -> None:
    standstill = Standstill()
    assert not any(standstill.wake_up(7, starved=True) for _ in range(100 * MOST))


@pytest.mark.parametrize("hang", ["while True: pass", "threading.Lock().acquire() and os.read(0, 1)"])
def test_a_hanging_loop_ends_its_process_and_reports_its_place(hang: str) -> None:
    with start(hang) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        assert process.wait(50) == EXIT_CODE == 70
        assert process.stdout.read() == "ticked\n"
        lines = process.stderr.read().splitlines()
    assert any("in a_tick_that_hangs" in line for line in lines), lines
    assert [line for line in lines if " CRITICAL " in line] == lines[-1:]
    assert lines[-1].endswith("the loop makes no tick any more: this process ends with exit code 70")


def test_an_unread_standard_error_does_not_block_the_watchdog() -> None:
    with start("[logging.error('x' * 5000) for _ in range(100)]") as process:
        assert process.wait(50) == EXIT_CODE


def test_a_process_that_was_stopped_for_longer_continues() -> None:
    # It stands still for three wake-ups before it is stopped, and for three more when it continues.
    with start("time.sleep(0.3); print('halfway', flush=True); [time.sleep(0.1) for _ in range(3)]") as process:
        assert process.stdout is not None
        assert [process.stdout.readline() for _ in range(2)] == ["ticked\n", "halfway\n"]
        os.kill(process.pid, signal.SIGSTOP)
        os.waitid(os.P_PID, process.pid, os.WSTOPPED | os.WNOWAIT)
        time.sleep(1.3 * SITE_WATCHDOG_S)  # what is tested is that this time does not count
        os.kill(process.pid, signal.SIGCONT)
        assert process.stdout.readline() == "continued\n"
        assert process.wait(50) == 0


def test_the_watchdog_is_active_only_while_the_loop_runs() -> None:
    ended = threading.Event()
    with LoopWatchdog(lambda: 0, end=ended.set) as watchdog:
        assert ended.wait(50.0)
    assert not watchdog._thread.is_alive()
    looked = []

    def look() -> int:
        looked.append(1)
        return len(looked)

    with LoopWatchdog(look, end=ended.clear) as watchdog:
        pass
    assert not watchdog._thread.is_alive()
    assert ended.is_set()
