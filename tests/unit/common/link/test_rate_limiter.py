from hypothesis import given
from hypothesis import strategies as st

from common.link.rate_limiter import MOST_SOURCES, RateLimiter, RateLimiters

PER_S, AT_ONCE = 20.0, 40


@given(st.lists(st.floats(0.0, 1.0), max_size=300))
def test_tokens_are_limited_at_once_and_in_the_long_run(pauses_s: list[float]) -> None:
    limiter, now_s, allowed = RateLimiter(PER_S, AT_ONCE), 0.0, 0
    for pause_s in pauses_s:
        now_s += pause_s
        allowed += limiter.allows(now_s)
    assert allowed <= AT_ONCE + PER_S * now_s + 1e-6
    assert allowed == len(pauses_s) or allowed >= min(len(pauses_s), AT_ONCE)


@given(st.lists(st.floats(-100.0, 0.0), max_size=100))
def test_a_clock_that_is_set_back_gives_no_tokens(steps_s: list[float]) -> None:
    limiter, now_s = RateLimiter(PER_S, AT_ONCE), 1000.0
    allowed = limiter.allows(now_s)
    for step_s in steps_s:
        now_s += step_s
        allowed += limiter.allows(now_s)
    assert allowed <= AT_ONCE


def test_each_source_has_tokens_of_its_own_and_the_number_of_sources_is_bounded() -> None:
    limiters: RateLimiters[int] = RateLimiters(PER_S, 1)
    assert limiters.allows(1, 0.0)
    assert not limiters.allows(1, 0.0)
    assert limiters.allows(2, 0.0)
    for source in range(3, 2 * MOST_SOURCES):
        assert limiters.allows(source, 0.0)
    assert len(limiters._limiters) <= MOST_SOURCES
