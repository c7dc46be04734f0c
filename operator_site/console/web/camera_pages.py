"""Relays the camera's pictures to all pages, each over a websocket and a task of its own."""

import asyncio
import json
import logging
import time
from collections.abc import Callable, Coroutine
from contextlib import suppress
from typing import Any

from starlette.websockets import WebSocketDisconnect

from common.link.rate_limiter import RateLimiter
from common.runtime.containment import Containment
from common.web.access import Visitor
from operator_site.console.camera.camera_picture import Picture
from operator_site.console.web.pages import (
    FULL,
    MESSAGES_AT_ONCE,
    MESSAGES_PER_S,
    NOT_UNDERSTOOD,
    TOO_MUCH,
    PageSocket,
    text_of,
)
from operator_site.console.web.places import ACTING_PLACES, OBSERVING_PLACES
from operator_site.console.web.viewer import Viewer

log = logging.getLogger(__name__)


class CameraPages:
    """Relays pictures; for use in the server's own thread only."""

    def __init__(self, contain: Containment, clock_s: Callable[[], float] = time.monotonic):
        """Begin without pages.

        Args:
            contain: contains errors of one page, so that the others are served.
            clock_s: this machine's monotonic clock, s.
        """
        self._contain, self._clock_s = contain, clock_s
        self._viewers: dict[Viewer, asyncio.Event] = {}

    @property
    def wants_key(self) -> bool:
        """Whether a page waits for a key picture."""
        return any(viewer.wants_key for viewer in self._viewers)

    def show(self, picture: Picture) -> None:
        """Offer a picture to all pages."""
        for viewer, ready in self._viewers.items():
            if viewer.offer(picture):
                ready.set()

    def restart(self, pictures: list[Picture], *, waiting: bool = False) -> None:
        """Show a key picture and all that follow it to all pages, or only to those that are `waiting` for one."""
        for viewer, ready in self._viewers.items():
            if not waiting or viewer.wants_key:
                viewer.restart(pictures)
                ready.set()

    async def serve(self, socket: PageSocket, visitor: Visitor) -> None:
        """Serve one page of an accepted visitor until the page leaves."""
        same = sum(viewer.visitor.role == visitor.role for viewer in self._viewers)
        if same >= (ACTING_PLACES if visitor.role == "act" else OBSERVING_PLACES):
            await socket.close(FULL)
            return
        viewer, ready = Viewer(visitor), asyncio.Event()
        self._viewers[viewer] = ready
        sides = [
            asyncio.create_task(self._side("camera page, reading", self._read(socket, viewer))),
            asyncio.create_task(self._side("camera page, writing", self._write(socket, viewer, ready))),
        ]
        try:
            await asyncio.wait(sides, return_when=asyncio.FIRST_COMPLETED)
        finally:
            for side in sides:
                side.cancel()
            del self._viewers[viewer]

    async def _side(self, what: str, doing: Coroutine[Any, Any, None]) -> None:
        # RuntimeError: closed during a send
        with self._contain.step(what, latches=False), suppress(WebSocketDisconnect, RuntimeError):
            await doing

    async def _read(self, socket: PageSocket, viewer: Viewer) -> None:
        messages = RateLimiter(MESSAGES_PER_S, MESSAGES_AT_ONCE)
        while True:
            text = await text_of(socket)
            if not messages.allows(self._clock_s()):
                await socket.close(TOO_MUCH, "too many messages")
                return
            try:
                message = json.loads(text)
                kind = message["kind"]
            except (ValueError, KeyError, TypeError, RecursionError):
                await socket.close(NOT_UNDERSTOOD)
                return
            if kind == "drawn":
                viewer.drew(message.get("sequence"))
            elif kind == "lost":
                viewer.lost()

    async def _write(self, socket: PageSocket, viewer: Viewer, ready: asyncio.Event) -> None:
        while True:
            await ready.wait()
            ready.clear()
            while viewer.queue:
                await socket.send_bytes(viewer.queue.popleft())
