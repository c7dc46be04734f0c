"""The console's process continues when a step of it raises."""

import asyncio
import socket
from pathlib import Path
from typing import cast

from starlette.applications import Starlette

from common.config.models import ConsoleConfig
from common.runtime.containment import Containment
from operator_site.console.live import LiveConsole
from operator_site.console.run import _run
from tests.conftest import Contained


class Shown:
    """A console of which every step fails."""

    class Pages:
        contain = Containment()

    def __init__(self) -> None:
        self.pages, self.steps = self.Pages(), 0

    def step(self, now_s: float) -> None:
        self.steps += 1
        raise LookupError("no map")


def test_a_step_that_raises_is_named_once_and_the_process_continues(contained: Contained) -> None:
    shown = Shown()

    def status() -> None:
        raise ValueError("no figures")

    with socket.create_server(("127.0.0.1", 0)) as listening:
        config = ConsoleConfig(keys=Path())
        console = cast(LiveConsole, shown)
        asyncio.run(_run(console, config, Starlette(), listening, lambda: shown.steps >= 5, status))
    assert shown.steps == 5
    names = contained.take()
    assert [name.split(" in ")[0] for name in names] == ["showing: LookupError", "status: ValueError"]
    assert shown.pages.contain.count == 6
