"""Runs the console's process, which serves pages of a running site or of a recording."""

import asyncio
import contextlib
import logging
import socket as sockets
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing
from functools import partial
from pathlib import Path
from typing import Any

import uvicorn
from starlette.applications import Starlette

from common.config.file import to_toml
from common.config.models import ConsoleCameraConfig, ConsoleConfig, OperatorLinkConfig
from common.link.keys import KeyPair, fingerprint, load_keys
from common.runtime.containment import Containment
from common.runtime.status_file import StatusFile
from common.runtime.systemd_notify import Supervisor
from operator_site.console.camera.camera import Camera
from operator_site.console.camera.camera_socket import CameraSocket
from operator_site.console.examination.journal import Journal
from operator_site.console.interval import Interval
from operator_site.console.live import LiveConsole
from operator_site.console.local_control import LocalControlClient
from operator_site.console.playback.player import PlayedConsole
from operator_site.console.web.access import Access
from operator_site.console.web.connections import IDLE_S, Connections, most_connections, raise_descriptor_limit
from operator_site.console.web.door import Door, Stages
from operator_site.console.web.server import application
from operator_site.session.console_feed import FeedReader
from operator_site.session.remote_key import remote_public_key

log = logging.getLogger(__name__)

_LOOK_S = 0.008
"""Interval between two reads of the site's feed, s; a batch waits at most this long."""
_SECOND_S = 1.0
"""Interval between two writes of the status file, s."""
_LARGEST_MESSAGE = 256 * 1024
"""Largest message from a page, bytes; it fits a note of 10 000 characters with twelve bytes each."""
_LARGEST_HEAD = 16 * 1024
"""Largest head of a request, bytes."""
_BACKLOG = 4096
"""Maximum number of connections that the operating system queues until they are accepted."""
_DROP_S = 0.25
"""Interval between two searches for expired connections, s."""


class _Server(uvicorn.Server):
    """Leaves signals to the process."""

    @contextlib.contextmanager
    def capture_signals(self) -> Iterator[None]:
        """Capture no signals."""
        yield


def run_console(config: ConsoleConfig, stop: Callable[[], bool]) -> None:
    """Serve the page of a running site until `stop()`.

    Raises:
        ValueError, OSError: the access settings are unsafe, the port is in use, the keys are unusable, or the
            recording cannot be created.
    """
    # The emergency stop passes through this process, so it keeps its priority on a busy machine (decision 0041).
    with ExitStack() as opened:
        access = Access(config)
        keys = load_keys(config.keys)
        feed = FeedReader(config.feed_port, keys)
        opened.callback(feed.close)
        site = LocalControlClient(config.desk_port, keys)
        opened.callback(site.close)
        journal = Journal(config.record, {"configuration": to_toml(config), "key": fingerprint(keys.public)})
        opened.callback(journal.close)
        camera = None if config.camera is None else opened.enter_context(closing(_camera(config, config.camera, keys)))
        _serve(LiveConsole(config, feed, site, journal, camera=camera), config, access, stop, opened)


def _camera(config: ConsoleConfig, camera: ConsoleCameraConfig, keys: KeyPair) -> Camera:
    link = OperatorLinkConfig(
        keys=config.keys, host=camera.host, base_port=camera.base_port, remote_key=camera.remote_key
    )
    line = CameraSocket(camera.host, camera.base_port, keys, remote_public_key(link))
    return Camera(line, required=camera.required)


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
    app = application(access, shown.pages, shown.camera_pages, config.reports, lambda: {"ok": True})
    log.info("the page is at %s", address)

    def each_second() -> None:
        figures = shown.figures()
        contained = {"contained": dict(shown.pages.contain.places)}
        status.write(0.0, {**about, **figures, **contained})
        supervisor.alive(f"{figures['clients']} pages")

    with Supervisor() as supervisor, contextlib.suppress(KeyboardInterrupt):
        supervisor.ready()
        asyncio.run(_run(shown, config, app, socket, stop, each_second))


def _bound(config: ConsoleConfig) -> sockets.socket:
    try:
        return sockets.create_server((config.bind, config.port), backlog=_BACKLOG)
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
    contain = shown.pages.contain
    asyncio.get_running_loop().set_exception_handler(partial(_name, contain))
    connections = Connections(most_connections(raise_descriptor_limit()))
    server = _Server(
        uvicorn.Config(
            Stages(app, connections, contain),
            log_config=None,
            log_level="error",
            access_log=False,
            lifespan="off",
            http="h11",
            h11_max_incomplete_event_size=_LARGEST_HEAD,
            timeout_keep_alive=round(IDLE_S),
            ws="websockets-sansio",
            ws_max_size=_LARGEST_MESSAGE,
            ws_per_message_deflate=False,
            server_header=False,
            timeout_graceful_shutdown=1,
            ssl_certfile=config.certificate,
            ssl_keyfile=config.certificate_key,
        )
    )
    server.config.load()
    door = Door(socket, server, connections)
    serving = asyncio.create_task(server.serve(sockets=[]))
    second, drop = Interval(_SECOND_S), Interval(_DROP_S)
    try:
        while not stop() and not serving.done():
            now_s = time.monotonic()
            with contain.step("showing", latches=False):
                shown.step(now_s)
            if drop(now_s):
                door.step()
            if second(now_s):
                with contain.step("status", latches=False):
                    each_second()
            await asyncio.sleep(_LOOK_S)
    finally:
        door.close()
        server.should_exit = True
        await serving


def _name(contain: Containment, loop: asyncio.AbstractEventLoop, context: dict[str, Any]) -> None:
    """Report the error of a connection outside a request; a client that has left is no error."""
    error = context.get("exception")
    if not isinstance(error, Exception):
        loop.default_exception_handler(context)
    elif not isinstance(error, OSError):
        contain.caught("connection", error, latches=False)
