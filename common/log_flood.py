"""Bounds the rate of log lines from one place of the program, and counts omitted lines."""

import logging
import threading
import time
from collections import Counter
from collections.abc import Callable

from common.link.rate_limiter import RateLimiters

AT_ONCE = 60
"""Maximum number of lines that one place may log at once."""
PER_S = 0.5
"""Maximum long-term rate of one place's lines, 1/s."""
SAFETY_AT_ONCE = 200
"""Maximum number of lines about one kind of safety event at once."""
SAFETY_PER_S = 2.0
"""Maximum long-term rate of lines about one kind of safety event, 1/s."""
SAFETY = frozenset({"fault", "cleared", "estop", "engaged", "disengaged"})
"""Session events with the larger bound."""

_Place = tuple[str, int, str]


class FloodFilter(logging.Filter):
    """Passes records at a bounded rate, for each logging call and each `happening` in a record's `extra`.

    A record that passes after others were omitted carries their number as `left_out`.
    """

    def __init__(self, now_s: Callable[[], float] = time.monotonic):
        """Start with full buckets; `now_s` is a steady clock, s."""
        super().__init__()
        self._now_s = now_s
        self._others: RateLimiters[_Place] = RateLimiters(PER_S, AT_ONCE)
        self._safety: RateLimiters[_Place] = RateLimiters(SAFETY_PER_S, SAFETY_AT_ONCE)
        self._left_out: Counter[_Place] = Counter()
        self._lock = threading.Lock()

    def filter(self, record: logging.LogRecord) -> bool:
        """Return whether `record` is logged."""
        happening = str(getattr(record, "happening", ""))
        place = (record.pathname, record.lineno, happening)
        limiters = self._safety if happening in SAFETY else self._others
        with self._lock:
            if not limiters.allows(place, self._now_s()):
                self._left_out[place] += 1
                return False
            if left_out := self._left_out.pop(place, 0):
                record.left_out = left_out
        return True
