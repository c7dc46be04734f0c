"""`--json` prints one object with what the command prints for people."""

import csv
import json
from pathlib import Path

import pytest

from common.link.keys import load_keys
from common.recording.recorder import Recorder
from teletaction.session.demo_files import PROCESSES
from tests.commands import command
from tests.conftest import Keys
from tests.unit.teletaction.recorded_examination import record
from tests.writer_thread import write_in_a_thread

COUNTS = {"touch": 3, "motion": 3}
STATUS = {
    "time_ns": 1,
    "script_s": 36.0,
    "rss_mib": 50.0,
    "loop": {"cpu": 0.2},
    "sent": COUNTS,
    "received": COUNTS,
    "superseded": COUNTS,
    "refused": {"touch": {}, "motion": {}, "damaged": {}},
}
"""Last status of a process."""


@pytest.mark.long
@pytest.mark.usefixtures("usual_speed")
def test_checks_of_the_doctor(configs: dict[str, Path]) -> None:
    result = command("doctor", "--config", configs["remote"], "--json")
    assert result.code == 1, "a failed check is an error in either form"
    assert len(result.err.splitlines()) == 1
    checks = json.loads(result.out)["checks"]
    lines = command("doctor", "--config", configs["remote"]).out.splitlines()
    assert [f"{'ok  ' if each['good'] else 'FAIL'} {each['check']}" for each in checks] == [
        line.split(":")[0] for line in lines
    ]


def test_devices_of_a_host(tmp_path: Path) -> None:
    result = command("doctor", "--ports", tmp_path, "--json")
    assert result.code == 1
    assert all(each.keys() == {"address", "good", "device"} for each in json.loads(result.out)["devices"])


def test_keys(keys: Keys) -> None:
    result = command("keys", "show", "--keys", keys.remote, "--json")
    trusted = [{"name": "operator", "role": "partner", "key": load_keys(keys.operator).public}]
    assert (result.code, result.err) == (0, "")
    assert json.loads(result.out) == {"own": load_keys(keys.remote).public, "trusted": trusted}


def test_objects_of_a_scene() -> None:
    result = command("scene", "check", "materials", "--json")
    assert (result.code, result.err) == (0, "")
    objects = json.loads(result.out)["objects"]
    rows = list(csv.DictReader(command("scene", "check", "materials").out.splitlines()))
    assert [list(each) for each in objects] == [list(row) for row in rows]
    for each, row in zip(objects, rows, strict=True):
        written = {name: f"{value:.3g}" if isinstance(value, float) else str(value) for name, value in each.items()}
        assert written | {"step_us": ""} == row | {"step_us": ""}, "all but the measured time of a step"


@pytest.mark.long
@pytest.mark.usefixtures("coarse")
def test_summary_of_a_session(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_in_a_thread(monkeypatch)
    record(tmp_path / "operator.mcap", console=False)
    simulated = {"configuration": 'scene = "phantom"\nseed = 4\nfingers = ["thumb", "index"]\n'}
    for process in PROCESSES:
        if process != "operator":
            facts = simulated if process == "sim-remote" else {}
            Recorder(tmp_path / f"{process}.mcap", {}, facts).close()
        (tmp_path / f"{process}.json").write_text(json.dumps(STATUS), "utf-8")
    out = tmp_path / "out"
    result = command("summarise", "--recordings", tmp_path, "--out", out, "--json")
    assert result.code == 0, result.err
    verdict, files = result.err.splitlines()
    assert verdict.startswith("This machine was fast enough: every process held its rate.")
    assert files == f"summary {out / 'summary.json'}, report {out / 'report.html'}"
    shown = json.loads(result.out)
    assert shown == json.loads((out / "summary.json").read_text("utf-8"))
    assert (shown["duration_s"], shown["packets"]["touch"]["sent"]) == (36.0, 3)
    assert (shown["scene"], shown["seed"], shown["fingers"]) == ("phantom", 4, 2), "those of the recording"
    given = "--scene", "materials", "--seed", 0, "--fingers", 1
    shown = json.loads(command("summarise", "--recordings", tmp_path, "--out", out, *given, "--json").out)
    assert (shown["scene"], shown["seed"], shown["fingers"]) == ("materials", 0, 1)
