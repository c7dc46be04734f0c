"""Serves the console as a web application: page files, reports and websocket, protected against foreign origins."""

from collections.abc import Awaitable, Callable
from importlib import resources
from pathlib import Path
from typing import Any

from starlette.applications import Starlette
from starlette.requests import HTTPConnection, Request
from starlette.responses import FileResponse, JSONResponse, PlainTextResponse, RedirectResponse, Response
from starlette.routing import Route, WebSocketRoute
from starlette.types import ASGIApp, Message, Receive, Scope, Send
from starlette.websockets import WebSocket

from operator_site.console import texts
from operator_site.console.web.access import COOKIE, Access, Visitor
from operator_site.console.web.camera_pages import CameraPages
from operator_site.console.web.pages import Pages

PAGE = Path(str(resources.files("operator_site"))) / "console" / "page"
REFUSED = 4401
"""Close code of a websocket without access."""
_HEADERS = {
    "content-security-policy": "default-src 'self'; frame-ancestors 'none'; base-uri 'none'; form-action 'none'",
    "x-content-type-options": "nosniff",
    "referrer-policy": "no-referrer",
    "cross-origin-opener-policy": "same-origin",
    "cache-control": "no-cache",
}
_REPORT_HEADERS = {"content-security-policy": "default-src 'none'; style-src 'unsafe-inline'; img-src data:"}
"""Headers of a report, which is one file with its style and pictures and without scripts."""
_TYPES = {
    ".html": "text/html",
    ".css": "text/css",
    ".js": "text/javascript",
    ".svg": "image/svg+xml",
    ".txt": "text/plain",
    ".woff2": "font/woff2",
}


def application(
    access: Access, pages: Pages, camera: CameraPages, reports: Path | None, health: Callable[[], dict[str, Any]]
) -> Starlette:
    """Return the web application.

    Args:
        access: checks the visitors.
        pages: serves the websockets of the session.
        camera: serves the websockets of the camera's pictures.
        reports: folder of finished reports; None for no reports.
        health: returns the contents of `/health`.
    """

    def visitor(connection: HTTPConnection) -> Visitor | None:
        if not access.expected(connection.headers.get("host"), connection.headers.get("origin")):
            return None
        return access.visitor(connection.cookies.get(COOKIE), connection.query_params.get("role"))

    def guarded(
        serve: Callable[[Request], Awaitable[Response]],
    ) -> Callable[[Request], Awaitable[Response]]:
        async def served(request: Request) -> Response:
            if visitor(request) is None:
                return PlainTextResponse(texts.NEEDS_TOKEN, 401)
            return await serve(request)

        return served

    async def index(request: Request) -> Response:
        token = request.query_params.get("token")
        if token is not None and access.expected(request.headers.get("host"), request.headers.get("origin")):
            # Redirect at once, so that the token in the address is not seen, stored or passed on.
            response = RedirectResponse("/", 303)
            if access.visitor(token) is not None:
                response.set_cookie(COOKIE, token, httponly=True, samesite="strict", secure=access.secure, path="/")
            return response
        return await guarded(_index)(request)

    async def _index(request: Request) -> Response:
        return _file(PAGE / "index.html")

    async def file(request: Request) -> Response:
        return _file(_inside(PAGE, request.path_params["name"]))

    async def report(request: Request) -> Response:
        found = None if reports is None else _inside(reports, f"{request.path_params['name']}.html")
        response = _file(found)
        response.headers.update(_REPORT_HEADERS)
        return response

    async def healthy(request: Request) -> Response:
        return JSONResponse(health())

    def websocket(serve: Callable[[WebSocket, Visitor], Awaitable[None]]) -> Callable[[WebSocket], Awaitable[None]]:
        async def served(socket: WebSocket) -> None:
            who = visitor(socket)
            await socket.accept()
            if who is None:
                await socket.close(REFUSED)
                return
            await serve(socket, who)

        return served

    routes = [
        Route("/", index),
        Route("/page/{name}", guarded(file)),
        Route("/report/{name}.html", guarded(report)),
        Route("/health", healthy),
        WebSocketRoute("/session", websocket(pages.serve)),
        WebSocketRoute("/camera", websocket(camera.serve)),
    ]
    app = Starlette(routes=routes)
    app.add_middleware(_Headers)
    return app


def _inside(folder: Path, name: str) -> Path | None:
    """Return the path of a file directly in a folder; None if there is no such file."""
    path = folder / name
    return path if path.parent == folder and not name.startswith(".") and path.is_file() else None


def _file(path: Path | None) -> Response:
    if path is None or not path.is_file():
        return PlainTextResponse(texts.NO_FILE, 404)
    return FileResponse(path, media_type=_TYPES.get(path.suffix, "application/octet-stream"))


class _Headers:
    """Adds the common headers to every answer."""

    def __init__(self, app: ASGIApp):
        self._app = app

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Serve one request."""

        async def with_headers(message: Message) -> None:
            if message["type"] == "http.response.start":
                given = {name.lower() for name, _ in message["headers"]}
                ours = [(k.encode(), v.encode()) for k, v in _HEADERS.items() if k.encode() not in given]
                message = {**message, "headers": [*message["headers"], *ours]}
            await send(message)

        await self._app(scope, receive, with_headers if scope["type"] == "http" else send)
