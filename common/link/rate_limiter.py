"""A token bucket: limits the number of events at once and their long-term rate. Pure: time is an argument, s."""

from dataclasses import dataclass, field
from typing import Generic, TypeVar

Source = TypeVar("Source")

MOST_SOURCES = 1000
"""Maximum number of sources with a bucket; one more resets all buckets to full."""


@dataclass(slots=True)
class RateLimiter:
    """Limits one source.

    Attributes:
        per_s: rate at which tokens return, 1/s.
        at_once: number of tokens in a full bucket.
    """

    per_s: float
    at_once: float
    _left: float = field(init=False)
    _since_s: float = 0.0

    def __post_init__(self) -> None:
        self._left = self.at_once

    def allows(self, now_s: float) -> bool:
        """Take one token; return False when there is none. A clock that was set back returns no tokens."""
        self._left = min(self.at_once, self._left + max(0.0, now_s - self._since_s) * self.per_s)
        self._since_s = now_s
        if self._left < 1.0:
            return False
        self._left -= 1.0
        return True


class RateLimiters(Generic[Source]):
    """One token bucket for each source."""

    def __init__(self, per_s: float, at_once: float):
        """Give every source the same rate, tokens per second, and the same bucket, tokens."""
        self._per_s, self._at_once = per_s, at_once
        self._limiters: dict[Source, RateLimiter] = {}

    def allows(self, source: Source, now_s: float) -> bool:
        """Take one token of `source`; return False when it has none."""
        limiter = self._limiters.get(source)
        if limiter is None:
            if len(self._limiters) >= MOST_SOURCES:
                self._limiters.clear()
            limiter = self._limiters[source] = RateLimiter(self._per_s, self._at_once)
        return limiter.allows(now_s)
