"""The console as a web application: its page, its reports and its websockets."""

from importlib import resources
from pathlib import Path

from starlette.applications import Starlette
from starlette.requests import Request
from starlette.responses import JSONResponse, Response
from starlette.routing import Route

from common.web.access import Access
from common.web.guarded_page import GuardedPage, file_in, file_response
from operator_site.console.web.camera_pages import CameraPages
from operator_site.console.web.pages import Pages
from operator_site.console.web.voice_pages import VoicePages

PAGE = Path(str(resources.files("operator_site"))) / "console" / "page"
_REPORT_HEADERS = {"content-security-policy": "default-src 'none'; style-src 'unsafe-inline'; img-src data:"}
"""Headers of a report, which is one file with its style and pictures and without scripts."""


def application(
    access: Access,
    pages: Pages,
    camera: CameraPages,
    voice: VoicePages,
    reports: Path | None,
) -> Starlette:
    """Return the web application.

    Args:
        access: checks the visitors.
        pages: serves the websockets of the session.
        camera: serves the websockets of the camera's pictures.
        voice: serves the websockets of the voice.
        reports: folder of finished reports; None for no reports.
    """

    async def report(request: Request) -> Response:
        found = None if reports is None else file_in(reports, f"{request.path_params['name']}.html")
        response = file_response(found)
        response.headers.update(_REPORT_HEADERS)
        return response

    async def healthy(request: Request) -> Response:
        return JSONResponse({"ok": True})

    page = GuardedPage(access, PAGE, microphone=True)
    return page.application(
        Route("/report/{name}.html", page.guarded(report)),
        Route("/health", healthy),
        page.websocket("/session", pages.serve),
        page.websocket("/camera", camera.serve),
        page.websocket("/voice", voice.serve),
    )
