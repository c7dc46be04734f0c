"""Both sites tick at the rates that a session is given, and a process that does not hold its rate says so.

How many ticks are made at which rates depends on the machine: `teletaction study rates` measures it.
"""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from common.runtime.rate_monitor import HELD

pytestmark = [pytest.mark.session, pytest.mark.timeout(120)]

SURELY = 0.02
"""So far below HELD over the whole session, a rate was not held in some WINDOW_S of it."""


def test_a_session_ticks_at_the_rates_it_is_given(tmp_path: Path) -> None:
    demo = ["demo", "--headless", "--seconds", "12", "--rates", "1000,1000", "--out"]
    run = subprocess.run(
        [sys.executable, "-m", "teletaction", *demo, str(tmp_path)], stderr=subprocess.PIPE, text=True, check=False
    )
    assert run.returncode == 0, run.stderr
    assert "the operator site 1000 times" in run.stderr
    loops = json.loads((tmp_path / "summary.json").read_text("utf-8"))["loop"]
    assert loops["operator"]["period_ms"] == loops["remote"]["period_ms"] == 1.0
    silent = {
        name: loop
        for name, loop in loops.items()
        if loop["ticks"] < (HELD - SURELY) * (loop["ticks"] + loop["missed"]) and not loop["behind_s"]
    }
    assert silent == {}
