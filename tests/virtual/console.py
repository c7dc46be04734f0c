"""Pages of a console beside a session on the test bed."""

from pathlib import Path

from common.config.page_models import ConsoleConfig
from common.web.access import Role, Visitor
from teletaction.testbed.memory_feed import MemoryFeed
from teletaction.testbed.testbed import Testbed
from teletaction.testbed.testbed_console import MemorySocket, TestbedConsole
from tests.system.page import Page
from tests.virtual.session import VirtualSession


class VirtualConnection:
    """A page's socket; virtual time passes while the page waits for a message."""

    def __init__(self, session: Testbed, socket: MemorySocket) -> None:
        self._session, self._socket = session, socket

    def now_s(self) -> float:
        return self._session.time_s

    def send(self, text: str) -> None:
        self._socket.say(text)

    def recv(self, timeout: float) -> str | bytes:
        end_s = self.now_s() + timeout
        while not self._socket.sent:
            assert self._socket.closed is None, f"the console closed with {self._socket.closed}"
            if self.now_s() >= end_s:
                raise TimeoutError
            self._session.tick()
        return self._socket.sent.popleft()

    def close(self) -> None:
        self._socket.leave()


class Consoles:
    """The console of a session, one run after the other, with the same record.

    Attributes:
        record: the file of the first run.
    """

    def __init__(self, session: VirtualSession, feed: MemoryFeed, folder: Path) -> None:
        self.record = folder / "console.mcap"
        self._session, self._feed = session, feed
        self._config = ConsoleConfig(keys=Path("keys"), record=self.record)
        self._console = TestbedConsole(session, feed, self._config)

    def page(self, role: Role = "act", *, draws: bool = True) -> Page:
        """A page of who may act, or of an observer."""
        socket = self._console.enter(Visitor("console", role))
        return Page(VirtualConnection(self._session, socket), draws)

    def restart(self) -> None:
        """End the console without a word to its pages, and start another a second later."""
        self.close()
        self._session.run(1.0)
        self._console = TestbedConsole(self._session, self._feed, self._config)

    def close(self) -> None:
        self._console.close()
