"""Files about an examined person are readable by the user who made them, and by nobody else of the machine."""

import os
import stat
from collections.abc import Iterator
from pathlib import Path

import pytest

from remote_site.voice.sound_sink import WavSink
from teletaction.session.launcher_figures import LauncherFigures
from teletaction.session.processes import SessionProcesses
from tests.commands import command
from tests.places import GOLDEN
from tests.unit.teletaction.recorded_examination import record, record_findings


@pytest.fixture(autouse=True)
def _usual_umask() -> Iterator[None]:
    before = os.umask(0o022)
    yield
    os.umask(before)


def others_read(folder: Path) -> list[str]:
    """The files that not only their owner may read or write."""
    files = [path for path in folder.rglob("*") if path.is_file()]
    assert files
    return [path.name for path in files if stat.S_IMODE(path.stat().st_mode) != 0o600]


def test_maps_sounds_figures_and_logs_are_private(tmp_path: Path) -> None:
    (tmp_path / "grid.csv").write_text("x_mm,y_mm,object_c\n1,1,33.1\n4,1,33.4\n", "utf-8")
    assert command("map", tmp_path / "grid.csv", "--out", tmp_path / "out").code == 0
    WavSink(tmp_path / "out" / "heard.wav").close()
    LauncherFigures({}, 1.0, []).write(tmp_path / "out")
    processes = SessionProcesses(tmp_path / "out")
    processes.start("console", tmp_path / "none.toml")
    processes.running["console"].wait()
    assert others_read(tmp_path / "out") == []


def test_a_private_file_takes_the_place_of_an_earlier_open_one(tmp_path: Path) -> None:
    (tmp_path / "grid.csv").write_text("x_mm,y_mm,object_c\n1,1,33.1\n4,1,33.4\n", "utf-8")
    (tmp_path / "out").mkdir()
    for name in ("map.csv", "map.json", "map.png"):
        (tmp_path / "out" / name).write_text("of an earlier version", "utf-8")
    assert command("map", tmp_path / "grid.csv", "--out", tmp_path / "out").code == 0
    assert others_read(tmp_path / "out") == []


@pytest.mark.long
def test_reports_exports_and_replays_are_private(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("teletaction.report.report_parts.DPI", 20)
    record(tmp_path / "operator.mcap")
    record_findings(tmp_path / "console.mcap", [{}])
    assert command("report", tmp_path / "operator.mcap", "--out", tmp_path / "report.html").code == 0
    for to in ("csv", "foxglove", "fhir"):
        done = command("export", tmp_path / "operator.mcap", "--to", to, "--out", tmp_path / "exports" / to)
        assert done.code == 0, done.err
    assert command("replay", GOLDEN, "--out", tmp_path / "replayed").code == 0
    assert others_read(tmp_path) == []


@pytest.mark.exports
def test_exports_by_optional_packages_are_private(tmp_path: Path) -> None:
    record(tmp_path / "operator.mcap")
    record_findings(tmp_path / "console.mcap", [{}])
    for to in ("parquet", "dicom-sr", "rerun"):
        done = command("export", tmp_path / "operator.mcap", "--to", to, "--out", tmp_path / "exports" / to)
        assert done.code == 0, done.err
    assert others_read(tmp_path) == []
