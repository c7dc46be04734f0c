"""What a tick decided is sent while it is new."""

import math

from common.ladder import TICK_AGE_S
from common.tick_age import TickAge


class Clock:
    def __init__(self) -> None:
        self.now_s = 100.0

    def __call__(self) -> float:
        return self.now_s


def test_nothing_is_sent_before_the_first_tick() -> None:
    tick = TickAge(Clock())
    assert tick.began_s == -math.inf
    assert not tick.in_time()


def test_a_tick_is_in_time_until_it_is_too_old_and_counts_once() -> None:
    clock = Clock()
    tick = TickAge(clock)
    for count in range(3):
        tick.begin(clock.now_s)
        assert tick.in_time()
        clock.now_s += TICK_AGE_S - 1e-9
        assert tick.in_time()
        clock.now_s += 2e-9
        assert not tick.in_time()
        assert not tick.in_time()
        assert tick.held_back == count + 1
