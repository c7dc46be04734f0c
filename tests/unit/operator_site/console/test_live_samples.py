"""A console records each sample of an examination once, and shows them again, also after a restart of the site."""

import asyncio
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from common.config.page_models import ConsoleConfig
from operator_site.console.examination.journal import Journal
from operator_site.console.live import LiveConsole
from operator_site.session.console_feed import Fed
from tests.unit.operator_site.console.fed import rendered
from tests.unit.operator_site.console.page_room import AnsweringSite
from tests.unit.operator_site.console.touch_rows import sample

S = 1_000_000_000
BEGIN: dict[str, Any] = {"what": "begin", "at_s": 3700.0, "pseudonym": "P-0417", "sides": None}


class Feed:
    """The feed of a site whose clock is ahead of the console's."""

    def __init__(self) -> None:
        self.here_s, self.ahead_s = 100.0, 3600.0

    def receive(self) -> Iterator[Fed]:
        yield Fed("operator/rendered", round((self.here_s + self.ahead_s) * S), rendered())


async def examine(path: Path, feed: Feed, *touches: int) -> LiveConsole:
    """Run a console that takes a touch every two seconds, and close its journal."""
    journal = Journal(path, {})
    live = LiveConsole(ConsoleConfig(keys=path.parent, record=path), feed, AnsweringSite(), journal)
    if live.console.examination.pseudonym is None:
        live.console.examination.take("console/session", BEGIN)
        journal.write("console/session", BEGIN["at_s"], BEGIN)
    for touch in touches:
        feed.here_s += 2.0
        t_s = feed.here_s + feed.ahead_s
        live.console.tactile_map.take(sample("stiffness", touch, 0.0, 0.0, 6.0, 0.01)._replace(t_s=t_s))
        live.step(feed.here_s)
        await asyncio.sleep(0.0)
    journal.close()
    return live


def test_samples_of_before_and_after_a_restart_of_the_site_are_shown_again(tmp_path: Path) -> None:
    async def run() -> list[int]:
        feed, path, shown = Feed(), tmp_path / "console.mcap", []
        for touches, ahead_s in (((1, 2), 3600.0), ((3, 4), 0.0), ((5,), 0.0), ((), 0.0)):
            feed.ahead_s = ahead_s
            live = await examine(path, feed, *touches)
            stiffness = live.console.tactile_map.at(0.0, 0.0).stiffness
            assert stiffness is not None
            shown.append(stiffness.touches)
        return shown

    assert asyncio.run(run()) == [2, 4, 5, 5]
