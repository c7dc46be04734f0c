"""Relays the camera's pictures to all pages, and still pictures to those that cannot decode the stream."""

import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from common.runtime.containment import Containment
from common.web.access import Visitor
from operator_site.console.camera.camera_picture import Picture
from operator_site.console.camera.still_process import StillProcess
from operator_site.console.camera.stills import Stills
from operator_site.console.web.stream_pages import StreamPages

CREDIT = 4
"""Maximum number of pictures sent to a page and not yet drawn; with more, the page waits for a key picture."""


@dataclass(slots=True, eq=False)
class Viewer:
    """Controls the flow of pictures to one page, so that no queue forms before a slow one.

    A page that came or that lost a picture waits for a key picture.

    Attributes:
        visitor: user of the page.
        stills: whether the page shows still pictures, because its browser cannot decode the stream.
        waits_for_key: whether the page can decode key pictures only.
        queue: messages that are to be sent.
    """

    visitor: Visitor
    stills: bool = False
    waits_for_key: bool = True
    queue: deque[bytes] = field(default_factory=deque)
    _undrawn: deque[int] = field(default_factory=deque)

    @property
    def has_credit(self) -> bool:
        """Whether a picture may be sent: a page of still pictures has drawn the last one."""
        return len(self._undrawn) < (1 if self.stills else CREDIT)

    @property
    def wants_key(self) -> bool:
        """Whether a key picture would be sent."""
        return self.waits_for_key and self.has_credit

    def offer(self, picture: Picture) -> bool:
        """Queue a picture if the page can decode it and has credit; return whether it was queued."""
        full = not self.has_credit
        if full or (self.waits_for_key and not picture.is_key):
            self.waits_for_key = self.waits_for_key or full
            return False
        self.waits_for_key = False
        self._undrawn.append(picture.sequence)
        self.queue.append(picture.encode())
        return True

    def restart(self, pictures: list[Picture]) -> None:
        """Queue a key picture and all that follow it, as after a jump; they count as one until the last is drawn."""
        self.lost()
        if pictures:
            self.waits_for_key = False
            self._undrawn.append(pictures[-1].sequence)
            self.queue.extend(picture.encode() for picture in pictures)

    def drew(self, sequence: object) -> None:
        """Note that the page has drawn a picture, which acknowledges all earlier ones."""
        if sequence in self._undrawn:
            while self._undrawn.popleft() != sequence:
                pass

    def lost(self) -> None:
        """Note that the page cannot decode what follows."""
        self.waits_for_key = True
        self.queue.clear()
        self._undrawn.clear()


class CameraPages(StreamPages[Viewer]):
    """Relays pictures."""

    def __init__(self, contain: Containment, clock_s: Callable[[], float] = time.monotonic):
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
