"""Bounds how many lines a second one place of the program writes to the log; what is left out is counted."""

import logging
import threading
import time
from collections import Counter
from collections.abc import Callable

from common.link.rate_limiter import RateLimiters

AT_ONCE = 60
"""Lines that one place may log at once."""
PER_S = 0.5
"""Lines a second that one place may log in the long run."""
SAFETY_AT_ONCE = 200
"""Lines about one kind of safety event that are logged at once."""
SAFETY_PER_S = 2.0
"""Lines a second about one kind of safety event in the long run."""
SAFETY = frozenset({"fault", "cleared", "estop", "engaged", "disengaged"})
"""Happenings of a session that have the larger bound."""

_Place = tuple[str, int, str]


class FloodFilter(logging.Filter):
    """Lets records pass at a bounded rate, apart for each call and each `happening` that a record carries as `extra`.

    A record that passes after others were left out carries their number as `left_out`.
    """

    def __init__(self, now_s: Callable[[], float] = time.monotonic):
        """Begin with full buckets.

        Args:
            now_s: a steady clock, s.
        """
        super().__init__()
        self._now_s = now_s
        self._others: RateLimiters[_Place] = RateLimiters(PER_S, AT_ONCE)
        self._safety: RateLimiters[_Place] = RateLimiters(SAFETY_PER_S, SAFETY_AT_ONCE)
        self._left_out: Counter[_Place] = Counter()
        self._lock = threading.Lock()

    def filter(self, record: logging.LogRecord) -> bool:
        """Whether `record` is logged."""
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
