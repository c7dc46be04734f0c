"""Pages of a console in memory: a site that answers, a journal, and sockets that a test drives."""

import asyncio
import json
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from typing import Any

import msgpack
from starlette.websockets import WebSocketDisconnect

from common.web.access import Visitor
from operator_site.console.examination.journal import Journal
from operator_site.console.model import Console
from operator_site.console.web.answer import Act
from operator_site.console.web.commands import Commands
from operator_site.console.web.pages import Pages

BRIEF = {"state": "connected", "session": 7}


class AnsweringSite:
    """The local control of a site, which answers as the test sets it."""

    def __init__(self) -> None:
        self.asked: list[str] = []
        self.answer: Callable[[], dict[str, Any]] = lambda: dict(BRIEF)
        self.fails: Exception | None = None

    def ask(self, verb: str, details: dict[str, Any] | None = None) -> "Future[dict[str, Any]]":
        self.asked.append(verb)
        answered: Future[dict[str, Any]] = Future()
        if self.fails is None:
            answered.set_result(self.answer())
        else:
            answered.set_exception(self.fails)
        return answered


class MemoryJournal(Journal):
    """A journal that keeps its records in memory."""

    def __init__(self) -> None:
        super().__init__(None, {})
        self.kept: list[tuple[str, dict[str, Any]]] = []

    def write(self, stream: str, now_s: float, record: dict[str, Any]) -> None:
        self.kept.append((stream, record))
        msgpack.packb(record)  # the recording takes it

    def of(self, stream: str) -> list[dict[str, Any]]:
        return [record for kept_in, record in self.kept if kept_in == stream]


OR_1, STUDENT = Visitor("OR-1", "act"), Visitor("student", "observe")


def ask(ident: int, verb: str, **details: object) -> str:
    """A page's request."""
    return json.dumps({"kind": "ask", "id": ident, "verb": verb, "details": details})


class Socket:
    """A page that sends the test's messages. It leaves when it is closed, or after its last message if it `leaves`."""

    def __init__(self, *said: str | bytes, leaves: bool = False) -> None:
        self.said: asyncio.Queue[str | bytes | Exception] = asyncio.Queue()
        for one in said:
            self.said.put_nowait(one)
        self.leaves = leaves
        self.sent: list[dict[str, Any]] = []
        self.pictures = 0
        self.closed: int | None = None

    async def receive_text(self) -> str | bytes:
        await asyncio.sleep(0)
        if self.leaves and self.said.empty():
            for _ in range(20):  # the last request is answered meanwhile
                await asyncio.sleep(0.001)
            raise WebSocketDisconnect
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

    async def close(self, code: int = 1000, reason: str | None = None) -> None:
        self.closed = code
        self.said.put_nowait(WebSocketDisconnect())

    @property
    def answers(self) -> list[dict[str, Any]]:
        return [message for message in self.sent if message["kind"] == "answer"]


class Room:
    """Pages of a running site or of a recording, at a time that stands still."""

    def __init__(self, played: Mapping[str, Act] | None = None) -> None:
        self.site, self.now_s = AnsweringSite(), 100.0
        self.commands = Commands(Console(), MemoryJournal(), None if played else self.site, played)
        self.pages = Pages(self.commands, self.clock_s, self.clock_s)
        self._serving: list[asyncio.Task[None]] = []

    def clock_s(self) -> float:
        return self.now_s

    def serve(self, visitor: Visitor, *said: str | bytes) -> Socket:
        """A page that comes, says this and goes."""
        socket = Socket(*said, leaves=True)
        asyncio.run(self.pages.serve(socket, visitor))
        return socket

    async def enter(self, visitor: Visitor) -> Socket:
        """A page that comes and stays."""
        socket = Socket()
        self._serving.append(asyncio.create_task(self.pages.serve(socket, visitor)))
        await asyncio.sleep(0.0)  # it has a place now, or none
        return socket

    async def stop(self, page: Socket) -> None:
        page.said.put_nowait(ask(1, "estop"))
        await settled(lambda: any(answer["ok"] for answer in page.answers))

    async def empty(self) -> None:
        for serving in self._serving:
            serving.cancel()
        await asyncio.gather(*self._serving, return_exceptions=True)


async def settled(reached: Callable[[], object]) -> None:
    """Let everything else run until this is reached."""
    for _ in range(2000):
        if reached():
            return
        await asyncio.sleep(0.0)
    raise AssertionError("it was not reached")
