"""The clock of one host in a test bed: virtual time with an offset and a drift of its own."""

from dataclasses import dataclass


@dataclass(slots=True)
class SiteClock:
    """A host's own clock.

    Attributes:
        offset_s: what it shows more than virtual time, s.
        drift: by how much it is fast, s/s.
        stopped_s: virtual time at which it stopped; None while it runs.
    """

    offset_s: float = 0.0
    drift: float = 0.0
    stopped_s: float | None = None

    def now_ns(self, time_s: float) -> int:
        """What this clock shows at a virtual time, ns."""
        running_s = time_s if self.stopped_s is None else self.stopped_s
        return round((running_s * (1.0 + self.drift) + self.offset_s) * 1e9)

    def run_on(self, time_s: float) -> None:
        """Run again from where it stopped, at a virtual time."""
        if self.stopped_s is not None:
            self.offset_s -= (time_s - self.stopped_s) * (1.0 + self.drift)
            self.stopped_s = None
