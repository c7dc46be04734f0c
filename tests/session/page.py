"""A page without a browser: it speaks the console's websocket as the real one does, and remembers what it was told."""

import asyncio
import json
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from ssl import SSLContext
from typing import Any

from websockets.asyncio.client import ClientConnection, connect
from websockets.typing import Origin

from operator_site.console.map_tiles import MapTile
from operator_site.console.picture import Kind, Picture

PATIENCE_S = 20.0
_ALIVE_S = 0.5


class Connection:
    """A websocket that is read only when it is asked, by the thread that asks.

    The client of the library that has no event loop reads in a thread of its own. Over TLS that is not safe before
    Python 3.13: once a handshake ended without an answer while the other thread wrote.
    """

    def __init__(self, runner: asyncio.Runner, socket: ClientConnection):
        self._runner, self._socket = runner, socket

    def send(self, text: str) -> None:
        self._runner.run(self._socket.send(text))

    def recv(self, timeout: float | None = None) -> str | bytes:
        """The next message; TimeoutError where none comes in time, s."""

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
        self.picture: Picture | None = None
        self.whole: Picture | None = None
        """The newest that had all bins."""
        self.pictures: Counter[Kind] = Counter()
        self.undrawn = 0
        self.bins: list[int] = []
        """Numbers of all bins that came, in their order."""
        self.tiles: list[MapTile] = []
        self.answers: dict[int, dict[str, Any]] = {}
        self._asked = 0
        self._alive_s = 0.0

    def send(self, **said: Any) -> None:
        self.connection.send(json.dumps(said))

    def ask(self, verb: str, /, **details: Any) -> dict[str, Any]:
        """Ask for something; what was answered, and within 0.5 s, of which 0.2 are for a busy machine."""
        self._asked += 1
        number, asked_s = self._asked, time.monotonic()
        self.send(kind="ask", id=number, verb=verb, details=details)
        self.until(lambda: number in self.answers, f"an answer to {verb}")
        assert time.monotonic() - asked_s < 0.5 or verb == "estop"
        return self.answers[number]

    def until(self, reached: Callable[[], object], what: str, seconds: float = PATIENCE_S) -> None:
        end_s = time.monotonic() + seconds
        while not reached():
            assert time.monotonic() < end_s, f"{what} did not come: {self.state}"
            self.turn()

    def look(self, seconds: float) -> None:
        """Only look on."""
        end_s = time.monotonic() + seconds
        while time.monotonic() < end_s:
            self.turn()

    def turn(self) -> None:
        """Take one message, if one comes soon, and say that there is somebody."""
        if time.monotonic() - self._alive_s > _ALIVE_S:
            self._alive_s = time.monotonic()
            self.send(kind="alive", visible=self.visible, sequence=0 if self.picture is None else self.picture.sequence)
        try:
            message = self.connection.recv(timeout=0.02)
        except TimeoutError:
            return
        if isinstance(message, str):
            self._told(json.loads(message))
        elif message[3] == Kind.TILE:
            self.tiles.append(MapTile.decode(message))
        else:
            self._pictured(Picture.decode(message))

    def _told(self, told: dict[str, Any]) -> None:
        if told["kind"] == "answer":
            self.answers[told["id"]] = told
        else:
            self.state, self.states = told, self.states + 1

    def _pictured(self, picture: Picture) -> None:
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
        connection = Connection(runner, runner.run(begin()))
        try:
            yield Page(connection, draws)
        finally:
            connection.close()
