"""Converts times of the operator site's clock to the time of day."""

import math
from datetime import datetime, timedelta

STEPPED_S = 0.5
"""Smallest step of the time of day against the site's clock that is followed, s; less is jitter."""


class WallClock:
    """Holds the offset between both clocks, so that a past time does not change from state to state. Pure."""

    def __init__(self) -> None:
        """Begin without an offset."""
        self._zero: datetime | None = None
        """Time of day at time 0 of the site's clock."""

    def take(self, now_s: float, here: datetime) -> None:
        """Take a time of the site's clock, s, and the time of day at that time."""
        if not math.isfinite(now_s):
            return
        zero = here - timedelta(seconds=now_s)
        if self._zero is None or abs((zero - self._zero).total_seconds()) > STEPPED_S:
            self._zero = zero

    def at(self, at_s: float) -> str:
        """Return the time of day at a time of the site's clock, s, such as `14:07:03`; `--` before the first `take`."""
        return "--" if self._zero is None else f"{self._zero + timedelta(seconds=at_s):%H:%M:%S}"
