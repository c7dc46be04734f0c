"""A token bucket: so many at once, and so many a second in the long run. Pure: time is an argument, s."""

from dataclasses import dataclass, field
from typing import Generic, TypeVar

Source = TypeVar("Source")

MOST_SOURCES = 1000
"""Sources that are limited apart; one more, and all of them begin with a full bucket again."""


@dataclass(slots=True)
class RateLimiter:
    """Limits one source.

    Attributes:
        per_s: tokens that come back in a second.
        at_once: tokens of a full bucket.
    """

    per_s: float
    at_once: float
    _left: float = field(init=False)
    _since_s: float = 0.0

    def __post_init__(self) -> None:
        self._left = self.at_once

    def allows(self, now_s: float) -> bool:
        """Take one token; False when there is none. A clock that was set back gives none back."""
        self._left = min(self.at_once, self._left + max(0.0, now_s - self._since_s) * self.per_s)
        self._since_s = now_s
        if self._left < 1.0:
            return False
        self._left -= 1.0
        return True


class RateLimiters(Generic[Source]):
    """One limiter for each source."""

    def __init__(self, per_s: float, at_once: float):
        """Give every source the same rate, tokens a second, and the same bucket, tokens."""
        self._per_s, self._at_once = per_s, at_once
        self._limiters: dict[Source, RateLimiter] = {}

    def allows(self, source: Source, now_s: float) -> bool:
        """Take one token of `source`; False when it has none."""
        limiter = self._limiters.get(source)
        if limiter is None:
            if len(self._limiters) >= MOST_SOURCES:
                self._limiters.clear()
            limiter = self._limiters[source] = RateLimiter(self._per_s, self._at_once)
        return limiter.allows(now_s)
