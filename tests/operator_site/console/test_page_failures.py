"""Pages that idle or fail leave the others alone: places are kept, what one page raises ends no other."""

import asyncio
import json
from collections.abc import Callable
from typing import Any, cast

import pytest
from starlette.websockets import WebSocket, WebSocketDisconnect

from operator_site.console.access import Visitor
from operator_site.console.acts import Acts
from operator_site.console.clients import AWAKE_S, Client
from operator_site.console.console import Console
from operator_site.console.control import Control
from operator_site.console.pages import FAILED, FULL, REPLACED, Pages
from tests.conftest import Contained
from tests.operator_site.console.test_acts import Desk, Keeper

OPERATOR, STUDENT = Visitor("OR-1", "act"), Visitor("student", "observe")


class Socket:
    """A page that says what a test lets it, and goes when it is closed."""

    def __init__(self) -> None:
        self.said: asyncio.Queue[str | Exception] = asyncio.Queue()
        self.sent: list[dict[str, Any]] = []
        self.pictures = 0
        self.closed: int | None = None

    async def receive_text(self) -> str:
        said = await self.said.get()
        if isinstance(said, Exception):
            raise said
        return said

    async def receive(self) -> dict[str, Any]:
        said = await self.receive_text()
        return {"type": "websocket.receive", "text" if isinstance(said, str) else "bytes": said}

    async def send_text(self, text: str) -> None:
        self.sent.append(json.loads(text))

    async def send_bytes(self, packed: bytes) -> None:
        self.pictures += 1

    async def close(self, code: int, reason: str | None = None) -> None:
        self.closed = code
        self.said.put_nowait(WebSocketDisconnect())

    @property
    def stopped(self) -> bool:
        return any(told.get("ok") for told in self.sent if told["kind"] == "answer")


class Room:
    """Pages in front of a desk, at a time that stands still."""

    def __init__(self) -> None:
        self.desk, self.console, self.control, self.now_s = Desk(), Console(), Control(), 100.0
        acts = Acts(self.console, self.desk, Keeper(), self.control, None)
        self.pages = Pages(lambda: self.console, acts, self.control, lambda: self.now_s)
        self.pages._now_s = lambda: self.now_s
        self._serving: list[asyncio.Task[None]] = []

    async def enter(self, visitor: Visitor) -> Socket:
        socket = Socket()
        serving = self.pages.serve(
            cast(WebSocket, socket), lambda number: Client(visitor, f"{visitor.name} {number}", self.now_s)
        )
        self._serving.append(asyncio.create_task(serving))
        await settled(lambda: bool(socket.closed) or len(self._serving) == self.pages._count)
        return socket

    async def stop(self, page: Socket) -> None:
        page.said.put_nowait(json.dumps({"kind": "ask", "id": 1, "verb": "estop", "details": {}}))
        await settled(lambda: page.stopped)

    async def empty(self) -> None:
        for serving in self._serving:
            serving.cancel()
        await asyncio.gather(*self._serving, return_exceptions=True)


async def settled(reached: Callable[[], bool]) -> None:
    """Let everything else run until this is reached."""
    for _ in range(2000):
        if reached():
            return
        await asyncio.sleep(0.0)
    raise AssertionError("it was not reached")


def in_room(course: Callable[[Room], Any]) -> None:
    async def run() -> None:
        room = Room()
        try:
            await course(room)
        finally:
            await room.empty()

    asyncio.run(run())


@pytest.mark.parametrize("visitor", [STUDENT, OPERATOR])
def test_idle_pages_do_not_keep_the_operator_out(visitor: Visitor) -> None:
    async def course(room: Room) -> None:
        idle = [await room.enter(visitor) for _ in range(40)]
        room.now_s += AWAKE_S + 1.0
        page = await room.enter(OPERATOR)
        await room.stop(page)
        assert page.closed is None
        assert len(room.pages.clients) <= 20
        sent_away = {socket.closed for socket in idle} - {None}
        assert sent_away <= {REPLACED, FULL}

    in_room(course)


def test_a_page_that_is_replaced_is_sent_away_and_control_stays() -> None:
    async def course(room: Room) -> None:
        pages = [await room.enter(OPERATOR) for _ in range(7)]
        await settled(lambda: pages[1].closed is not None)
        assert [page.closed for page in pages] == [None, REPLACED, None, None, None, None, None]
        assert room.control.name == "OR-1 1"

    in_room(course)


def test_a_page_whose_socket_fails_is_sent_away_and_the_others_stay(contained: Contained) -> None:
    async def course(room: Room) -> None:
        first, other = await room.enter(OPERATOR), await room.enter(OPERATOR)
        first.said.put_nowait(KeyError("text"))
        await settled(lambda: first.closed is not None)
        assert first.closed == FAILED
        assert room.control.name == "OR-1 2"
        await room.stop(other)
        assert other.closed is None

    in_room(course)
    (name,) = contained.take()
    assert "KeyError" in name


def test_a_picture_that_cannot_be_drawn_leaves_stop_and_state(
    contained: Contained, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(*_: object) -> bytes:
        raise ValueError("no picture")

    async def course(room: Room) -> None:
        page = await room.enter(OPERATOR)
        monkeypatch.setattr(Console, "picture", broken)
        for _ in range(3):
            room.pages.show(None)
            await asyncio.sleep(0.0)
        await room.stop(page)
        assert page.pictures == 0
        monkeypatch.undo()
        room.pages.show(None)
        await settled(lambda: page.pictures == 1)

    in_room(course)
    (name,) = contained.take()
    assert "no picture" in name
