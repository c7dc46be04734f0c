"""Searches the growing map of a session for lumps and for the next place to press, in a thread of its own."""

import math
from collections.abc import Hashable
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from typing import Any, NamedTuple

from operator_site.console.map.lump_areas import Floats, field_of, lumps_of, next_press_mm
from operator_site.console.map.tactile_map import TactileMap

SEARCH_S = 5.0
"""Interval between two searches, s. One takes a third of a second of processor time with 200 places."""


class Searched(NamedTuple):
    """Result of a search: lumps, see `lump_areas.lumps_in`, and the next place to press, mm, None if unknown."""

    lumps: list[dict[str, Any]]
    next_mm: tuple[float, float] | None


NOTHING = Searched([], None)


class LumpSearch:
    """Keeps the result of the newest search.

    A search would delay the pages, so that it runs in a thread, on a copy of the samples.

    Attributes:
        found: result of the newest search.
    """

    def __init__(self, executor: Executor | None = None) -> None:
        """Search in a thread of `executor`, or in one of its own."""
        self.found = NOTHING
        self._executor = executor or ThreadPoolExecutor(1, "lumps")
        self._began_s = -math.inf
        self._running: Future[Searched] | None = None
        self._searched: tuple[Hashable, int] | None = None

    def step(self, now_s: float, surface: TactileMap, number: Hashable) -> None:
        """Take the result of a search that has ended, and begin a search if one is due.

        Args:
            now_s: time, s.
            surface: the map.
            number: identifies the map; another number is another map.

        Raises:
            ValueError: the search has failed.
        """
        if self._searched is not None and self._searched[0] != number:
            if self._running is not None:
                self._running.cancel()
            self.found, self._running, self._searched, self._began_s = NOTHING, None, None, -math.inf
        if self._running is not None:
            if not self._running.done():
                return
            running, self._running = self._running, None
            self.found = running.result()
        if self._searched != (number, surface.revision) and now_s - self._began_s >= SEARCH_S:
            self._began_s, self._searched = now_s, (number, surface.revision)
            self._running = self._executor.submit(_search, surface.stiffness.rows())


def _search(rows: Floats) -> Searched:
    field = field_of(rows)
    return NOTHING if field is None else Searched(lumps_of(field), next_press_mm(field))
