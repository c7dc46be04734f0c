"""The console's process: from the site's feed and desk, or from a recording, to the pages that look at it."""

import asyncio
import contextlib
import logging
import shutil
import socket as sockets
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import Any

import uvicorn
from starlette.applications import Starlette

from common.config import ConsoleConfig, to_toml
from common.keys import fingerprint, load_keys
from common.notify import Supervisor
from common.process import StatusFile
from operator_site.console.access import Access
from operator_site.console.acts import Acts, Control
from operator_site.console.console import Console
from operator_site.console.desk_line import DeskLine, Told
from operator_site.console.keeping import Keeping
from operator_site.console.pages import Pages
from operator_site.console.playback import Recording
from operator_site.console.playing import Player
from operator_site.console.reporting import Reporting
from operator_site.console.server import application
from operator_site.console.shown_state import shown_state
from operator_site.feed import BATCH_S, FeedReader

log = logging.getLogger(__name__)

_LOOK_S = 0.008
"""Between two looks whether the site has fed something: a batch waits no longer before it is shown."""
_STATE_S = 0.1
_ATTEND_S = 0.1
_STOPPING_S = 0.05
"""The site is told of the page, and asked how it is, so often; more often while it stops."""
_KEEP_S = 0.2
_SECOND_S = 1.0
_SLOW_PER_S = 10
"""A page that skips more pictures in a second is slow."""
_LARGEST_MESSAGE = 256 * 1024
"""Bytes from a page: a note of 10 000 characters, each written as twelve."""


class _Server(uvicorn.Server):
    """Leaves signals to the process."""

    @contextlib.contextmanager
    def capture_signals(self) -> Iterator[None]:
        """Capture none."""
        yield


class Due:
    """Says when something is due again. Pure: time is an argument, s; a clock that was set back makes it due."""

    def __init__(self, every_s: float):
        self._every_s, self._at_s = every_s, -float("inf")

    def __call__(self, now_s: float, every_s: float | None = None) -> bool:
        """Whether it is due now, and done by that."""
        if 0.0 <= now_s - self._at_s < (self._every_s if every_s is None else every_s):
            return False
        self._at_s = now_s
        return True


class LiveConsole:
    """Shows a running site."""

    def __init__(self, config: ConsoleConfig, opened: ExitStack):
        """Connect to the site's feed and desk in the background, and open the recording.

        Raises:
            ValueError, OSError: keys cannot be used, or the recording cannot be made.
        """
        keys = load_keys(config.keys)
        self._reader = FeedReader(config.feed_port, keys)
        opened.callback(self._reader.close)
        self._desk = DeskLine(config.desk_port, keys)
        opened.callback(self._desk.close)
        metadata = {"configuration": to_toml(config), "key": fingerprint(keys.public)}
        self.keeping = Keeping(config.record, metadata)
        opened.callback(self.keeping.close)
        self.console = Console()
        control = Control()
        self.acts = Acts(self.console, self._desk, self.keeping, control, None)
        self.pages = Pages(lambda: self.console, self.acts, control)
        self.acts.reporting = Reporting(config.report_command, config.reports)
        self._operator = "operator.toml" if config.operator is None else str(config.operator)
        self._folder = config.record.parent if config.record is not None else Path.cwd()
        self._picture, self._state, self._attend = Due(BATCH_S), Due(_STATE_S), Due(_ATTEND_S)
        self._keep, self._second = Due(_KEEP_S), Due(_SECOND_S)
        self._skipped = 0
        self._answering = False

    def step(self, now_s: float) -> None:
        """Take what came, show what is due."""
        fed = list(self._reader.receive())
        for stream, time_ns, payload in fed:
            self.console.take(stream, time_ns, payload)
        stopping = self.console.site.stop_asked_s is not None and None in self.console.site.stop_after_s.values()
        if not self._answering and self._attend(now_s, _STOPPING_S if stopping else None):
            self._tell_desk()
        if self._second(now_s):
            self._look_around()
        if self._keep(now_s):
            self.keeping.step(now_s)
            for alarm in self.console.alarms.take_changes():
                record = {"id": alarm.ident, "priority": alarm.cause.priority.name.lower(), "text": alarm.text}
                times = {"since_s": alarm.since_s, "ended_s": alarm.ended_s, "cleared_by": alarm.cleared_by}
                self.keeping.write("console/alarm", now_s, {**record, **times, "active": alarm.ended_s is None})
        if self._picture(now_s, 0.5 * BATCH_S if fed else 1.5 * BATCH_S):
            self.console.step(now_s)
            self.acts.step(now_s)
            self.pages.show(self._shown(now_s) if self._state(now_s) else None)

    def figures(self) -> dict[str, object]:
        """What the status file tells."""
        return {
            "clients": len(self.pages.clients),
            "pictures_skipped": sum(client.skipped for client in self.pages.clients),
            "damaged": self.console.damaged,
            "unsaved": self.keeping.unsaved,
        }

    def _shown(self, now_s: float) -> dict[str, Any]:
        state = shown_state(self.console, now_s, self.keeping.is_saved, self._operator)
        state["session"]["saved"] = self.acts.saved
        return {**state, "wall_clock": f"{datetime.now():%H:%M:%S}"}

    def _tell_desk(self) -> None:
        """Tell the site whether somebody watches, and hear how it is; one question at a time."""
        self._answering = True
        loop = asyncio.get_running_loop()
        asked = self._desk.ask("attend", {"seen": self.pages.seen})
        asked.add_done_callback(lambda told: loop.call_soon_threadsafe(self._told, told))

    def _told(self, told: Any) -> None:
        self._answering = False
        answer: Told | None = None if told.cancelled() or told.exception() is not None else told.result()
        self.console.around = replace(self.console.around, desk_answers=answer is not None)
        if answer is not None:
            self.console.desk(time.monotonic(), answer)

    def _look_around(self) -> None:
        holder = self.pages.control.holder
        skipped = 0 if holder is None else holder.skipped
        slow, self._skipped = skipped - self._skipped > _SLOW_PER_S, skipped
        try:
            disk = shutil.disk_usage(self._folder)
            used = disk.used / max(1, disk.used + disk.free)
        except OSError:
            used = 0.0
        failed = self.keeping.enabled and self.keeping.failed
        around = self.console.around
        self.console.around = replace(around, disk_used=used, recording_failed=failed, skipped_lately=slow)


class PlayedConsole:
    """Shows a recording."""

    def __init__(self, path: Path, opened: ExitStack):
        """Open it.

        Raises:
            ValueError, OSError: it cannot be read, or has nothing that a console shows.
        """
        recording = Recording(path)
        opened.callback(recording.close)
        self._player = Player(recording)
        control = Control()
        keeping = Keeping(None, {})
        acts = Acts(self._player.console, None, keeping, control, self._player)
        self.pages = Pages(lambda: self._player.console, acts, control, lambda: self._player.now_s)
        self._acts = acts
        self._picture, self._state = Due(BATCH_S), Due(_STATE_S)

    def step(self, now_s: float) -> None:
        """Play on, show what is due."""
        if not self._picture(now_s):
            return
        if self._player.step(now_s):
            self._acts.show(self._player.console)
            self.pages.begin_anew()
        console = self._player.console
        state = shown_state(console, self._player.now_s, lambda _: True, "") if self._state(now_s) else None
        if state is not None:
            state["session"] |= {"playback": self._player.shown(), "title": self._player.title}
            state["wall_clock"] = self._player.wall_clock
        self.pages.show(state)

    def figures(self) -> dict[str, object]:
        """What the status file tells."""
        return {"clients": len(self.pages.clients)}


def run_console(config: ConsoleConfig, stop: Callable[[], bool]) -> None:
    """Serve the page of a running site until `stop()`.

    Raises:
        ValueError, OSError: the page may not be offered like that, its port is in use, or keys cannot be used.
    """
    with ExitStack() as opened:
        access = Access(config)
        _serve(LiveConsole(config, opened), config, access, stop, opened)


def run_playback(path: Path, port: int, stop: Callable[[], bool]) -> None:
    """Serve the page of a recording on loopback until `stop()`.

    Raises:
        ValueError, OSError: the recording cannot be read, or the port is in use.
    """
    config = ConsoleConfig(keys=Path(), port=port)
    with ExitStack() as opened:
        _serve(PlayedConsole(path, opened), config, Access(config), stop, opened)


def _serve(
    shown: LiveConsole | PlayedConsole,
    config: ConsoleConfig,
    access: Access,
    stop: Callable[[], bool],
    opened: ExitStack,
) -> None:
    socket = opened.enter_context(_bound(config))
    scheme = "http" if config.certificate is None else "https"
    host, port = socket.getsockname()[:2]
    address = config.address or f"{scheme}://{host}:{port}"
    status = StatusFile(config.status, "console")
    about = {"address": address}
    app = application(access, shown.pages, time.monotonic, config.reports, lambda: {"ok": True})
    log.info("the page is at %s", address)

    def each_second() -> None:
        figures = shown.figures()
        status.write(0.0, {**about, **figures})
        told.alive(f"{figures['clients']} pages")

    with Supervisor() as told, contextlib.suppress(KeyboardInterrupt):
        told.ready()
        asyncio.run(_run(shown, config, app, socket, stop, each_second))


def _bound(config: ConsoleConfig) -> sockets.socket:
    try:
        return sockets.create_server((config.bind, config.port))
    except OSError as error:
        raise OSError(f"{config.bind}:{config.port} (page): {error.strerror}; choose another port") from None


async def _run(
    shown: LiveConsole | PlayedConsole,
    config: ConsoleConfig,
    app: Starlette,
    socket: sockets.socket,
    stop: Callable[[], bool],
    each_second: Callable[[], None],
) -> None:
    server = _Server(
        uvicorn.Config(
            app,
            log_config=None,
            log_level="warning",
            access_log=False,
            lifespan="off",
            ws="websockets-sansio",
            ws_max_size=_LARGEST_MESSAGE,
            ws_per_message_deflate=False,
            server_header=False,
            timeout_graceful_shutdown=1,
            ssl_certfile=config.certificate,
            ssl_keyfile=config.certificate_key,
        )
    )
    serving = asyncio.create_task(server.serve(sockets=[socket]))
    second = Due(_SECOND_S)
    try:
        while not stop() and not serving.done():
            now_s = time.monotonic()
            shown.step(now_s)
            if second(now_s):
                each_second()
            await asyncio.sleep(_LOOK_S)
    finally:
        server.should_exit = True
        await serving
