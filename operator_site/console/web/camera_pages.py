"""Relays the camera's pictures to all pages."""

from typing import Any

from common.web.access import Visitor
from operator_site.console.camera.camera_picture import Picture
from operator_site.console.web.stream_pages import StreamPages
from operator_site.console.web.viewer import Viewer


class CameraPages(StreamPages[Viewer]):
    """Relays pictures."""

    @property
    def wants_key(self) -> bool:
        """Whether a page waits for a key picture."""
        return any(viewer.wants_key for viewer in self._pages)

    def show(self, picture: Picture) -> None:
        """Offer a picture to all pages."""
        for viewer, ready in self._pages.items():
            if viewer.offer(picture):
                ready.set()

    def restart(self, pictures: list[Picture], *, waiting: bool = False) -> None:
        """Show a key picture and all that follow it to all pages, or only to those that are `waiting` for one."""
        for viewer, ready in self._pages.items():
            if not waiting or viewer.wants_key:
                viewer.restart(pictures)
                ready.set()

    def _new(self, visitor: Visitor) -> Viewer:
        return Viewer(visitor)

    def _take(self, page: Viewer, message: dict[str, Any]) -> None:
        kind = message["kind"]
        if kind == "drawn":
            page.drew(message.get("sequence"))
        elif kind == "lost":
            page.lost()
