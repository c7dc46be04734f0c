"""A console that is open to a network: over TLS, with a token, and actions only with a token that permits them."""

import re
import secrets
import ssl
import subprocess
import sys
from collections.abc import Iterator
from contextlib import closing
from http.client import HTTPSConnection, RemoteDisconnected
from pathlib import Path
from typing import NamedTuple
from urllib.error import URLError
from urllib.parse import urlsplit
from urllib.request import urlopen

import pytest
from websockets.exceptions import ConnectionClosed

from common.config.file import to_toml
from common.config.page_models import ConsoleConfig
from tests.commands import command
from tests.system.page import Page, opened
from tests.system.truth import written

pytestmark = [pytest.mark.session, pytest.mark.timeout(120)]

ACT, OBSERVE = secrets.token_hex(32), secrets.token_hex(32)
WRONG = secrets.token_hex(32)
CERTIFY = [
    "openssl",
    "req",
    "-x509",
    "-newkey",
    "ec",
    "-pkeyopt",
    "ec_paramgen_curve:prime256v1",
    "-nodes",
    "-days",
    "1",
    "-subj",
    "/CN=console",
]


class Served(NamedTuple):
    """Where the page is, what its certificate is checked against, and the console's folder."""

    address: str
    trust: ssl.SSLContext
    folder: Path

    def cookie(self, token: str) -> dict[str, str]:
        return {"Cookie": f"teletaction={token}"}

    def get(self, path: str, **headers: str) -> tuple[int, dict[str, str], str]:
        """Status, headers and text of an answer; what a browser would be sent on to is not followed."""
        parts = urlsplit(self.address)
        with closing(HTTPSConnection(str(parts.hostname), parts.port, context=self.trust, timeout=10.0)) as connection:
            connection.request("GET", path, headers=headers)
            answer = connection.getresponse()
            return answer.status, {name.lower(): value for name, value in answer.getheaders()}, answer.read().decode()


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    """On all interfaces, as beyond loopback; no operator site is needed for anybody to be refused."""
    folder = tmp_path_factory.mktemp("console")
    certificate, key, tokens = folder / "certificate.pem", folder / "key.pem", folder / "tokens"
    names = ("-addext", "subjectAltName=DNS:localhost,IP:127.0.0.1")
    made = subprocess.run((*CERTIFY, *names, "-keyout", key, "-out", certificate), capture_output=True, check=False)
    assert made.returncode == 0, made.stderr
    tokens.write_text(f"OR-2 act {ACT}\nstudent observe {OBSERVE}\n", "utf-8")
    tokens.chmod(0o600)
    assert command("keys", "init", "--keys", folder / "keys").code == 0
    config = ConsoleConfig(
        keys=folder / "keys",
        bind="0.0.0.0",
        port=0,
        tokens=tokens,
        certificate=certificate,
        certificate_key=key,
        record=folder / "console.mcap",
    )
    (folder / "console.toml").write_text(to_toml(config), "utf-8")
    arguments = [sys.executable, "-m", "teletaction", "console", "--config", str(folder / "console.toml")]
    process = subprocess.Popen(arguments, stderr=subprocess.PIPE, text=True)
    assert process.stderr is not None
    try:
        found = next(filter(None, (re.search(r"https://0\.0\.0\.0:(\d+)", line) for line in process.stderr)))
        yield Served(f"https://127.0.0.1:{found[1]}", ssl.create_default_context(cafile=certificate), folder)
    finally:
        process.terminate()
        said = process.stderr.read()
        process.stderr.close()
        assert process.wait(10.0) == 0, said


def refused(served: Served, origin: str = "", **headers: str) -> None:
    """A websocket with these headers is refused, and gets no message before."""
    with (
        opened(served.address, ssl=served.trust, Origin=origin or served.address, **headers) as page,
        pytest.raises(ConnectionClosed) as closed,
    ):
        page.until(lambda: page.state or page.pictures, "nothing")
    assert closed.value.rcvd is not None
    assert closed.value.rcvd.code == 4401
    assert page.state == {}


def state_of(page: Page) -> dict[str, object]:
    page.until(lambda: page.state and page.picture is not None, "a state and a picture")
    found: dict[str, object] = page.state["you"]
    return found


def test_a_token_moves_from_the_address_into_a_cookie_that_nothing_else_can_read(served: Served) -> None:
    status, headers, _ = served.get(f"/?token={ACT}")
    assert (status, headers["location"]) == (303, "/")
    cookie = headers["set-cookie"]
    assert cookie.startswith(f"teletaction={ACT};")
    assert {"httponly", "secure", "samesite=strict"} <= {part.strip().lower() for part in cookie.split(";")}
    status, _, text = served.get("/", **served.cookie(ACT))
    assert status == 200
    assert "<title>" in text


@pytest.mark.parametrize("headers", [{}, {"Cookie": f"teletaction={WRONG}"}, {"Cookie": "teletaction="}])
def test_without_the_right_token_there_is_no_page_and_no_session(served: Served, headers: dict[str, str]) -> None:
    for path in ("/", "/page/main.js", "/report/x.html"):
        assert served.get(path, **headers)[0] == 401
    refused(served, **headers)


def test_a_wrong_token_in_the_address_gets_no_cookie(served: Served) -> None:
    status, headers, _ = served.get(f"/?token={WRONG}")
    assert status == 303
    assert "set-cookie" not in headers
    assert WRONG not in str(headers)


def test_a_permitted_page_acts_and_a_read_only_page_does_not(served: Served) -> None:
    with (
        opened(served.address, ssl=served.trust, **served.cookie(ACT)) as acting,
        opened(served.address, ssl=served.trust, **served.cookie(OBSERVE)) as looking,
    ):
        assert state_of(looking)["role"] == "observe"
        assert state_of(acting)["in_control"]
        for verb in ("begin", "engage", "estop", "take_control", "finding", "clear_fault", "end"):
            answer = looking.ask(verb, pseudonym="P-0418")
            assert (answer["ok"], answer["text"]) == (False, "OBSERVER. Control is at OR-2 1."), answer
        assert acting.ask("begin", pseudonym="P-0417")["ok"]
        looking.until(lambda: looking.state["session"]["pseudonym"] == "P-0417", "the other's session")
        assert acting.ask("end")["ok"]
    acts = [act for _, act in written(served.folder / "console.mcap", "console/act", may_be_cut=True)]
    answered = {(act["who"].split()[0], act["ok"]) for act in acts if act["ok"] is not None}
    assert answered == {("student", False), ("OR-2", True)}
    assert ACT not in str(acts)


def test_a_read_only_page_cannot_claim_another_role(served: Served) -> None:
    with opened(served.address, "/session?role=act", ssl=served.trust, **served.cookie(OBSERVE)) as page:
        assert state_of(page)["role"] == "observe"


def test_another_page_cannot_use_the_cookie(served: Served) -> None:
    refused(served, origin="https://elsewhere.example", **served.cookie(ACT))
    refused(served, origin=served.address.replace("https", "http"), **served.cookie(ACT))


def test_the_page_needs_tls_and_its_certificate_is_checked(served: Served) -> None:
    with pytest.raises((URLError, RemoteDisconnected, ConnectionError)):
        urlopen(served.address.replace("https", "http") + "/health", timeout=10.0)
    with pytest.raises(URLError, match="CERTIFICATE_VERIFY_FAILED"):
        urlopen(served.address + "/health", timeout=10.0)
