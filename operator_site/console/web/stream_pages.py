"""Serves the pages of a stream beside the session, each over a websocket and in tasks of its own."""

import asyncio
import json
import time
from abc import ABC, abstractmethod
from collections import deque
from collections.abc import Callable, Coroutine
from contextlib import suppress
from typing import Any, Generic, Protocol, TypeVar

from starlette.websockets import WebSocketDisconnect

from common.link.rate_limiter import RateLimiter
from common.runtime.containment import Containment
from common.web.access import Visitor
from operator_site.console.web.clients import AWAKE_S
from operator_site.console.web.pages import (
    FULL,
    MESSAGES_AT_ONCE,
    MESSAGES_PER_S,
    NOT_UNDERSTOOD,
    TOO_MUCH,
    PageSocket,
    message_of,
)
from operator_site.console.web.places import ACTING_PLACES, OBSERVING_PLACES


class StreamPage(Protocol):
    """One page of a stream."""

    visitor: Visitor
    queue: deque[bytes]
    """Messages that are to be sent."""


Page = TypeVar("Page", bound=StreamPage)


class StreamPages(ABC, Generic[Page]):
    """Pages of one stream; for use in the server's own thread only."""

    def __init__(self, contain: Containment, clock_s: Callable[[], float] = time.monotonic):
        """Begin without pages; `contain` contains errors of one page, so that the others are served."""
        self._contain, self._clock_s = contain, clock_s
        self._pages: dict[Page, asyncio.Event] = {}
        self._heard_s: dict[Page, float] = {}
        """Time of the newest message of each page, or of its coming, s."""
        self._reading: dict[Page, asyncio.Task[None]] = {}

    @abstractmethod
    def _new(self, visitor: Visitor) -> Page:
        """Return the state of a new page."""

    @abstractmethod
    def _take(self, page: Page, message: dict[str, Any]) -> None:
        """Take a message of a page; raises KeyError, TypeError or ValueError where it is not understood."""

    def _take_bytes(self, page: Page, packed: bytes) -> None:
        """Take a binary message of a page; raises ValueError where it is not understood."""
        raise ValueError("no page sends binary messages here")

    def _left(self, page: Page) -> None:
        """Note that a page has left."""

    async def serve(self, socket: PageSocket, visitor: Visitor) -> None:
        """Serve one page of an accepted visitor until the page leaves."""
        if not self._make_place(visitor):
            await socket.close(FULL)
            return
        page, ready = self._new(visitor), asyncio.Event()
        self._pages[page], self._heard_s[page] = ready, self._clock_s()
        what = type(self).__name__
        reading = asyncio.create_task(self._side(f"{what}, reading", self._read(socket, page)))
        writing = asyncio.create_task(self._side(f"{what}, writing", self._write(socket, page, ready)))
        self._reading[page] = reading
        try:
            await asyncio.wait((reading, writing), return_when=asyncio.FIRST_COMPLETED)
        finally:
            reading.cancel()
            writing.cancel()
            if page in self._pages:
                self._leave(page)

    def _make_place(self, visitor: Visitor) -> bool:
        """Return whether there is a place for a new page; the one that was silent longest leaves it, asleep or lost."""
        same = [page for page in self._pages if page.visitor.role == visitor.role]
        if len(same) < (ACTING_PLACES if visitor.role == "act" else OBSERVING_PLACES):
            return True
        silent = min(same, key=self._heard_s.__getitem__)
        if self._clock_s() - self._heard_s[silent] <= AWAKE_S:
            return False
        self._reading[silent].cancel()
        self._leave(silent)
        return True

    def _leave(self, page: Page) -> None:
        del self._pages[page], self._heard_s[page], self._reading[page]
        self._left(page)

    async def _side(self, what: str, doing: Coroutine[Any, Any, None]) -> None:
        # RuntimeError: closed during a send
        with self._contain.step(what, latches=False), suppress(WebSocketDisconnect, RuntimeError):
            await doing

    async def _read(self, socket: PageSocket, page: Page) -> None:
        messages = RateLimiter(MESSAGES_PER_S, MESSAGES_AT_ONCE)
        while True:
            message = await message_of(socket)
            self._heard_s[page] = self._clock_s()
            if not messages.allows(self._clock_s()):
                await socket.close(TOO_MUCH, "too many messages")
                return
            try:
                if isinstance(message, bytes):
                    self._take_bytes(page, message)
                else:
                    self._take(page, json.loads(message))
            except (ValueError, KeyError, TypeError, RecursionError):
                await socket.close(NOT_UNDERSTOOD)
                return

    async def _write(self, socket: PageSocket, page: Page, ready: asyncio.Event) -> None:
        while True:
            await ready.wait()
            ready.clear()
            while page.queue:
                await socket.send_bytes(page.queue.popleft())
