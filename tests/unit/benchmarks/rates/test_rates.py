"""Rates are compared by sessions side by side: counts are added, all else is the median."""

import json
import subprocess
from pathlib import Path
from typing import Any

import pytest

from benchmarks.rates import run as rates
from benchmarks.rates.figure import plot
from benchmarks.rates.run import measure, tables
from teletaction.session.demo_files import PROCESSES
from teletaction.session.session_rates import Rates
from tests.unit.studies.written import draw_figure

CHOICES = (Rates(250, 500), Rates(1000, 1000))


def summary(delay_ms: float, missed: int) -> dict[str, Any]:
    touch = {"true_material": "pine", "material": "pine", "held_s": 3.0, "seconds": 1.0}
    unnamed = {"true_material": "pvc", "material": None, "held_s": 3.0, "seconds": None}
    short = {"true_material": "pvc", "material": None, "held_s": 1.0, "seconds": None}
    return {
        "loop": {name: {"ticks": 900, "missed": 100, "cpu": 0.2} for name in PROCESSES},
        "cpu_cores": 0.8,
        "latency_ms": {"contact_to_motor": {"p50": delay_ms, "p99": 2.0 * delay_ms}},
        "impulses": {"crossed": 100, "missed": missed, "invented": 1},
        "taps": {"made": 4, "played": 4},
        "contacts": [touch, unnamed, short],
        "modes": {"agreement": 0.99},
    }


@pytest.fixture
def data(monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    def ended(command: list[str], **_: object) -> subprocess.CompletedProcess[str]:
        seed, out = int(command[command.index("--seed") + 1]), Path(command[-1])
        (out / "summary.json").write_text(json.dumps(summary(5.0 + seed, seed)))
        return subprocess.CompletedProcess(command, 0, "", "")

    monkeypatch.setattr(rates.subprocess, "run", ended)
    return measure(CHOICES, [0, 1, 2], 9.0, lambda _: None)


@pytest.mark.long
def test_counts_are_added_and_the_rest_is_the_median(data: dict[str, Any]) -> None:
    (row, _) = data["rates"]
    assert (row["rates"], row["sessions"]) == ("250,500", 3)
    assert row["contact_to_motor_p50_ms"] == 6.0
    assert (row["grooves"], row["grooves_wrong"]) == (300, 6)
    assert (row["touches"], row["named_rightly"], row["named_wrongly"]) == (6, 3, 0)
    assert row["on_time"] == 0.9


@pytest.mark.long
def test_there_is_a_row_for_each_session_and_a_figure(data: dict[str, Any], tmp_path: Path) -> None:
    assert [len(rows) for rows in tables(data).values()] == [6, 2]
    draw_figure(plot, data, tmp_path)


def test_a_session_that_fails_ends_the_study_with_its_words(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        rates.subprocess, "run", lambda command, **_: subprocess.CompletedProcess(command, 1, "", "no port\n")
    )
    with pytest.raises(RuntimeError, match="rates 250,500, seed 0: no port"):
        measure(CHOICES, [0], 9.0, lambda _: None)
