"""Accepts the connections of a page's server, and drops those that block others.

uvicorn serves HTTP on the accepted connections. Its own listener is not used: it does not limit connections that send
nothing, and it does not see a connection before the TLS handshake is complete.
"""

import asyncio
import itertools
import logging
import socket as sockets
from contextlib import suppress

from starlette.types import ASGIApp, Message, Receive, Scope, Send
from starlette.websockets import WebSocketDisconnect
from uvicorn import Server
from uvicorn.protocols.http.h11_impl import H11Protocol

from common.runtime.containment import Containment
from common.web.connections import IDLE_S, Connections, Stage

log = logging.getLogger(__name__)

_KEY = "connection"
"""Name of the connection in the state of a request."""
_AT_ONCE = 16
"""Connections accepted in one turn of the server's loop; far fewer than the maximum, so that it reads requests, too."""
_RETRY_S = 0.1
"""Wait after the operating system refused to accept a connection, s."""


class Accepted:
    """An accepted connection."""

    def __init__(self, socket: sockets.socket):
        self._socket = socket
        self._transport: asyncio.Transport | None = None
        self._serving: asyncio.Task[None] | None = None

    @property
    def is_open(self) -> bool:
        """Whether the connection still holds a file descriptor."""
        return self._socket.fileno() >= 0

    @property
    def unsent_bytes(self) -> int:
        """Number of bytes that wait until the client reads."""
        if self._transport is None or self._transport.is_closing():  # one of TLS that has ended has no buffer
            return 0
        return self._transport.get_write_buffer_size()

    def serve(self, server: Server) -> None:
        """Serve the connection: first the TLS handshake, if the server has a certificate."""
        self._serving = asyncio.create_task(self._serve(server))
        self._serving.add_done_callback(self._begun)

    def drop(self) -> None:
        """Close the connection at once; nothing more is sent."""
        if self._transport is not None:
            self._transport.abort()
        elif self._serving is not None:
            self._serving.cancel()
        else:
            self._socket.close()

    async def _serve(self, server: Server) -> None:
        loop, tls = asyncio.get_running_loop(), server.config.ssl
        protocol = H11Protocol(server.config, server.server_state, {_KEY: self}, loop)
        limit_s = None if tls is None else IDLE_S
        self._transport, _ = await loop.connect_accepted_socket(
            lambda: protocol, self._socket, ssl=tls, ssl_handshake_timeout=limit_s
        )

    def _begun(self, serving: asyncio.Task[None]) -> None:
        self._serving = None  # otherwise this task's error, which holds 256 KiB of the TLS handshake, holds itself
        error = None if serving.cancelled() else serving.exception()
        if serving.cancelled() or error is not None:  # dropped, or the TLS handshake failed
            self._socket.close()
        if error is not None:
            serving.get_loop().call_exception_handler({"message": "connection", "exception": error})
            error.__traceback__ = None  # asyncio's frame holds the error: the same


class Door:
    """Accepts connections for one server, in that server's own thread."""

    def __init__(self, listening: sockets.socket, server: Server, connections: Connections):
        """Accept from `listening` for `server`, whose configuration is loaded, within the bounds of `connections`."""
        self._listening, self._server = listening, server
        self.connections = connections
        self._accepting = asyncio.create_task(self._accept())

    def step(self) -> None:
        """Drop the expired connections."""
        for connection in self.connections.overdue(asyncio.get_running_loop().time()):
            connection.drop()

    def close(self) -> None:
        """Stop accepting connections."""
        self._accepting.cancel()
        self._listening.close()

    async def _accept(self) -> None:
        loop = asyncio.get_running_loop()
        self._listening.setblocking(False)
        count = itertools.count(1)
        while True:
            try:
                socket, _ = await loop.sock_accept(self._listening)
            except OSError as error:
                log.debug("no connection accepted: %s", error)
                await asyncio.sleep(_RETRY_S)
                continue
            connection = Accepted(socket)
            dropped = self.connections.arrived(connection, loop.time())
            if dropped is not None:
                dropped.drop()
            if dropped is not connection:
                connection.serve(self._server)
            if next(count) % _AT_ONCE == 0:
                await asyncio.sleep(0.0)  # let other ready tasks run


class Stages:
    """Notes the stage of each request's connection; a page is admitted once the application sends to it."""

    def __init__(self, app: ASGIApp, connections: Connections, contain: Containment):
        """Serve `app`; `contain` reports errors of requests."""
        self._app, self._connections, self._contain = app, connections, contain

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one request."""
        connection: Accepted = scope["state"][_KEY]
        clock = asyncio.get_running_loop().time

        async def send_to_page(message: Message) -> None:
            if message["type"] == "websocket.send":
                self._connections.reached(connection, Stage.PAGE, clock())
            await send(message)

        self._connections.reached(connection, Stage.BUSY, clock())
        gone = suppress(OSError, WebSocketDisconnect)  # the client has left meanwhile
        with self._contain.step("request", latches=False), gone:
            try:
                await self._app(scope, receive, send_to_page if scope["type"] == "websocket" else send)
            finally:
                self._connections.reached(connection, Stage.IDLE, clock())
