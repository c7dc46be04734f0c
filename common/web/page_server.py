"""Runs a page's server and the process's own work in one loop."""

import asyncio
import contextlib
import socket as sockets
import ssl
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from typing import Any

import uvicorn
from starlette.applications import Starlette

from common.config.page_models import WebConfig
from common.files.whole_file import read_whole
from common.link.host_name import bracketed, is_ipv6
from common.runtime.containment import Containment
from common.timing.interval import Interval
from common.web.access import AccessProblem
from common.web.connections import IDLE_S, Connections, most_connections, raise_descriptor_limit
from common.web.door import Door, Stages

_SECOND_S = 1.0
"""Interval between two calls of `each_second`, s."""
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


def bound(config: WebConfig) -> sockets.socket:
    """Return a socket that listens at the page's address.

    Raises:
        AccessProblem: the certificate or its key cannot be used.
        OSError: the port is in use.
    """
    _check_certificate(config)
    family = sockets.AF_INET6 if is_ipv6(config.bind) else sockets.AF_INET
    try:
        return sockets.create_server((config.bind, config.port), family=family, backlog=_BACKLOG)
    except OSError as error:
        raise OSError(f"{config.bind}:{config.port} (page): {error.strerror}; choose another port") from None


def _check_certificate(config: WebConfig) -> None:
    """Raise AccessProblem, which names the file, where the server could not use the certificate or its key."""
    certificate, key = config.certificate, config.certificate_key
    if certificate is None or key is None:
        return
    try:
        for file in (certificate, key):
            read_whole(file)
        # Without a password, the library would ask for one at the terminal.
        ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER).load_cert_chain(certificate, key, password="")
    except ssl.SSLError as error:
        why = error.reason.lower().replace("_", " ") if error.reason else "not PEM, or the key has a password"
        raise AccessProblem(f"{certificate} and {key} are no certificate and its key: {why}") from None
    except OSError as error:
        raise AccessProblem(f"{file}: {error.strerror}") from None


def address_of(config: WebConfig, socket: sockets.socket) -> str:
    """Return the page's address for a browser."""
    scheme = "http" if config.certificate is None else "https"
    host, port = socket.getsockname()[:2]
    return config.address or f"{scheme}://{bracketed(host)}:{port}"


@dataclass(frozen=True, slots=True)
class Work:
    """What a process does beside serving its page.

    Attributes:
        stop: whether to end.
        step: the process's own work, called with the monotonic time, s.
        every_s: time between two steps, s.
        each_second: called once a second.
    """

    stop: Callable[[], bool]
    step: Callable[[float], object]
    every_s: float
    each_second: Callable[[], object]


def serve_page(app: Starlette, config: WebConfig, socket: sockets.socket, contain: Containment, work: Work) -> None:
    """Serve `app` at `socket`, which is from `bound`, until `work.stop()`, or until Ctrl-C."""
    with contextlib.suppress(KeyboardInterrupt):
        asyncio.run(_run(app, config, socket, contain, work))


async def _run(app: Starlette, config: WebConfig, socket: sockets.socket, contain: Containment, work: Work) -> None:
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
        while not work.stop() and not serving.done():
            now_s = time.monotonic()
            with contain.step("showing", latches=False):
                work.step(now_s)
            if drop(now_s):
                with contain.step("connections", latches=False):
                    door.step()
            if second(now_s):
                with contain.step("status", latches=False):
                    work.each_second()
            await asyncio.sleep(work.every_s)
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
