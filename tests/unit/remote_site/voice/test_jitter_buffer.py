"""The jitter buffer: whatever arrives, it plays in order, once, in time, and never holds much."""

from hypothesis import given
from hypothesis import strategies as st

from common.limits import VOICE_AGE_S
from common.link.voice_end import Sound
from remote_site.voice.jitter_buffer import FIRST, LONGEST_S, MOST, PATIENCE_S, JitterBuffer

FRAME_NS = 20_000_000
START_NS = 10**12


def sound(number: int) -> Sound:
    return Sound(number, START_NS + number * FRAME_NS, 0, bytes([number % 256]))


def play(arrivals: list[tuple[int, int]], ticks: int) -> list[tuple[int, Sound]]:
    """What is played at each tick of 20 ms.

    Args:
        arrivals: tick and number of each sound, in order.
        ticks: number of ticks.
    """
    buffer, found = JitterBuffer(), []
    waiting = list(arrivals)
    for tick in range(ticks):
        now_ns = START_NS + tick * FRAME_NS
        while waiting and waiting[0][0] <= tick:
            buffer.put(sound(waiting.pop(0)[1]), now_ns)
        if (played := buffer.take(now_ns)) is not None:
            found.append((tick, played))
    return found


delays = st.lists(st.integers(1, 60), min_size=1, max_size=120)
"""Delay of each sound, in frames; TCP keeps their order."""


@given(delays, st.sets(st.integers(0, 119)))
def test_it_plays_in_order_once_and_nothing_old(delays: list[int], lost: set[int]) -> None:
    arrivals, tick = [], 0
    for number, delay in enumerate(delays):
        tick = max(tick, number + delay)
        if number not in lost:
            arrivals.append((tick, number))
    played = play(arrivals, tick + 20)
    numbers = [one.sequence for _, one in played]
    assert numbers == sorted(set(numbers))
    came = {number: at for at, number in arrivals}
    for at, one in played:
        assert (START_NS + at * FRAME_NS - one.captured_ns) * 1e-9 <= VOICE_AGE_S
        assert (at - came[one.sequence]) * 0.02 <= LONGEST_S + PATIENCE_S


@given(st.integers(1, 8), st.integers(50, 200))
def test_a_steady_stream_is_played_completely_after_the_first_wait(delay: int, count: int) -> None:
    played = play([(number + delay, number) for number in range(count)], count + delay + 20)
    assert [one.sequence for _, one in played] == list(range(count))
    assert played[0][0] == delay + FIRST - 1


def test_a_burst_leaves_the_newest() -> None:
    played = play([(20, number) for number in range(MOST + 1)], 60)
    assert [one.sequence for _, one in played] == list(range(MOST + 1 - FIRST, MOST + 1))


def test_what_waits_for_long_without_need_is_dropped_one_by_one() -> None:
    arrivals = [(20 + max(0, number - MOST + 1), number) for number in range(1200)]
    played = play(arrivals, 1300)
    waits = [at - (20 + max(0, one.sequence - MOST + 1)) for at, one in played]
    assert waits[MOST] == MOST - 1
    assert waits[-1] <= FIRST


def test_a_single_sound_is_played_too() -> None:
    assert [at for at, _ in play([(1, 0)], 20)] == [1 + round(PATIENCE_S / 0.02)]
