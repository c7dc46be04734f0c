"""The operator site's clock, as the console knows it on the same machine."""

RESTARTED_S = 2.0
"""A site whose messages are this much less ahead than before has a clock that began anew, s."""


class SiteTime:
    """Adds to the console's clock what the site's is ahead. Pure: time is an argument, s.

    Both are the machine's monotonic clock, but a site adds each standstill of its host, also a suspend. Without that
    lead the console would take everything for young for as long as the standstill lasted.
    """

    def __init__(self) -> None:
        """The clocks are one."""
        self.ahead_s = 0.0

    def heard(self, here_s: float, site_s: float) -> None:
        """A message with a time of the site's clock came; on its way it was late, never early."""
        lead_s = site_s - here_s
        anew = lead_s < self.ahead_s - RESTARTED_S
        self.ahead_s = max(0.0, lead_s) if anew else max(self.ahead_s, lead_s)

    def now_s(self, here_s: float) -> float:
        """The time on the site's clock."""
        return here_s + self.ahead_s
