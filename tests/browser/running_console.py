"""A console in a thread, with streams that it records, and a feed that reports a remote site's consent only."""

import threading
import time
from pathlib import Path

import msgpack

from common.config.page_models import ConsoleConfig
from common.link.keys import KeyPair, load_keys
from operator_site.console.run import run_console
from operator_site.session.console_feed import ConsoleFeedSocket
from tests.conftest import Keys
from tests.ports import free_ports


class RunningConsole:
    """Runs until it is ended.

    Attributes:
        address: of its page.
    """

    def __init__(self, keys: Keys, record: Path, **streams: object) -> None:
        """Start it; `streams` are the fields of its configuration for streams and consent."""
        desk, self._ended = free_ports(), threading.Event()
        config = ConsoleConfig.model_validate(
            {"keys": keys.operator, "desk_port": desk, "feed_port": desk + 1, "port": desk + 2, "record": record}
            | streams
        )
        self.address = f"http://127.0.0.1:{config.port}/"
        self._thread = threading.Thread(target=run_console, args=(config, self._ended.is_set))
        self._thread.start()
        self._feeding = threading.Thread(target=self._feed, args=(config.feed_port, load_keys(keys.operator)))
        self._feeding.start()

    def _feed(self, port: int, keys: KeyPair) -> None:
        """Report four times a second that the remote site has noted no consent, which restricts nothing."""
        with ConsoleFeedSocket(port, keys) as feed:
            while not self._ended.wait(0.25):
                now_ns = time.monotonic_ns()
                feed.write("operator/figures", now_ns, msgpack.packb({"state": "disconnected", "remote_consent": {}}))
                feed.step(now_ns)

    def end(self) -> None:
        """End the console and its record."""
        self._ended.set()
        self._thread.join()
        self._feeding.join()
