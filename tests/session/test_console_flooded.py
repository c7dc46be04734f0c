"""Page and STOP of the console during a flood of half-open connections."""

import re
import resource
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import NamedTuple
from urllib.parse import urlsplit
from urllib.request import urlopen

import pytest

from common.config import ConsoleConfig, to_toml
from tests.conftest import Keys
from tests.operator_site.console.stub_site import Site
from tests.session.page import Page, opened

pytestmark = [pytest.mark.session, pytest.mark.timeout(200)]

HALF_OPEN, DESCRIPTORS = 1300, 1024
HEAD = b"GET / HTTP/1.1\r\nHost: 127.0.0.1\r\n"
TRIES, LIMIT_S, SHARE = 100, 0.3, 0.99
PATIENCE_S = 2.0


class Console(NamedTuple):
    """Where the page is, and its process."""

    address: str
    pid: int


@pytest.fixture
def console(tmp_path: Path, keys: Keys) -> Iterator[Console]:
    """A console with a file descriptor limit of DESCRIPTORS, beside a desk."""
    with socket.create_server(("127.0.0.1", 0)) as free:
        desk_port = free.getsockname()[1]
    config = ConsoleConfig(keys=keys.operator, port=0, desk_port=desk_port, record=tmp_path / "console.mcap")
    (tmp_path / "console.toml").write_text(to_toml(config), "utf-8")
    site = Site(desk_port, keys)
    arguments = [sys.executable, "-m", "teletaction", "console", "--config", str(tmp_path / "console.toml")]
    process = subprocess.Popen(arguments, stderr=subprocess.PIPE, text=True)
    assert process.stderr is not None
    reading = threading.Thread(target=lambda log: [*log], args=(process.stderr,))
    try:
        found = next(filter(None, (re.search(r"(http://127\.0\.0\.1:\d+)", line) for line in process.stderr)))
        descriptors(process.pid, DESCRIPTORS)
        reading.start()
        yield Console(found[1], process.pid)
    finally:
        process.terminate()
        reading.join()
        process.stderr.close()
        site.close()
        assert process.wait(10.0) == 0


def descriptors(pid: int, soft: int) -> None:
    """Let a process open so many files at most."""
    _, hard = resource.prlimit(pid, resource.RLIMIT_NOFILE)
    resource.prlimit(pid, resource.RLIMIT_NOFILE, (soft, hard))


class Flood:
    """Half-open connections: every other one sends nothing, the rest half of a head."""

    def __init__(self, address: str, opened: ExitStack) -> None:
        parts = urlsplit(address)
        self._to = str(parts.hostname), parts.port
        self._opened = opened
        self._count = 0

    def more(self, count: int) -> None:
        """So many more, whatever became of the others; none is waited for."""
        for _ in range(count):
            line = self._opened.enter_context(socket.socket())
            line.setblocking(False)
            line.connect_ex(self._to)
            self._count += 1
            if self._count % 2:
                try:
                    line.send(HEAD)
                except OSError:  # it is not connected yet, or was dropped
                    continue


@contextmanager
def flooded(address: str) -> Iterator[Flood]:
    """A flood that ends with the block."""
    soft, hard = resource.getrlimit(resource.RLIMIT_NOFILE)
    resource.setrlimit(resource.RLIMIT_NOFILE, (min(hard, 8192), hard))
    try:
        with ExitStack() as opened:
            yield Flood(address, opened)
    finally:
        resource.setrlimit(resource.RLIMIT_NOFILE, (soft, hard))


def took_s(act: Callable[[], object]) -> float:
    """Duration of an act, s; PATIENCE_S where it failed."""
    began_s = time.monotonic()
    try:
        act()
    except OSError:
        return PATIENCE_S
    return time.monotonic() - began_s


def fetch(address: str) -> None:
    with urlopen(f"{address}/page/main.js", timeout=PATIENCE_S) as answer:
        assert answer.status == 200
        answer.read()


def in_time(durations_s: list[float]) -> str:
    """Empty where enough of them are short; else what they are."""
    late = sorted(duration for duration in durations_s if duration > LIMIT_S)
    share = 1.0 - len(late) / len(durations_s)
    return "" if share >= SHARE else f"{share:.0%} within {LIMIT_S} s, the slowest {late[-1]:.2f} s"


def tried(page: Page, address: str, tries: int, between: Callable[[], None]) -> dict[str, str]:
    """Page and STOP in turn; what was late of them."""
    took: dict[str, list[float]] = {"page": [], "STOP": []}
    for _ in range(tries):
        took["page"].append(took_s(lambda: fetch(address)))
        took["STOP"].append(took_s(lambda: page.ask("estop")))
        between()
    return {what: late for what, durations_s in took.items() if (late := in_time(durations_s))}


def test_half_open_connections_delay_neither_page_nor_stop(console: Console) -> None:
    with opened(console.address) as page:
        page.until(lambda: page.state, "a state")
        with flooded(console.address) as flood:
            flood.more(HALF_OPEN)
            assert tried(page, console.address, TRIES, lambda: flood.more(HALF_OPEN // TRIES)) == {}
            with opened(console.address) as other:
                other.until(lambda: other.state and other.picture, "a page of its own")
        assert tried(page, console.address, TRIES // 5, lambda: None) == {}
