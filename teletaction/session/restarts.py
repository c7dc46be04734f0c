"""When a process that ended is started again: after a pause that grows, and so many times at most."""

from dataclasses import dataclass

FIRST_PAUSE_S = 0.2
"""Before the first new start; each further pause is twice as long."""
MOST = 6
"""New starts in a row; the last comes after 6.4 s."""
SETTLED_S = 60.0
"""A process that ran for this long is counted anew."""


@dataclass(slots=True)
class Restarts:
    """Of one process. Pure: time is an argument, s of any steady clock.

    Attributes:
        count: new starts in a row.
    """

    count: int = 0
    _started_s: float = 0.0
    _due_s: float | None = None

    def ended(self, now_s: float) -> float | None:
        """The process has ended; returns the pause until its new start, s, and None where there will be none.

        Called again while the pause lasts, it returns what is left of it; 0 or less: start it, and call `started`.
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
        """It runs again."""
        self._started_s, self._due_s = now_s, None
