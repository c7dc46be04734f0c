"""Searches growing data every few seconds, in a thread of its own, and keeps the newest result."""

import math
from collections.abc import Callable
from concurrent.futures import Executor, Future, ThreadPoolExecutor
from typing import Generic, TypeVar

from common.runtime.containment import Containment
from operator_site.console.map.lump_areas import NOTHING, search_lumps
from operator_site.console.model import Console
from operator_site.console.tenderness.tender_search import NOT_SEARCHED, search_tenderness

SEARCH_S = 5.0
"""Interval between two searches, s. One takes up to half a second of processor time."""
Given = TypeVar("Given")
Found = TypeVar("Found")


class BackgroundSearch(Generic[Given, Found]):
    """Keeps the result of the newest search.

    A search would delay the pages, so that it runs in a thread, on a copy of the data.

    Attributes:
        found: result of the newest search.
    """

    def __init__(
        self, name: str, search: Callable[[Given], Found], nothing: Found, executor: Executor | None = None
    ) -> None:
        """Search in a thread of `executor`, or in one of its own.

        Args:
            name: name of the thread.
            search: searches a copy of the data.
            nothing: result before the first search.
            executor: runs the searches.
        """
        self.found = nothing
        self._search, self._nothing = search, nothing
        self._executor = executor or ThreadPoolExecutor(1, name)
        self._began_s = -math.inf
        self._running: Future[Found] | None = None
        self._searched: tuple[int, int] | None = None

    def step(self, now_s: float, number: int, revision: int, given: Callable[[], Given]) -> None:
        """Take the result of a search that has ended, and begin a search if one is due.

        Args:
            now_s: time, s.
            number: identifies the data; another number is other data.
            revision: grows with the data.
            given: copies the data.

        Raises:
            ValueError: the search has failed.
        """
        if self._searched is not None and self._searched[0] != number:
            if self._running is not None:
                self._running.cancel()
            self.found, self._running, self._searched, self._began_s = self._nothing, None, None, -math.inf
        if self._running is not None:
            if not self._running.done():
                return
            running, self._running = self._running, None
            self.found = running.result()
        if self._searched != (number, revision) and now_s - self._began_s >= SEARCH_S:
            self._began_s, self._searched = now_s, (number, revision)
            self._running = self._executor.submit(self._search, given())


class MapSearches:
    """Searches the shown map for lumps, and its presses for the most tender place."""

    def __init__(self, contain: Containment) -> None:
        """Begin without results; `contain` contains a search that fails."""
        self._contain = contain
        self._lumps = BackgroundSearch("lumps", search_lumps, NOTHING)
        self._tender = BackgroundSearch("tenderness", search_tenderness, NOT_SEARCHED)

    def step(self, now_s: float, console: Console) -> None:
        """Begin the searches that are due, and show the newest results on the console."""
        surface, pain, number = console.tactile_map, console.pain, console.map_number
        with self._contain.step("lumps", latches=False):
            self._lumps.step(now_s, number, surface.revision, surface.stiffness.rows)
            console.searched = self._lumps.found
        with self._contain.step("tenderness", latches=False):
            self._tender.step(now_s, number, pain.revision, pain.settled)
            console.tenderness = self._tender.found
