"""A page without a browser: it sends the messages of the real page to the console, and keeps the answers."""

import asyncio
import json
import math
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from ssl import SSLContext
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from websockets.asyncio.client import ClientConnection, connect
from websockets.typing import Origin

from operator_site.console.map.map_tiles import MapTile
from operator_site.console.state.frame import Frame, Kind
from tests.unit.operator_site.console.page_messages import read_frame, read_tile

PATIENCE_S = 20.0
_ALIVE_S = 0.5
HOSTILE = "<script>document.title='x'</script> \u202eevil \x00 \U0001f4a5 & \" ' {{7*7}} \\u0000"
"""A text that no part of the console may take for anything but text."""


class Connection(Protocol):
    """What connects a page with a console."""

    def now_s(self) -> float:
        """The page's clock, s."""

    def send(self, text: str) -> None:
        """Send a message."""

    def recv(self, timeout: float) -> str | bytes:
        """The next message; TimeoutError where none comes in time, s."""

    def close(self) -> None:
        """The page goes."""


class WebsocketConnection:
    """A websocket that is read only when it is asked, by the thread that asks.

    The client of the library that has no event loop reads in a thread of its own. Over TLS that is not safe before
    Python 3.13: once a handshake ended without an answer while the other thread wrote.
    """

    def __init__(self, runner: asyncio.Runner, socket: ClientConnection):
        self._runner, self._socket = runner, socket

    def now_s(self) -> float:
        return time.monotonic()

    def send(self, text: str) -> None:
        self._runner.run(self._socket.send(text))

    def recv(self, timeout: float) -> str | bytes:
        async def receive() -> str | bytes:
            async with asyncio.timeout(timeout):
                return await self._socket.recv()

        return self._runner.run(receive())

    def close(self) -> None:
        self._runner.run(self._socket.close())


class Page:
    """One connection. `draws` is False for a page that never gets round to drawing."""

    def __init__(self, connection: Connection, draws: bool = True):
        self.connection = connection
        self.draws, self.visible = draws, True
        self.state: dict[str, Any] = {}
        self.states = 0
        self.picture: Frame | None = None
        self.whole: Frame | None = None
        """The newest that had all bins."""
        self.pictures: Counter[Kind] = Counter()
        self.undrawn = 0
        self.bins: list[int] = []
        """Numbers of all bins that came, in their order."""
        self.tiles: list[MapTile] = []
        self.answers: dict[int, dict[str, Any]] = {}
        self._asked = 0
        self._alive_s = -math.inf

    def now_s(self) -> float:
        return self.connection.now_s()

    def send(self, **said: Any) -> None:
        self.connection.send(json.dumps(said))

    def ask(self, verb: str, /, **details: Any) -> dict[str, Any]:
        """Ask for something; what was answered, and within 0.5 s, of which 0.2 are for a busy machine."""
        self._asked += 1
        number, asked_s = self._asked, self.now_s()
        self.send(kind="ask", id=number, verb=verb, details=details)
        self.until(lambda: number in self.answers, f"an answer to {verb}")
        assert self.now_s() - asked_s < 0.5 or verb == "estop"
        return self.answers[number]

    def until(self, reached: Callable[[], object], what: str, seconds: float = PATIENCE_S) -> None:
        end_s = self.now_s() + seconds
        while not reached():
            assert self.now_s() < end_s, f"{what} did not come: {self.state}"
            self.turn()

    def look(self, seconds: float) -> None:
        """Only look on."""
        end_s = self.now_s() + seconds
        while self.now_s() < end_s:
            self.turn()

    def turn(self) -> None:
        """Take one message, if one comes soon, and say that there is somebody."""
        if self.now_s() - self._alive_s > _ALIVE_S:
            self._alive_s = self.now_s()
            self.send(kind="alive", visible=self.visible, sequence=0 if self.picture is None else self.picture.sequence)
        try:
            message = self.connection.recv(timeout=0.02)
        except TimeoutError:
            return
        if isinstance(message, str):
            self._take(json.loads(message))
        elif message[3] == Kind.TILE:
            self.tiles.append(read_tile(message))
        else:
            self._pictured(read_frame(message))

    def _take(self, message: dict[str, Any]) -> None:
        if message["kind"] == "answer":
            self.answers[message["id"]] = message
        else:
            self.state, self.states = message, self.states + 1

    def _pictured(self, picture: Frame) -> None:
        self.picture = picture
        self.pictures[picture.kind] += 1
        newest = round(picture.time_s * 30.0) - 1
        bins = range(newest - len(picture.bins) + 1, newest + 1)
        self.whole = picture if picture.kind is Kind.WHOLE else self.whole
        self.bins = [*bins] if picture.kind is Kind.WHOLE else [*self.bins, *bins]
        if self.draws:
            self.send(kind="drawn", sequence=picture.sequence)
        else:
            self.undrawn += 1


def ready(page: Page) -> None:
    """Wait until all devices are there and nothing is latched; take control, begin, say that sound was heard."""
    page.until(lambda: page.state, "a state")
    if not page.state["you"]["in_control"]:
        assert page.ask("take_control")["ok"]
    page.until(lambda: page.state["session"]["state"] not in ("disconnected",), "a session")
    if page.state["session"]["state"] in ("stopped", "fault"):
        page.until(lambda: page.state["stop"] is None or page.state["stop"]["confirmed"], "a confirmation")
        assert page.ask("clear_fault")["ok"]
    page.until(lambda: page.state["session"]["state"] in ("connected", "paused", "engaged"), "no fault")
    assert page.ask("sound", answer="heard")["ok"]
    if page.state["session"]["pseudonym"] is None:
        assert page.ask("begin", pseudonym="P-0417")["ok"]
    page.until(lambda: all(device["ready"] for device in page.state["devices"]), "all devices")


def engage(page: Page) -> None:
    """Engage the session from this page."""
    ready(page)
    if page.state["session"]["state"] != "engaged":
        page.until(lambda: page.state["engage"]["refusal"] == "", "readiness")
        answer = page.ask("engage")
        assert answer["ok"], answer
    page.until(lambda: page.state["session"]["state"] == "engaged", "engaged")


def newest_tiles(page: Page) -> dict[tuple[str, int, int], NDArray[np.uint16]]:
    """Values of the newest tile of each quantity, column and row."""
    return {(tile.quantity, tile.column, tile.row): tile.value for tile in page.tiles}


@contextmanager
def opened(
    address: str, path: str = "/session", draws: bool = True, ssl: SSLContext | None = None, **headers: str
) -> Iterator[Page]:
    """A page of the console at this address; over TLS, trusting what `ssl` trusts."""
    origin = headers.pop("Origin", address)
    url = address.replace("http", "ws", 1) + path

    async def begin() -> ClientConnection:
        return await connect(url, origin=Origin(origin), additional_headers=headers, max_size=1 << 20, ssl=ssl)

    with asyncio.Runner() as runner:
        connection = WebsocketConnection(runner, runner.run(begin()))
        try:
            yield Page(connection, draws)
        finally:
            connection.close()
