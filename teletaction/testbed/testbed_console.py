"""Run a console beside a session on a virtual clock, with its pages in memory. Needs the extra `console`."""

import asyncio
from collections import deque
from collections.abc import Callable, MutableMapping
from typing import Any

from common.config.page_models import ConsoleConfig
from common.timing.interval import Interval
from common.web.access import Visitor
from operator_site.console.examination.journal import Journal
from operator_site.console.live import LiveConsole
from teletaction.testbed.memory_feed import MemoryFeed
from teletaction.testbed.testbed import Testbed

_LOOK_S = 0.008
"""Interval between two steps of the console, s, as in its own process."""
_TURNS = 10
"""Turns of the event loop in a step of the session; reading a page's message and sending its answer needs fewer."""


class VirtualLoop(asyncio.SelectorEventLoop):
    """An event loop with timers on a virtual clock."""

    def __init__(self, now_s: Callable[[], float]) -> None:
        """Take the time from `now_s()`, s."""
        self._virtual_s = now_s
        super().__init__()

    def time(self) -> float:
        """Return the virtual time, s."""
        return self._virtual_s()


class MemorySocket:
    """The websocket of one page of the console.

    Attributes:
        sent: texts, pictures and tiles that the page has not taken yet, oldest first.
        closed: code with which the console closed the socket; None while it is open.
    """

    def __init__(self) -> None:
        """Start without messages."""
        self._said: asyncio.Queue[MutableMapping[str, Any]] = asyncio.Queue()
        self.sent: deque[str | bytes] = deque()
        self.closed: int | None = None

    def say(self, text: str) -> None:
        """Send a text from the page."""
        self._said.put_nowait({"type": "websocket.receive", "text": text})

    def leave(self) -> None:
        """Close the page."""
        self._said.put_nowait({"type": "websocket.disconnect", "code": 1001})

    async def receive(self) -> MutableMapping[str, Any]:
        """As `operator_site.console.web.pages.PageSocket.receive`."""
        return await self._said.get()

    async def send_text(self, data: str) -> None:
        """As `operator_site.console.web.pages.PageSocket.send_text`."""
        self.sent.append(data)

    async def send_bytes(self, data: bytes) -> None:
        """As `operator_site.console.web.pages.PageSocket.send_bytes`."""
        self.sent.append(data)

    async def close(self, code: int = 1000, reason: str | None = None) -> None:
        """As `operator_site.console.web.pages.PageSocket.close`."""
        self.closed = code


class TestbedConsole:
    """The console's process, stepped with the session on the clock of the operator's host.

    Its record, if any, is a real file. The time at which a finding is saved depends on the disk of this machine.

    Attributes:
        shown: the console.
    """

    __test__ = False

    def __init__(self, bed: Testbed, feed: MemoryFeed, config: ConsoleConfig) -> None:
        """Begin beside a session that writes to `feed`; raises OSError where the record cannot be created."""
        self._bed, self._look = bed, Interval(_LOOK_S)
        self._keeping = Journal(config.record, {})
        list(feed.receive())  # a console receives no data from before its start
        self.shown = LiveConsole(config, feed, bed.desks["operator"], self._keeping, self._now_s)
        self._runner = asyncio.Runner(loop_factory=lambda: VirtualLoop(self._now_s))
        self._serving: set[asyncio.Task[None]] = set()
        bed.beside.append(self._step)

    def _now_s(self) -> float:
        return self._bed.operator_clock.now_ns(self._bed.time_s) * 1e-9

    def enter(self, visitor: Visitor) -> MemorySocket:
        """Open a page; the console's messages collect in its socket."""
        socket = MemorySocket()
        serving = self._runner.get_loop().create_task(self._serve(socket, visitor))
        self._serving.add(serving)
        serving.add_done_callback(self._serving.discard)
        return socket

    async def _serve(self, socket: MemorySocket, visitor: Visitor) -> None:
        with self.shown.pages.contain.step("request", latches=False):
            await self.shown.pages.serve(socket, visitor)

    def _step(self) -> None:
        self._runner.get_loop().run_until_complete(self._turn())

    async def _turn(self) -> None:
        now_s = self._now_s()
        if self._look(now_s):
            self.shown.step(now_s)
        for _ in range(_TURNS):
            await asyncio.sleep(0.0)

    def close(self) -> None:
        """End the process and finish its record; its pages receive nothing more."""
        self._bed.beside.remove(self._step)
        self._runner.close()
        self._keeping.close()
