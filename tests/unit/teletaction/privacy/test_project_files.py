"""Files of the project are recognised by name and content."""

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


def test_the_figures_of_a_demo_are_recognised(tmp_path: Path) -> None:
    LauncherFigures({"remote": (0.1, 60.0)}, 3.0, [0.001] * 10_000).write(tmp_path)
    assert kind_of(tmp_path / LAUNCHER) == "status"
