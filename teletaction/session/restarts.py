"""Schedules restarts of a process with growing pauses, up to a largest number."""

from dataclasses import dataclass

FIRST_PAUSE_S = 0.2
"""Pause before the first restart, s. Each further pause is twice as long."""
MOST = 6
"""Largest number of restarts in a row. The last one follows a pause of 6.4 s."""
SETTLED_S = 60.0
"""Running time after which the count of restarts in a row returns to 0, s."""


@dataclass(slots=True)
class Restarts:
    """Restarts of one process. Times are arguments, s, of any monotonic clock.

    Attributes:
        count: restarts in a row.
    """

    count: int = 0
    _started_s: float = 0.0
    _due_s: float | None = None

    def ended(self, now_s: float) -> float | None:
        """Take the end of the process; return the pause until its restart, s, or None for no restart.

        Call again during the pause to get the remaining time. At 0 or less, start the process and call `started`.
        """
        if self._due_s is None:
            if now_s - self._started_s >= SETTLED_S:
                self.count = 0
            if self.count >= MOST:
                return None
            self._due_s = now_s + FIRST_PAUSE_S * 2.0**self.count
            self.count += 1
        return self._due_s - now_s

    def started(self, now_s: float) -> None:
        """Take the restart of the process."""
        self._started_s, self._due_s = now_s, None
