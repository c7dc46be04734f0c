"""Estimates the operator site's clock in the console's process on the same machine."""

RESTARTED_S = 2.0
"""Drop of the site's lead that shows a restart of its clock, s."""


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
