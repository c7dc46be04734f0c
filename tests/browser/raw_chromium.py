"""Chromium without automation: in it a page can really be hidden or frozen, which none can that playwright drives."""

import json
import re
import subprocess
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path
from typing import Any
from urllib.request import Request, urlopen

from websockets.sync.client import ClientConnection, connect

PATIENCE_S = 20.0
_LONGEST_MESSAGE = 1 << 24


class Tab:
    """One page, spoken to by the browser's own protocol."""

    def __init__(self, devtools: str, ident: str, connection: ClientConnection):
        self._devtools, self._ident, self._connection = devtools, ident, connection
        self._asked = 0

    def send(self, method: str, **parameters: Any) -> dict[str, Any]:
        """Give an order; what the browser answers."""
        self._asked += 1
        self._connection.send(json.dumps({"id": self._asked, "method": method, "params": parameters}))
        while True:
            answer = json.loads(self._connection.recv(timeout=PATIENCE_S))
            if answer.get("id") == self._asked:
                assert "error" not in answer, answer["error"]
                result: dict[str, Any] = answer["result"]
                return result

    def evaluate(self, expression: str) -> Any:
        """The value of an expression in the page; a promise's when it is kept."""
        answer = self.send("Runtime.evaluate", expression=expression, returnByValue=True, awaitPromise=True)
        assert "exceptionDetails" not in answer, answer["exceptionDetails"]
        return answer["result"].get("value")

    def until(self, expression: str) -> float:
        """Wait until an expression is true in the page; when it was, s."""
        end_s = time.monotonic() + PATIENCE_S
        while not self.evaluate(expression):
            assert time.monotonic() < end_s, expression
            time.sleep(0.01)
        return time.monotonic()

    def key(self, key: str, *, down: bool) -> None:
        """Press or let go a letter's key."""
        kind, text = ("keyDown", {"text": key}) if down else ("keyUp", {})
        self.send("Input.dispatchKeyEvent", type=kind, key=key, code=f"Key{key.upper()}", **text)

    def to_front(self) -> None:
        """Show it, which hides all others."""
        urlopen(f"{self._devtools}/json/activate/{self._ident}").close()


class Chromium:
    """A browser whose pages are its only users' affair."""

    def __init__(self, devtools: str, opened: ExitStack):
        self._devtools, self._opened = devtools, opened

    def tab(self, address: str) -> Tab:
        """Open a page and show it."""
        with urlopen(Request(f"{self._devtools}/json/new?about:blank", method="PUT")) as response:
            answer = json.load(response)
        connection = self._opened.enter_context(connect(answer["webSocketDebuggerUrl"], max_size=_LONGEST_MESSAGE))
        tab = Tab(self._devtools, answer["id"], connection)
        tab.send("Page.navigate", url=address)  # answered when there is a page to speak to
        return tab


@contextmanager
def chromium_of(path: str, folder: Path) -> Iterator[Chromium]:
    """Start the browser at `path` with a new profile in `folder`, and end it."""
    arguments = ["--headless", "--no-sandbox", "--remote-debugging-port=0", f"--user-data-dir={folder}"]
    process = subprocess.Popen(
        [path, *arguments, "--window-size=1440,900", "about:blank"],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stderr is not None
    try:
        for line in process.stderr:
            if (found := re.search(r"DevTools listening on ws://([^/]+)/", line)) is not None:
                break
        else:
            raise AssertionError("the browser ended")
        with ExitStack() as opened:
            yield Chromium(f"http://{found[1]}", opened)
    finally:
        process.terminate()
        process.stderr.read()
        process.stderr.close()
        process.wait()
