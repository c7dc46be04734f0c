"""Serves all open pages, each with a task that sends the due messages."""

import asyncio
import json
import logging
import time
from collections.abc import Callable, Coroutine, MutableMapping
from contextlib import suppress
from typing import Any, Protocol

from starlette.websockets import WebSocketDisconnect

from common.link.rate_limiter import RateLimiters
from common.web.access import Visitor
from operator_site.console import texts
from operator_site.console.map.map_tiles import changed
from operator_site.console.map.tactile_map import QUANTITIES
from operator_site.console.web.answer import Answer
from operator_site.console.web.clients import Client
from operator_site.console.web.commands import Commands
from operator_site.console.web.page_state import urgent
from operator_site.console.web.places import place_for

log = logging.getLogger(__name__)

FULL, NOT_UNDERSTOOD, TOO_MUCH, REPLACED, FAILED = 4429, 4400, 4408, 4409, 4500
"""Close codes of a page's websocket; 4401 refuses a page without access."""
_CLOSING_S = 1.0
"""Longest wait for a page to take its close code, s."""
MESSAGES_PER_S, MESSAGES_AT_ONCE = 100.0, 300
"""Rate and burst of one page's messages; it reports drawn pictures 30 times a second and sends heartbeats."""
OPENINGS_PER_S, OPENINGS_AT_ONCE = 1.0, 20
"""Rate and burst of pages opened by one observer; a visitor who may act has no such limit."""
REQUESTS_PER_S, REQUESTS_AT_ONCE = 10.0, 40
"""Rate and burst of requests from all pages of one visitor; stops of a visitor who may act are exempt."""
_STOP = '"estop"'
"""Text by which a message may be an emergency stop."""
_LARGEST = 2**53
"""Upper bound of integers that JavaScript represents exactly."""


class PageSocket(Protocol):
    """Accepted websocket of a page.

    The methods that send raise WebSocketDisconnect or RuntimeError if the page is gone.
    """

    async def receive(self) -> MutableMapping[str, Any]:
        """Return the next message of the page, `websocket.receive` or `websocket.disconnect` as in ASGI."""

    async def send_text(self, data: str) -> None:
        """Send an answer or a state."""

    async def send_bytes(self, data: bytes) -> None:
        """Send a picture or a tile."""

    async def close(self, code: int = 1000, reason: str | None = None) -> None:
        """Close the websocket with a code."""


class Pages:
    """Exchanges messages with all pages; for use in the server's own thread only.

    Attributes:
        control: holds the page in control.
        clients: all pages, the longest present first.
        contain: contains errors of one page or one picture, so that the others are served.
    """

    def __init__(self, commands: Commands, shown_s: Callable[[], float], clock_s: Callable[[], float] = time.monotonic):
        """Show a console.

        Args:
            shown_s: returns the shown moment, s of the operator site's clock.
        """
        self._commands, self._shown_s, self._now_s = commands, shown_s, clock_s
        self._sequence = 0
        self.control = commands.control
        self.clients: list[Client] = []
        self.contain = commands.contained
        self._reading: dict[str, asyncio.Task[bool]] = {}
        self._ready: dict[str, asyncio.Event] = {}
        self._state: dict[str, Any] = {}
        self._urgent: object = None
        self._version = 0
        self._pictures: dict[tuple[int | None, int], bytes] = {}
        """Encoded pictures of this step, by the newest bin that a page has and the newest bin."""
        self._count = 0
        self._messages: RateLimiters[str] = RateLimiters(MESSAGES_PER_S, MESSAGES_AT_ONCE)
        self._openings: RateLimiters[Visitor] = RateLimiters(OPENINGS_PER_S, OPENINGS_AT_ONCE)
        self._requests: RateLimiters[Visitor] = RateLimiters(REQUESTS_PER_S, REQUESTS_AT_ONCE)

    def show(self, state: dict[str, Any] | None) -> None:
        """Offer a new picture to all pages, and a new state if there is one."""
        self._pictures.clear()
        self._sequence += 1
        if state is not None:
            self._state, self._urgent = state, urgent(state)
            self._version += 1
        for ready in self._ready.values():
            ready.set()

    def send_everything(self) -> None:
        """Send everything again to all pages, after a jump in a recording."""
        for client in self.clients:
            client.forget_sent()

    @property
    def seen(self) -> bool:
        """Whether a person can see and use the page in control."""
        holder = self.control.holder
        return holder is not None and holder.seen(self._now_s())

    async def serve(self, socket: PageSocket, visitor: Visitor) -> None:
        """Serve one page of an accepted visitor until the page leaves."""
        self._count += 1
        client = Client(visitor, f"{visitor.name} {self._count}", self._now_s())
        if not (client.acts or self._openings.allows(client.visitor, self._now_s())):
            await socket.close(FULL, "too many pages opened")
            return
        place = place_for(client.visitor, self.clients, self.control.holder, self._now_s())
        if not place.given:
            log.info("%s was refused: all places are taken", client.name)
            await socket.close(FULL)
            return
        if place.leaves is not None:
            self._reading[place.leaves.name].cancel()
            self._leave(place.leaves)
        ready = self._ready[client.name] = asyncio.Event()
        self.clients.append(client)
        self.control.offer(client)
        log.info("%s came as %s", client.name, client.visitor.role)
        reading = self._reading[client.name] = asyncio.create_task(self._side("reading", self._read(socket, client)))
        writing = asyncio.create_task(self._side("writing", self._write(socket, client, ready)))
        try:
            await asyncio.wait((reading, writing), return_when=asyncio.FIRST_COMPLETED)
        finally:
            replaced = client not in self.clients
            reading.cancel()
            writing.cancel()
            self._leave(client)
        failed = any(side.done() and not side.cancelled() and side.result() for side in (reading, writing))
        if replaced or failed:
            with suppress(WebSocketDisconnect, RuntimeError, TimeoutError):  # already closed, or not reading
                await asyncio.wait_for(socket.close(REPLACED if replaced else FAILED), _CLOSING_S)

    def _leave(self, client: Client) -> None:
        if client in self.clients:
            self.clients.remove(client)
            del self._ready[client.name], self._reading[client.name]
            self.control.left(client, self.clients)
            log.info("%s went", client.name)

    async def _side(self, what: str, doing: Coroutine[Any, Any, None]) -> bool:
        """Run one side of a page until the page leaves; return whether it failed, which ends this page only."""
        with self.contain.step(what, latches=False):
            with suppress(WebSocketDisconnect):
                await doing
            return False
        return True

    async def _read(self, socket: PageSocket, client: Client) -> None:
        asked: dict[int, asyncio.Task[bool]] = {}
        while True:
            message = await message_of(socket)
            text = message if isinstance(message, str) else ""  # a page of the session sends no binary message
            now_s = self._now_s()
            allowed = self._messages.allows(client.name, now_s)
            if not (allowed or (client.acts and _STOP in text)):
                await socket.close(TOO_MUCH, "too many messages")
                return
            client.heard(now_s)
            try:
                message = json.loads(text)
                kind = message["kind"]
            except (ValueError, KeyError, TypeError, RecursionError):
                await socket.close(NOT_UNDERSTOOD)
                return
            stops = client.acts and kind == "ask" and message.get("verb") == "estop"
            if not (allowed or stops):
                await socket.close(TOO_MUCH, "too many messages")
                return
            match kind:
                case "drawn":
                    client.drew(now_s, _integer(message.get("sequence")))
                case "alive":
                    client.visible = message.get("visible") is True
                case "show":
                    wanted = (message.get("quantity"), message.get("second"))
                    if shown := tuple(dict.fromkeys(name for name in wanted if name in QUANTITIES)):
                        client.show(shown)
                case "ask":
                    ident = _integer(message.get("id"))
                    if not (stops or self._commands.plays or self._requests.allows(client.visitor, now_s)):
                        await socket.close(TOO_MUCH, "too many requests")
                        return
                    if ident not in asked or asked[ident].done():  # a pending stop is requested repeatedly
                        asked = {number: task for number, task in asked.items() if not task.done()}
                        answer = self._side("answering", self._answer(socket, client, ident, message))
                        asked[ident] = asyncio.create_task(answer)
            self._ready[client.name].set()

    async def _answer(self, socket: PageSocket, client: Client, ident: int, message: dict[str, Any]) -> None:
        answer = Answer(False, texts.FAILED_INSIDE)
        with self.contain.step("request", latches=False):
            answer = await self._commands.ask(client, message.get("verb"), message.get("details"), self._shown_s())
        reply = {"kind": "answer", "id": ident, "ok": answer.ok, "text": answer.text, "details": answer.details or {}}
        if not client.answer(reply):
            await socket.close(TOO_MUCH, "too many answers wait")
        if (ready := self._ready.get(client.name)) is not None:  # the page may have left meanwhile
            ready.set()

    async def _write(self, socket: PageSocket, client: Client, ready: asyncio.Event) -> None:
        try:
            while True:
                await ready.wait()
                ready.clear()
                await self._send(socket, client)
        except (WebSocketDisconnect, RuntimeError):  # RuntimeError: closed during a send
            return

    async def _send(self, socket: PageSocket, client: Client) -> None:
        """Send the waiting answers and the due state, picture and tiles; each is made as late as possible."""
        while client.answers:
            await socket.send_text(_json(client.answers.popleft()))
        now_s = self._now_s()
        client.shows(self._commands.console.map_number)
        state, picture, tiles = None, None, list[bytes]()
        with self.contain.step("state", latches=False):
            state = self._next_state(client, now_s)
        if state is not None:
            await socket.send_text(state)
        with self.contain.step("picture", latches=False):
            picture = self._next_picture(client, now_s)
        if picture is not None:
            await socket.send_bytes(picture)
        with self.contain.step("tiles", latches=False):
            tiles = self._next_tiles(client, now_s)
        for tile in tiles:
            await socket.send_bytes(tile)

    def _next_state(self, client: Client, now_s: float) -> str | None:
        urgency = self._urgent, self.control.name
        if not self._state or not client.wants_state(now_s, urgency):
            return None
        client.sent_state(now_s, urgency)
        return _json(self._state_for(client))

    def _next_picture(self, client: Client, now_s: float) -> bytes | None:
        if not client.has_credit(now_s, self._sequence):
            return None
        console, shown_s = self._commands.console, self._shown_s()
        newest = console.signals.newest_bin(shown_s)
        if (client.last_bin, newest) not in self._pictures:
            picture = console.picture(shown_s, self._sequence, client.last_bin)
            self._pictures[client.last_bin, newest] = picture
        packed = self._pictures[client.last_bin, newest]
        client.sent_picture(self._sequence, newest)
        return packed

    def _next_tiles(self, client: Client, now_s: float) -> list[bytes]:
        surface = self._commands.console.tactile_map
        if not client.wants_tiles(now_s, surface.revision):
            return []
        if not client.tiles:
            for quantity in client.quantities:
                client.tiles.extend(changed(surface, quantity, client.tile_revision))
            client.tile_revision = surface.revision
        return [tile.encode() for tile in client.next_tiles(now_s)]

    def _state_for(self, client: Client) -> dict[str, Any]:
        you = {
            "role": client.visitor.role,
            "name": client.name,
            "in_control": self.control.holder is client,
            "control": self.control.name,
        }
        about = {"pictures_skipped": client.skipped, "clients": len(self.clients)}
        return {"kind": "state", "version": self._version, **self._state, "you": you, "console": about}


async def message_of(socket: PageSocket) -> str | bytes:
    """Return the next message of a page.

    Raises:
        WebSocketDisconnect: the page is gone.
    """
    message = await socket.receive()
    if message["type"] == "websocket.disconnect":
        raise WebSocketDisconnect(message.get("code", 1006), message.get("reason"))
    text: str | None = message.get("text")
    return message.get("bytes") or b"" if text is None else text


def _json(message: dict[str, Any]) -> str:
    return json.dumps(message, ensure_ascii=False, allow_nan=False, separators=(",", ":"))


def _integer(value: object) -> int:
    return value if isinstance(value, int) and not isinstance(value, bool) and abs(value) < _LARGEST else -1
