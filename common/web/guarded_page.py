"""A page of static files and websockets, for visitors with a token, with headers against foreign origins."""

import os
from collections.abc import Awaitable, Callable
from pathlib import Path

from starlette.applications import Starlette
from starlette.requests import HTTPConnection, Request
from starlette.responses import FileResponse, PlainTextResponse, RedirectResponse, Response
from starlette.routing import BaseRoute, Route, WebSocketRoute
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from starlette.websockets import WebSocket

from common.web.access import COOKIE, Access, Visitor

REFUSED = 4401
"""Close code of a websocket without access."""
NEEDS_TOKEN = "This page needs a token: open it by the address that has one."
NO_FILE = "There is no such file."
_HEADERS = {
    "content-security-policy": "default-src 'self'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'",
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "cross-origin-opener-policy": "same-origin",
    "cache-control": "no-cache",
}
_TYPES = {
    ".html": "text/html",
    ".css": "text/css",
    ".js": "text/javascript",
    ".svg": "image/svg+xml",
    ".txt": "text/plain",
    ".woff2": "font/woff2",
}

_PERMISSIONS = "camera=(), display-capture=(), geolocation=(), microphone={}, serial=(), usb=()"
ServeRequest = Callable[[Request], Awaitable[Response]]
ServeWebSocket = Callable[[WebSocket, Visitor], Awaitable[None]]


class GuardedPage:
    """Serves `index.html` at `/`, the other files of its folder at `/page/NAME`, and websockets."""

    def __init__(self, access: Access, folder: Path, *, microphone: bool = False) -> None:
        """Serve the files of `folder` to the visitors of `access`; its scripts may use the `microphone`, or not."""
        self._access, self._folder = access, folder
        self._headers = {**_HEADERS, "permissions-policy": _PERMISSIONS.format("(self)" if microphone else "()")}

    def application(self, *routes: BaseRoute) -> Starlette:
        """Return the web application of the page with further routes."""
        app = Starlette(routes=[Route("/", self._index), Route("/page/{name}", self.guarded(self._file)), *routes])
        app.add_middleware(_Headers, headers=self._headers)
        return app

    def guarded(self, serve: ServeRequest) -> ServeRequest:
        """Return `serve` for visitors only."""

        async def served(request: Request) -> Response:
            if self._visitor(request) is None:
                return PlainTextResponse(NEEDS_TOKEN, 401)
            return await serve(request)

        return served

    def websocket(self, path: str, serve: ServeWebSocket) -> WebSocketRoute:
        """Return the route of a websocket for visitors only."""

        async def served(socket: WebSocket) -> None:
            who = self._visitor(socket)
            await socket.accept()
            if who is None:
                await socket.close(REFUSED)
                return
            await serve(socket, who)

        return WebSocketRoute(path, served)

    def _visitor(self, connection: HTTPConnection) -> Visitor | None:
        if not self._access.expected(connection.headers.get("host"), connection.headers.get("origin")):
            return None
        return self._access.visitor(connection.cookies.get(COOKIE), connection.query_params.get("role"))

    async def _index(self, request: Request) -> Response:
        access, token = self._access, request.query_params.get("token")
        if token is not None and access.expected(request.headers.get("host"), request.headers.get("origin")):
            # Redirect at once, so that the token in the address is not seen, stored or passed on.
            response = RedirectResponse("/", 303)
            if access.visitor(token) is not None:
                response.set_cookie(COOKIE, token, httponly=True, samesite="strict", secure=access.secure, path="/")
            return response
        if self._visitor(request) is None:
            return PlainTextResponse(NEEDS_TOKEN, 401)
        return file_response(self._folder / "index.html")

    async def _file(self, request: Request) -> Response:
        return file_response(file_in(self._folder, request.path_params["name"]))


def file_in(folder: Path, name: str) -> Path | None:
    """Return the path of a file directly in a folder; None if there is no such file."""
    path = folder / name
    return path if path.parent == folder and not name.startswith(".") and os.path.isfile(path) else None


def file_response(path: Path | None) -> Response:
    """Return a file as an answer, or the answer that there is none."""
    if path is None or not path.is_file():
        return PlainTextResponse(NO_FILE, 404)
    return FileResponse(path, media_type=_TYPES.get(path.suffix, "application/octet-stream"))


class _Headers:
    """Adds the common headers to every answer."""

    def __init__(self, app: ASGIApp, headers: dict[str, str]):
        self._app, self._headers = app, headers

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one request."""

        async def with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                given = {name.lower() for name, _ in message["headers"]}
                ours = [(k.encode(), v.encode()) for k, v in self._headers.items() if k.encode() not in given]
                message = {**message, "headers": [*message["headers"], *ours]}
            await send(message)

        await self._app(scope, receive, with_headers if scope["type"] == "http" else send)
