"""Relays the camera's pictures to all pages, and still pictures to those that cannot decode the stream."""

import time
from collections.abc import Callable
from typing import Any

from common.runtime.containment import Containment
from common.web.access import Visitor
from operator_site.console.camera.camera_picture import Picture
from operator_site.console.camera.still_process import StillProcess
from operator_site.console.camera.stills import Stills
from operator_site.console.web.stream_pages import StreamPages
from operator_site.console.web.viewer import Viewer


class CameraPages(StreamPages[Viewer]):
    """Relays pictures."""

    def __init__(self, contain: Containment, clock_s: Callable[[], float] = time.monotonic):
        """Begin without pages.

        Args:
            contain: contains errors of one page, so that the others are served.
            clock_s: this machine's monotonic clock, s.
        """
        super().__init__(contain, clock_s)
        self._process = StillProcess()
        self._stills = Stills(self._process.make)

    @property
    def wants_key(self) -> bool:
        """Whether a page waits for a key picture."""
        waits = any(viewer.wants_key for viewer in self._pages if not viewer.stills)
        return waits or (bool(self._still_pages) and self._stills.wants_key)

    @property
    def _still_pages(self) -> list[Viewer]:
        return [viewer for viewer in self._pages if viewer.stills]

    def show(self, picture: Picture) -> None:
        """Offer a picture to all pages."""
        for viewer, ready in self._pages.items():
            if not viewer.stills and viewer.offer(picture):
                ready.set()
        if self._still_pages:
            self._stills.take(picture)

    def restart(self, pictures: list[Picture], *, waiting: bool = False) -> None:
        """Show a key picture and all that follow it to all pages, or only to those that are `waiting` for one."""
        for viewer, ready in self._pages.items():
            if not viewer.stills and (not waiting or viewer.wants_key):
                viewer.restart(pictures)
                ready.set()
        if self._still_pages and (not waiting or self._stills.wants_key):
            self._stills.clear()
            for picture in pictures:
                self._stills.take(picture)

    def step(self) -> None:
        """Send the still picture that was made since the last call, and begin the next one if it is due."""
        pages = self._still_pages
        made = self._stills.step(self._clock_s(), wanted=any(viewer.has_credit for viewer in pages))
        if made is not None:
            for viewer in pages:
                self._offer(viewer, made)

    def close(self) -> None:
        """End the making of still pictures."""
        self._process.close()

    def _offer(self, viewer: Viewer, still: Picture) -> None:
        if viewer.offer(still):
            self._pages[viewer].set()

    def _new(self, visitor: Visitor) -> Viewer:
        return Viewer(visitor)

    def _left(self, page: Viewer) -> None:
        if not self._still_pages:
            self._stills.clear()

    def _take(self, page: Viewer, message: dict[str, Any]) -> None:
        kind = message["kind"]
        if kind == "drawn":
            page.drew(message.get("sequence"))
        elif kind == "lost":
            page.lost()
        elif kind == "still":
            page.lost()
            page.stills = True
            if self._stills.newest is not None:
                self._offer(page, self._stills.newest)
