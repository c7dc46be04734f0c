"""Requests for the page that no browser of a person makes."""

import asyncio
from pathlib import Path
from typing import Any

import pytest

from common.config.page_models import ConsoleConfig
from common.web.access import Access
from operator_site.console.web.camera_pages import CameraPages
from operator_site.console.web.server import application
from operator_site.console.web.voice_pages import VoicePages
from tests.unit.operator_site.console.page_room import Room

TOKEN = "a" * 40


@pytest.fixture
def access(tmp_path: Path) -> Access:
    tokens = tmp_path / "tokens"
    tokens.write_text(f"OR-2 act {TOKEN}\n", "utf-8")
    tokens.chmod(0o600)
    return Access(ConsoleConfig(keys=Path("keys"), tokens=tokens))


def get(access: Access, path: str, host: str, query: str = "") -> tuple[int, dict[str, str]]:
    """Status and headers of the answer to a request."""
    sent: list[Any] = []

    async def receive() -> dict[str, object]:
        return {"type": "http.request", "body": b"", "more_body": False}

    async def send(message: Any) -> None:
        sent.append(message)

    scope = {
        "type": "http",
        "method": "GET",
        "path": path,
        "raw_path": path.encode(),
        "query_string": query.encode(),
        "headers": [(b"host", host.encode("latin-1"))],
        "http_version": "1.1",
        "scheme": "http",
        "server": ("127.0.0.1", 8090),
        "client": ("127.0.0.1", 5000),
    }
    pages = Room().pages
    app = application(access, pages, CameraPages(pages.contain), VoicePages(pages.contain, lambda: None), None)
    asyncio.run(app(scope, receive, send))
    start = next(message for message in sent if message["type"] == "http.response.start")
    return start["status"], {name.decode(): value.decode() for name, value in start["headers"]}


@pytest.mark.parametrize("host", ["[::1", "[", "[::1]:x", "127.0.0.1:99999999", "", "\xff", "a b", "evil.example"])
def test_a_strange_host_is_refused_and_no_error_of_ours(access: Access, host: str) -> None:
    for path in ("/", "/page/main.js"):
        assert get(access, path, host)[0] in (401, 200), host
    assert get(access, "/", host)[0] == 401


def test_only_the_microphone_is_permitted(access: Access) -> None:
    _, headers = get(access, "/", "127.0.0.1:8090")
    allowed = [one.strip() for one in headers["permissions-policy"].split(",") if not one.endswith("=()")]
    assert allowed == ["microphone=(self)"]


def test_a_token_in_the_address_becomes_a_cookie_of_this_page_only(access: Access) -> None:
    status, headers = get(access, "/", "127.0.0.1:8090", f"token={TOKEN}")
    assert status == 303
    assert TOKEN in headers["set-cookie"]
    status, headers = get(access, "/", "evil.example:8090", f"token={TOKEN}")
    assert status == 401
    assert "set-cookie" not in headers
