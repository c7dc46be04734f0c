"""Whether a loop comes before all ordinary work: while it holds its rate, and leaves others enough of a processor.

A console, its pages and whatever else runs on a site's machine then cannot make the loop late. The other way round a
loop that always came first could keep the console from being served, and STOP passes through it. So a loop has
real-time priority only while it is known to need no more than MOST_WORK of one processor, and to be on time; one that
is behind stands in line like everybody else. That leaves the rest of every processor to ordinary work on a machine
that carries one site; on one that carries too many, all of them are behind, and none comes first.
"""

import logging
from collections.abc import Callable

from common.runtime.scheduling import come_first, has_real_time, stand_in_line

log = logging.getLogger(__name__)

MOST_WORK = 0.7
"""Share of one processor that a loop's thread may need at real-time priority. A site of five fingers needs half."""


class RealtimePriority:
    """Gives the loop's thread real-time priority and takes it back; called from that thread, once a second.

    Where it is not allowed, or somebody else has already chosen a policy, that stays as it is. Made in that thread.

    Attributes:
        first: whether the loop has it, from here or from whoever started it.
    """

    def __init__(
        self, come_first: Callable[[], bool] = come_first, stand_in_line: Callable[[], None] = stand_in_line
    ) -> None:
        self._come_first, self._stand_in_line = come_first, stand_in_line
        self._refused = False
        self._given = has_real_time()
        self.first = self._given

    def look(self, holds_rate: bool, works: float | None) -> bool:
        """Return whether the loop comes first from now on.

        Args:
            holds_rate: whether the loop makes the ticks that it should.
            works: share of the time that its thread works; None while it is not known.
        """
        if self._given:
            return True
        deserved = holds_rate and works is not None and works <= MOST_WORK
        if deserved and not self.first and not self._refused:
            self.first = self._come_first()
            self._refused = not self.first
            log.info("the loop has %s priority", "real-time" if self.first else "ordinary")
        elif self.first and not deserved:
            self._stand_in_line()
            self.first = False
            log.info("the loop has ordinary priority again: it is behind, or leaves others too little")
        return self.first
