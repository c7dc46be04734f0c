"""A console without an operator site, in a thread, with streams that it records."""

import threading
from pathlib import Path

from common.config.page_models import ConsoleConfig
from operator_site.console.run import run_console
from tests.conftest import Keys, free_ports


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

    def end(self) -> None:
        """End the console and its record."""
        self._ended.set()
        self._thread.join()
