"""Opening the page: anybody on loopback, elsewhere nobody without a token and TLS."""

import os
from pathlib import Path

import pytest

from common.config.page_models import ConsoleConfig
from common.web.access import Access, AccessProblem, Visitor, read_tokens

TOKEN, OTHER = "a" * 40, "b" * 40


def written(folder: Path, text: str, mode: int = 0o600) -> Path:
    path = folder / "tokens"
    path.write_text(text, "utf-8")
    path.chmod(mode)
    return path


@pytest.fixture
def tokens(tmp_path: Path) -> Path:
    return written(tmp_path, f"# who\nOR-2 act {TOKEN}\n\nstudent observe {OTHER}\n")


def config(**given: object) -> ConsoleConfig:
    return ConsoleConfig.model_validate({"keys": Path("keys"), **given})


def test_on_loopback_anybody_may_act_or_observe() -> None:
    access = Access(config())
    assert access.visitor(None) == Visitor("console", "act")
    assert access.visitor(None, "observe") == Visitor("console", "observe")


def test_with_tokens_loopback_wants_one_too(tokens: Path) -> None:
    access = Access(config(tokens=tokens))
    assert access.visitor(None) is None
    assert access.visitor("c" * 40) is None
    assert access.visitor(TOKEN[:-1]) is None
    assert access.visitor(TOKEN) == Visitor("OR-2", "act")
    assert access.visitor(OTHER, "act") == Visitor("student", "observe")


@pytest.mark.parametrize("bind", ["0.0.0.0", "192.168.1.7", "::", "console.example"])
def test_a_network_needs_tokens_and_tls_and_behind_a_proxy_loopback_is_one(bind: str, tokens: Path) -> None:
    with pytest.raises(AccessProblem, match="set `tokens`"):
        Access(config(bind=bind))
    with pytest.raises(AccessProblem, match="set `tokens`"):
        Access(config(bind=bind, certificate=Path("c"), certificate_key=Path("k")))
    with pytest.raises(AccessProblem, match="certificate"):
        Access(config(bind=bind, tokens=tokens))
    assert Access(config(bind=bind, tokens=tokens, certificate=Path("c"), certificate_key=Path("k"))).secure
    assert Access(config(bind=bind, tokens=tokens, behind_proxy=True)).secure
    with pytest.raises(AccessProblem, match="behind a proxy"):
        Access(config(behind_proxy=True))


@pytest.mark.parametrize(
    ("host", "origin", "expected"),
    [
        ("127.0.0.1:8090", "http://127.0.0.1:8090", True),
        ("localhost:8090", "http://localhost:8090", True),
        ("[::1]:8090", "http://[::1]:8090", True),
        ("127.0.0.1:8090", None, True),
        (None, None, False),
        ("evil.example:8090", "http://evil.example:8090", False),
        ("127.0.0.1:8090", "http://evil.example", False),
        ("127.0.0.1:8090", "http://127.0.0.1:9999", False),
        ("127.0.0.1:8090", "https://127.0.0.1:8090", False),
        ("127.0.0.1:8090", "null", False),
    ],
)
def test_only_the_page_itself_is_let_in(host: str | None, origin: str | None, expected: bool) -> None:
    assert Access(config()).expected(host, origin) is expected


def test_behind_a_proxy_the_configured_address_counts(tokens: Path) -> None:
    access = Access(config(tokens=tokens, behind_proxy=True, address="https://console.example/"))
    assert access.expected("console.example", "https://console.example")
    assert access.expected("127.0.0.1:8090", "https://console.example")
    assert not access.expected("console.example", "https://elsewhere.example")


@pytest.mark.parametrize(
    ("address", "origin"),
    [
        ("https://Console.Example", "https://console.example"),
        ("https://console.example:443/", "https://console.example"),
        ("https://console.example:8443", "https://console.example:8443"),
        ("http://[::1]:80", "http://[::1]"),
    ],
)
def test_an_address_means_the_origin_that_browsers_send(tokens: Path, address: str, origin: str) -> None:
    access = Access(config(tokens=tokens, behind_proxy=True, address=address))
    assert access.expected("console.example", origin)


@pytest.mark.parametrize(
    "address", ["console.example", "ftp://console.example", "https://[::1", "https://a:b", "https://a/b", "https://:80"]
)
def test_a_bad_address_is_named(tokens: Path, address: str) -> None:
    with pytest.raises(AccessProblem, match=r"address .*: expected such as"):
        Access(config(tokens=tokens, behind_proxy=True, address=address))


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("OR-2 act short\n", ":1: expected NAME"),
        (f"OR-2 rule {TOKEN}\n", ":1: expected NAME"),
        (f"OR-2 {TOKEN}\n", ":1: expected NAME"),
        (f"a act {TOKEN}\nb act {TOKEN}\n", ":2: this token is another visitor's"),
        ("# nobody\n", "no token"),
    ],
)
def test_a_bad_list_of_tokens_says_where(tmp_path: Path, text: str, match: str) -> None:
    with pytest.raises(AccessProblem, match=match):
        read_tokens(written(tmp_path, text))


def test_tokens_that_others_can_read_are_none(tokens: Path) -> None:
    tokens.chmod(0o644)
    with pytest.raises(AccessProblem, match="chmod 600"):
        read_tokens(tokens)
    with pytest.raises(AccessProblem, match=r"none: No such file or directory$"):
        read_tokens(tokens.with_name("none"))


def test_a_pipe_is_no_list_of_tokens_and_is_not_waited_for(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "tokens", 0o600)
    with pytest.raises(AccessProblem, match="is no regular file"):
        read_tokens(tmp_path / "tokens")
