"""Files of the project are recognised by name and content."""

import json
from pathlib import Path

import pytest

from teletaction.export.export import export
from teletaction.privacy.project_files import kind_of
from teletaction.session.launcher_figures import LAUNCHER, LauncherFigures
from tests.unit.teletaction.recorded_examination import record


def test_an_export_without_a_pseudonym_is_recognised(tmp_path: Path) -> None:
    record(tmp_path / "operator.mcap", console=False)
    export(tmp_path / "operator.mcap", "fhir", tmp_path / "out")
    (document,) = (tmp_path / "out").iterdir()
    assert b"pseudonym" not in document.read_bytes()
    assert kind_of(document) == "export"


@pytest.mark.parametrize("process", ["remote", "console-2", "patient-page", "tunnel", "rendezvous"])
def test_status_and_log_of_each_process_are_recognised(process: str, tmp_path: Path) -> None:
    status, log = tmp_path / f"{process}.json", tmp_path / f"{process}.log"
    status.write_text('{"process": "any", "rss_mib": 60.0}', "utf-8")
    log.write_text("1.0 any INFO teletaction: begin\n", "utf-8")
    assert (kind_of(status), kind_of(log)) == ("status", "log")


@pytest.mark.parametrize("name", ["console.log", "remote-2.log", "summarise.log"])
def test_an_empty_log_is_recognised_by_its_name(name: str, tmp_path: Path) -> None:
    (tmp_path / name).touch()
    assert kind_of(tmp_path / name) == "log"


@pytest.mark.parametrize(
    "said",
    [
        "81.250 console WARNING operator_site.console: picture late",
        "81.250 console ERROR operator_site.console: disk full",
        "teletaction: console.toml: no such file",
    ],
)
def test_a_log_without_usual_lines_is_recognised(said: str, tmp_path: Path) -> None:
    """TELETACTION_LOG=warning leaves out INFO, and a process that cannot start writes one line."""
    (tmp_path / "console.log").write_text(f"{said}\n", "utf-8")
    assert kind_of(tmp_path / "console.log") == "log"


@pytest.mark.parametrize("said", ["summary out/summary.json, report out/report.html", "teletaction: out: no recording"])
def test_the_log_of_a_summary_in_the_background_is_recognised(said: str, tmp_path: Path) -> None:
    log = tmp_path / "summarise.log"
    log.write_text(f"{said}\n", "utf-8")
    assert kind_of(log) == "log"
    log.write_text("of another program\n", "utf-8")
    assert kind_of(log) is None


def test_a_long_replay_is_recognised(tmp_path: Path) -> None:
    sites = {"remote": {"remote": {"ticks": 1, "changed_by_waiting": [{"finger": "index"}] * 5000}}, "operator": {}}
    (tmp_path / "replay.json").write_text(json.dumps({"recording": "session.mcap", **sites}, indent=1), "utf-8")
    assert kind_of(tmp_path / "replay.json") == "replay"


def test_the_figures_of_a_demo_are_recognised(tmp_path: Path) -> None:
    LauncherFigures({"remote": (0.1, 60.0)}, 3.0, [0.001] * 10_000).write(tmp_path)
    assert kind_of(tmp_path / LAUNCHER) == "status"
