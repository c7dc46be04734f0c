"""The cost of a console for the operator loop: ticks with and without a feed that is read, turn by turn in one run."""

import itertools
import os
import statistics
import subprocess
import sys
import time
from pathlib import Path

import pytest

from common.link.keys import load_keys
from common.recording.recorder import Recorder
from operator_site.session.console_feed import ConsoleFeedSocket
from operator_site.site_recording import SCHEMAS
from tests.conftest import Keys
from tests.unit.operator_site.virtual_touch import MS, Working

TURNS, TICKS = 40, 100
MOST = 1.15
"""Of the median tick; a list append a stream and tick is some hundredths of it."""
READER = """
import sys
from pathlib import Path
from common.link.keys import load_keys
from operator_site.session.console_feed import FeedReader
reader = FeedReader(int(sys.argv[1]), load_keys(Path(sys.argv[2])))
while True:
    reader.socket.poll(100)
    list(reader.receive())
"""


def median_ticks_us(recorder: Recorder, feed: ConsoleFeedSocket) -> tuple[float, float]:
    """Of a site that records, and of one that feeds a console besides; both do the same touches."""
    sites = Working(recorder=recorder), Working(recorder=recorder, feed=feed)
    for working in sites:
        working.press(0.02)
    took_us: tuple[list[float], list[float]] = [], []
    for _, (working, took) in itertools.product(range(TURNS), zip(sites, took_us, strict=True)):
        for _ in range(TICKS):
            working.now_ns += 2 * MS
            began_s = time.perf_counter()
            working.site.tick(working.now_ns)
            took.append((time.perf_counter() - began_s) * 1e6)
    return statistics.median(took_us[0]), statistics.median(took_us[1])


@pytest.mark.long
def test_a_console_costs_the_loop_almost_nothing(tmp_path: Path, keys: Keys, base_port: int) -> None:
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, sys.path))}
    with (
        Recorder(tmp_path / "a.mcap", SCHEMAS, {}) as recorder,
        ConsoleFeedSocket(base_port, load_keys(keys.operator)) as feed,
    ):
        reader = subprocess.Popen([sys.executable, "-c", READER, str(base_port), str(keys.operator)], env=environment)
        try:
            without_us, with_us = median_ticks_us(recorder, feed)
        finally:
            reader.kill()
            reader.wait()
    print(f"median tick {without_us:.0f} us, with a console {with_us:.0f} us, ratio {with_us / without_us:.3f}")
    assert with_us < MOST * without_us
