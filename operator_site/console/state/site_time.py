"""Estimates the operator site's clock in the console's process, and converts its times to the time of day."""

import math
from datetime import datetime, timedelta

RESTARTED_S = 2.0
"""Drop of the site's lead that shows a restart of its clock, s."""
STEPPED_S = 0.5
"""Smallest step of the time of day against the site's clock that is followed, s; less is jitter."""


class SiteTime:
    """Adds the lead of the site's clock to the console's clock. Pure: time is an argument, s.

    Both are the machine's monotonic clock, but a site adds each standstill of its host, including a suspend. Without
    the lead, the console would underestimate the age of every message by the length of the standstills.
    """

    def __init__(self) -> None:
        """Begin with no lead."""
        self.ahead_s = 0.0

    def heard(self, here_s: float, site_s: float) -> None:
        """Update the lead from a message with a time of the site's clock; a delay only lowers the apparent lead."""
        lead_s = site_s - here_s
        restarted = lead_s < self.ahead_s - RESTARTED_S
        self.ahead_s = max(0.0, lead_s) if restarted else max(self.ahead_s, lead_s)

    def now_s(self, here_s: float) -> float:
        """Return the time on the site's clock, s."""
        return here_s + self.ahead_s


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
