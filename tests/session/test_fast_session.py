"""A session at the faster rates holds them, where the machine is said to hold them."""

import json
import subprocess
import sys
from pathlib import Path

import pytest

from common.machine import Machine
from teletaction.session_rates import FASTER, fitting_rates

pytestmark = [pytest.mark.session, pytest.mark.timeout(120)]

HELD = 0.99
"""Least share of its ticks that each loop makes."""


def test_rates_that_fit_are_held(tmp_path: Path) -> None:
    machine = Machine.measured()
    if (rates := fitting_rates(machine)) not in FASTER:
        pytest.skip(f"a step takes {machine.step_s * 1e6:.0f} us and {machine.idle:.1f} processors are idle: none fit")
    demo = ["demo", "--headless", "--seconds", "20", "--out"]
    run = subprocess.run(
        [sys.executable, "-m", "teletaction", *demo, str(tmp_path), "--rates", str(rates)],
        stderr=subprocess.PIPE,
        text=True,
        check=False,
    )
    assert run.returncode == 0, run.stderr
    assert f"the operator site {rates.operator_hz:g} times" in run.stderr
    summary = json.loads((tmp_path / "summary.json").read_text("utf-8"))
    made = {name: loop["ticks"] / (loop["ticks"] + loop["missed"]) for name, loop in summary["loop"].items()}
    assert {name: share for name, share in made.items() if share < HELD} == {}
    assert summary["loop"]["operator"]["period_ms"] == 1e3 / rates.operator_hz
    assert summary["taps"]["played"] == summary["taps"]["made"] > 0
