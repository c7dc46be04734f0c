"""A console in the browser beside a session on the test bed that has explored a scene: virtual devices and time."""

import asyncio
import queue
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import cast

import uvicorn
from starlette.websockets import WebSocket, WebSocketDisconnect

from common.config.file import load_config
from common.config.page_models import ConsoleConfig
from common.runtime.containment import Containment
from common.web.access import Access, Visitor
from operator_site.console.web.camera_pages import CameraPages
from operator_site.console.web.pages import Pages
from operator_site.console.web.server import application
from operator_site.console.web.voice_pages import VoicePages
from teletaction.session.demo_files import CONSOLE, DemoOptions, prepare
from teletaction.testbed.memory_feed import MemoryFeed
from teletaction.testbed.testbed import SessionConfigs, Testbed
from teletaction.testbed.testbed_console import MemorySocket, TestbedConsole
from teletaction.testbed.virtual_recording import recorded_testbed
from tests.system.page import Page, engage, ready
from tests.virtual.console import VirtualConnection

LONGEST_S = 1000.0
"""Longest virtual time of an exploration, s."""
LOOK_S = 0.01
"""Virtual time between two exchanges with the browser, s."""


class _Page:
    """Carries messages between a browser's websocket and the console, whose threads differ."""

    def __init__(self, visitor: Visitor) -> None:
        self.visitor = visitor
        self.said: queue.SimpleQueue[str | None] = queue.SimpleQueue()
        """Texts of the page; None when it has left."""
        self.sent: asyncio.Queue[str | bytes] = asyncio.Queue()
        self.loop = asyncio.get_running_loop()
        self.socket: MemorySocket | None = None

    def step(self, console: TestbedConsole) -> bool:
        """Pass on what waits, in the thread of the test bed; returns whether the page is still there."""
        if self.socket is None:
            self.socket = console.enter(self.visitor)
        while not self.said.empty():
            text = self.said.get()
            if text is None:
                self.socket.leave()
                return False
            self.socket.say(text)
        while self.socket.sent:
            self.loop.call_soon_threadsafe(self.sent.put_nowait, self.socket.sent.popleft())
        return True


class RunningTestbed:
    """A session whose examination was begun, whose hand does its script, and which then pauses for a browser.

    Attributes:
        folder: has the recordings of both sites and of the console.
        url: where the page is.
        explored: set once the session has paused, or has failed.
    """

    def __init__(self, options: DemoOptions, folder: Path) -> None:
        """Prepare a session with a console; `options.seconds` is the duration of the exploration, s."""
        self.folder = folder
        self.explored, self._ends = threading.Event(), threading.Event()
        self._options = options
        self._files = prepare(options, folder)
        self._config = load_config(self._files[CONSOLE], ConsoleConfig)
        self._entering: queue.SimpleQueue[_Page] = queue.SimpleQueue()
        access, camera = Access(self._config), CameraPages(Containment())
        app = application(
            access,
            cast(Pages, self),
            camera,
            VoicePages(Containment(), lambda: None),
            self._config.reports,
        )
        config = uvicorn.Config(
            app, host="127.0.0.1", port=0, log_level="error", lifespan="off", ws="websockets-sansio"
        )
        self._server = uvicorn.Server(config)
        self._threads = [threading.Thread(target=run, daemon=True) for run in (self._server.run, self._run)]
        self._failed: BaseException | None = None

    @property
    def url(self) -> str:
        """Address of the page."""
        return f"http://127.0.0.1:{self._server.servers[0].sockets[0].getsockname()[1]}"

    async def serve(self, socket: WebSocket, visitor: Visitor) -> None:
        """Serve one page, as `Pages.serve` does."""
        page = _Page(visitor)
        self._entering.put(page)
        sending = asyncio.create_task(_send(socket, page))
        try:
            while True:
                page.said.put(await socket.receive_text())
        except (WebSocketDisconnect, RuntimeError):
            page.said.put(None)
        finally:
            sending.cancel()

    def start(self) -> None:
        """Run the server and the session."""
        for thread in self._threads:
            thread.start()
        while not self._server.started:
            time.sleep(0.01)

    def close(self) -> None:
        """End both; the recordings are complete then.

        Raises:
            BaseException: what ended the session early.
        """
        self._ends.set()
        self._server.should_exit = self._server.force_exit = True
        for thread in self._threads:
            thread.join()
        if self._failed is not None:
            raise self._failed

    def _run(self) -> None:
        try:
            feed = MemoryFeed()
            with recorded_testbed(SessionConfigs.read(self._files), self._options.seed, feed=feed) as bed:
                console = TestbedConsole(bed, feed, self._config)
                self._explore(bed, console)
                self.explored.set()
                self._serve_pages(bed, console)
                console.close()
        except BaseException as error:
            self._failed = error
            self.explored.set()

    def _explore(self, bed: Testbed, console: TestbedConsole) -> None:
        """Begin and engage from a page without a browser, which keeps up with the virtual time."""
        page = Page(VirtualConnection(bed, console.enter(Visitor("assistant", "act"))))
        ready(page)
        engage(page)
        page.until(lambda: bed.sim_operator.hand.finished, "the end of the script", LONGEST_S)
        assert page.ask("disengage")["ok"]
        page.until(lambda: page.state["session"]["state"] == "paused", "the pause")
        page.connection.close()

    def _serve_pages(self, bed: Testbed, console: TestbedConsole) -> None:
        """Continue in real time, or slower; nothing moves, so that long steps do."""
        pages: list[_Page] = []
        begun_s, from_s = time.monotonic(), bed.time_s
        while not self._ends.is_set():
            bed.run_coarsely(LOOK_S)
            while not self._entering.empty():
                pages.append(self._entering.get())
            pages = [page for page in pages if page.step(console)]
            ahead_s = bed.time_s - from_s - (time.monotonic() - begun_s)
            if ahead_s > 0.0:
                self._ends.wait(ahead_s)


async def _send(socket: WebSocket, page: _Page) -> None:
    while True:
        message = await page.sent.get()
        if isinstance(message, str):
            await socket.send_text(message)
        else:
            await socket.send_bytes(message)


@contextmanager
def running(options: DemoOptions, folder: Path) -> Iterator[RunningTestbed]:
    """Run a session beside its console until the block ends."""
    session = RunningTestbed(options, folder)
    session.start()
    try:
        yield session
    finally:
        session.close()
