"""Chooses the word that displays a session's state; outdated information never shows as live."""

import math
from collections.abc import Iterable
from typing import NamedTuple

DISCONNECTED, CONNECTED, ENGAGING, ENGAGED = "disconnected", "connected", "engaging", "engaged"
PAUSED, FAULT, STOPPED = "paused", "fault", "stopped"
LOST = "lost"
"""Both sites were engaged, and the far site is silent: outputs are neutral."""
SILENT = "silent"
"""The process itself is silent, or has ended: its state is unknown."""
ENDED = "ended"
"""State of a process that ended by itself."""
ACTING = frozenset((ENGAGING, ENGAGED))
"""States in which outputs act or are about to act."""


class Source(NamedTuple):
    """Source of the information about a state.

    Attributes:
        age_s: age of its newest report, s; infinite without a report.
        limit_s: age above which the source counts as silent, s.
    """

    age_s: float
    limit_s: float

    @property
    def silent(self) -> bool:
        """Whether its report is too old or has no valid age: an age below 0 is of another clock."""
        return not 0.0 <= self.age_s <= self.limit_s


def shown_state(
    known: str, sources: Iterable[Source] = (), *, link_silent: bool = False, stopping: bool = False
) -> str:
    """Return the word to display for a state. Silence overrides a stop, and a stop overrides active states.

    Args:
        known: the last known state.
        sources: all sources of the state; one silent source makes the state unknown.
        link_silent: whether the far site has been silent for longer than outputs may act.
        stopping: whether an emergency stop was requested and is not cleared.
    """
    if any(source.silent for source in sources):
        return SILENT
    if stopping and known in ACTING | {CONNECTED, PAUSED, FAULT}:
        return STOPPED
    if link_silent and known in ACTING:
        return LOST
    return known


def seconds_old(age_s: float) -> str:
    """Return an age for people, such as `2.0 s old`."""
    return f"{age_s:.1f} s old" if math.isfinite(age_s) else "never heard"
