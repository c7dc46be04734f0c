"""Gives a loop real-time priority while it holds its rate and leaves others enough of a processor.

The console and other work on a site's machine then cannot delay the loop. A loop with permanent real-time priority
could block the console, through which STOP passes. Therefore a loop has real-time priority only while it is on time
and needs at most MOST_WORK of one processor. A loop that is behind has ordinary priority. On a machine that carries
one site, the rest of every processor is left to ordinary work. On a machine that carries too many, all loops are
behind, and none has real-time priority.
"""

import logging
from collections.abc import Callable

from common.runtime.scheduling import has_real_time, take_ordinary, take_realtime

log = logging.getLogger(__name__)

MOST_WORK = 0.7
"""Maximum share of one processor for a loop's thread at real-time priority; a site of five fingers needs half."""


class RealtimePriority:
    """Gives the loop's thread real-time priority and takes it back; create and call it in that thread, once a second.

    A policy that something else has set stays unchanged, and so does one that may not be set.

    Attributes:
        first: whether the loop has real-time priority, from this object or from its starter.
    """

    def __init__(
        self,
        take_realtime: Callable[[], bool] = take_realtime,
        take_ordinary: Callable[[], None] = take_ordinary,
    ) -> None:
        self._take_realtime, self._take_ordinary = take_realtime, take_ordinary
        self._refused = False
        self._given = has_real_time()
        self.first = self._given

    def look(self, holds_rate: bool, works: float | None) -> bool:
        """Return whether the loop has real-time priority from now on.

        Args:
            holds_rate: whether the loop makes the required ticks.
            works: share of the time that its thread works; None while it is unknown.
        """
        if self._given:
            return True
        deserved = holds_rate and works is not None and works <= MOST_WORK
        if deserved and not self.first and not self._refused:
            self.first = self._take_realtime()
            self._refused = not self.first
            log.info("the loop has %s priority", "real-time" if self.first else "ordinary")
        elif self.first and not deserved:
            self._take_ordinary()
            self.first = False
            log.info("the loop has ordinary priority again: it is behind, or leaves others too little")
        return self.first
