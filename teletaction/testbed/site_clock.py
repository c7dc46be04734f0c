"""Clock of one host in a test bed: virtual time with its own offset and drift."""

from dataclasses import dataclass


@dataclass(slots=True)
class SiteClock:
    """A host's own clock.

    Attributes:
        offset_s: lead over virtual time, s.
        drift: relative rate by which the clock is fast, s/s.
        stopped_s: virtual time at which it stopped; None while it runs.
    """

    offset_s: float = 0.0
    drift: float = 0.0
    stopped_s: float | None = None

    def now_ns(self, time_s: float) -> int:
        """Return the reading of this clock at a virtual time, ns."""
        running_s = time_s if self.stopped_s is None else self.stopped_s
        return round((running_s * (1.0 + self.drift) + self.offset_s) * 1e9)

    def run_on(self, time_s: float) -> None:
        """Resume at a virtual time from the reading at which the clock stopped."""
        if self.stopped_s is not None:
            self.offset_s -= (time_s - self.stopped_s) * (1.0 + self.drift)
            self.stopped_s = None
