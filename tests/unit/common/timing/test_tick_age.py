"""A tick's decision is sent only while it is new."""

import math

import pytest

from common.timing.standstill import HostClock
from common.timing.tick_age import TickAge
from common.timing.timeouts import TICK_AGE_S


class Host:
    """A host's clock, and how long devices have taken for the reports that wait."""

    def __init__(self) -> None:
        self.now_s = 100.0
        self.unread_s = 0.0
        self.clock = HostClock(lambda: round(self.now_s * 1e9))
        self.tick = TickAge(self.clock, lambda: self.unread_s)


def test_a_tick_is_in_time_until_it_is_too_old_and_counts_once() -> None:
    host = Host()
    assert host.tick.began_s == -math.inf
    assert not host.tick.in_time(), "nothing is sent before the first tick"
    for count in range(3):
        host.tick.begin(host.clock.now_s())
        assert host.tick.in_time()
        host.now_s += TICK_AGE_S - 1e-6
        assert host.tick.in_time()
        host.now_s += 2e-6
        assert not host.tick.in_time()
        assert not host.tick.in_time()
        assert host.tick.held_back == count + 1


def test_reports_that_wait_show_a_tick_that_is_too_old_though_the_clock_stood_still() -> None:
    host = Host()
    for unread_s in (TICK_AGE_S, TICK_AGE_S + 1e-6):
        host.tick.begin(host.clock.now_s())
        host.unread_s = unread_s
        assert host.tick.in_time() == (unread_s <= TICK_AGE_S)
    assert host.tick.held_back == 1


def test_a_standstill_puts_clock_and_tick_forward() -> None:
    host = Host()
    host.tick.begin(host.clock.now_s())
    host.tick.stood_still(0.0)
    assert (host.tick.stood_still_ns, host.clock.stood_still_s) == (0, 0.0)
    host.tick.stood_still(30.0)
    assert host.tick.stood_still_ns == 30_000_000_000
    assert host.tick.began_s == pytest.approx(host.clock.now_s()) == pytest.approx(130.0)
    assert host.tick.in_time()
    host.tick.begin(host.clock.now_s())
    assert host.tick.stood_still_ns == 0
