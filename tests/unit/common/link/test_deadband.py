"""A packet is sent at every change, again after it, and within the refresh; the cost of this."""

import math
from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.limits import GAP_S
from common.link.deadband import REPEATS, Deadband
from common.timing.timeouts import FASTEST_RATE_HZ, REFRESH_S, SECOND_REFRESH_S, SLOWEST_RATE_HZ

RATES = st.sampled_from((SLOWEST_RATE_HZ, 250.0, 300.0, 500.0, 700.0, FASTEST_RATE_HZ))
CHANGES = st.lists(st.booleans(), min_size=1, max_size=400)


def sent_at(rate_hz: float, changes: list[bool], refresh_s: float = REFRESH_S) -> list[int]:
    """Ticks at which it sends; what it has not sent it has counted."""
    deadband = Deadband(1.0 / rate_hz)
    sent = [tick for tick, each in enumerate(changes) if deadband.step(1000.0 + tick / rate_hz, each, refresh_s)]
    assert deadband.spared == len(changes) - len(sent)
    return sent


@given(RATES, CHANGES, st.sampled_from((REFRESH_S, SECOND_REFRESH_S)))
def test_every_change_is_sent_at_once_and_repeated_and_no_packet_is_older_than_the_refresh(
    rate_hz: float, changes: list[bool], refresh_s: float
) -> None:
    sent = sent_at(rate_hz, changes, refresh_s)
    assert sent[0] == 0
    for tick, each in enumerate(changes):
        if each:
            assert set(range(tick, min(tick + REPEATS + 1, len(changes)))) <= set(sent)
    for one, next_one in pairwise([*sent, len(changes)]):
        assert (next_one - one) / rate_hz <= max(refresh_s, 1.0 / rate_hz) + 0.25 / rate_hz + 1e-9


@pytest.mark.parametrize(("rate_hz", "every"), [(100.0, 1), (250.0, 3), (500.0, 6), (1000.0, 12)])
def test_a_resting_hand_sends_only_refreshes(rate_hz: float, every: int) -> None:
    rest = [True, *[False] * 600]
    sent = sent_at(rate_hz, rest)
    assert sent[: 1 + REPEATS] == list(range(1 + REPEATS))
    assert {after - before for before, after in pairwise(sent[REPEATS:])} == {every}


def test_ticks_that_are_a_little_early_or_late_do_not_change_the_pace() -> None:
    deadband = Deadband(0.002)
    jitter_s = (0.0, 0.0004, -0.0004, 0.0002)
    sent = [tick for tick in range(300) if deadband.step(0.002 * tick + jitter_s[tick % 4], tick == 0)]
    assert {after - before for before, after in pairwise(sent[REPEATS:])} == {6}


def test_a_clock_that_is_set_back_or_forward_sends_at_once() -> None:
    for step_s in (-10.0, 10.0):
        deadband = Deadband(0.002)
        assert deadband.step(100.0, False)
        assert not deadband.step(100.002, False)
        assert deadband.step(100.004 + step_s, False)
        assert not deadband.step(100.006 + step_s, False)


def test_a_fifth_lost_is_taken_for_a_gap_less_than_once_in_an_hour() -> None:
    """A gap begins with a packet that comes and as many lost as would have come within it."""
    within = math.floor(GAP_S / REFRESH_S)
    in_an_hour = 3600.0 / REFRESH_S * 0.8 * 0.2**within
    assert 0.1 < in_an_hour < 1.0
