"""Searches the growing map of a session for lumps, in a thread of its own."""

import math
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from typing import Any

from operator_site.console.map.lump_areas import lumps_of
from operator_site.console.map.tactile_map import TactileMap

SEARCH_S = 5.0
"""Interval between two searches, s. One takes a third of a second of processor time with 200 places."""


class LumpSearch:
    """Keeps the lumps of the newest search.

    A search would delay the pages, so that it runs in a thread, on a copy of the samples.

    Attributes:
        lumps: lumps of the newest search, see `lump_areas.lumps_in`.
    """

    def __init__(self, executor: Executor | None = None) -> None:
        """Search in a thread of `executor`, or in one of its own."""
        self.lumps: list[dict[str, Any]] = []
        self._executor = executor or ThreadPoolExecutor(1, "lumps")
        self._began_s = -math.inf
        self._running: Future[list[dict[str, Any]]] | None = None
        self._searched: tuple[int, int] | None = None

    def step(self, now_s: float, surface: TactileMap, number: int) -> None:
        """Take the result of a search that has ended, and begin a search if one is due.

        Args:
            now_s: time, s.
            surface: the map.
            number: number of the map; another number is another map.

        Raises:
            ValueError: the search has failed.
        """
        if self._searched is not None and self._searched[0] != number:
            self.lumps, self._running, self._searched = [], None, None
        if self._running is not None:
            if not self._running.done():
                return
            running, self._running = self._running, None
            self.lumps = running.result()
        if self._searched != (number, surface.revision) and now_s - self._began_s >= SEARCH_S:
            self._began_s, self._searched = now_s, (number, surface.revision)
            self._running = self._executor.submit(lumps_of, surface.stiffness.rows())
