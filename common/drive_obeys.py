"""Does a module apply the drive that it is told? Finds a command path that is stuck, from the module's own reports."""

from collections import deque
from dataclasses import dataclass, field

MEMORY_S = 0.15
"""A command may still be in force this long after the next one was sent: line, module, and its report back."""
PERSIST_S = 0.10
"""So long every report must be of a drive that was never asked for."""
LONGEST_S = 0.02
"""Of the time between two reports no more counts: a site that stood still meanwhile reads what is long over."""


@dataclass(slots=True)
class DriveObeys:
    """Watches one drive of one module. Pure: numbers and times, s, in."""

    name: str
    """Of the drive, for people."""
    _told: deque[tuple[float, int]] = field(default_factory=deque)
    _wrong_s: float = 0.0
    """How long it has been wrong, as far as it was watched."""
    _reported_s: float | None = None
    """When it was wrong last; None after a report that was right."""

    def told(self, t_s: float, drive: int) -> None:
        """The module was sent a command."""
        self._told.append((t_s, drive))
        self._forget(t_s)  # a module that is away for hours reports nothing, and is told all the same

    def reported(self, t_s: float, drive: int) -> str:
        """The module reported what it applies; returns what is wrong with that, empty when nothing is.

        No drive at all is always right: the module's own time-out and temperature limit may do so.
        """
        self._forget(t_s)
        if drive == 0 or any(drive == told for _, told in self._told):
            self._wrong_s, self._reported_s = 0.0, None
            return ""
        if self._reported_s is not None:
            self._wrong_s += min(t_s - self._reported_s, LONGEST_S)
        self._reported_s = t_s
        return f"{self.name} is driven with {drive}, never asked for" if self._wrong_s >= PERSIST_S - 1e-9 else ""

    def _forget(self, t_s: float) -> None:
        while len(self._told) > 1 and t_s - self._told[1][0] > MEMORY_S:
            self._told.popleft()
