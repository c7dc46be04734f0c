"""The one word that may be shown of a session: never more than is live."""

import math
from collections.abc import Iterable
from typing import NamedTuple

DISCONNECTED, CONNECTED, ENGAGING, ENGAGED = "disconnected", "connected", "engaging", "engaged"
PAUSED, FAULT, STOPPED = "paused", "fault", "stopped"
LOST = "lost"
"""Both sites were engaged, and the far one is silent: outputs are neutral."""
SILENT = "silent"
"""The process itself is silent, or has ended: its state is not known."""
ENDED = "ended"
"""The last word of a process that ended by itself."""
ACTING = frozenset((ENGAGING, ENGAGED))
"""These words say that outputs act, or are about to."""


class Source(NamedTuple):
    """Where a state is known from.

    Attributes:
        age_s: of the newest word from there, s; infinite when none ever came.
        limit_s: an older word is silence, s.
    """

    age_s: float
    limit_s: float

    @property
    def silent(self) -> bool:
        """Whether its word is too old, or has no sound age: one below 0 is of another clock."""
        return not 0.0 <= self.age_s <= self.limit_s


def shown_state(
    known: str, sources: Iterable[Source] = (), *, link_silent: bool = False, stopping: bool = False
) -> str:
    """The word to show for a state that was known once. Silence wins over a stop, a stop over all that acts.

    Args:
        known: the last known state.
        sources: all that it is known from; one that is silent makes the state unknown.
        link_silent: nothing has come from the far site for longer than outputs may act on.
        stopping: an emergency stop was asked for and is not cleared.
    """
    if any(source.silent for source in sources):
        return SILENT
    if stopping and known in ACTING | {CONNECTED, PAUSED, FAULT}:
        return STOPPED
    if link_silent and known in ACTING:
        return LOST
    return known


def seconds_old(age_s: float) -> str:
    """An age for people, such as `2.0 s old`."""
    return f"{age_s:.1f} s old" if math.isfinite(age_s) else "never heard"
