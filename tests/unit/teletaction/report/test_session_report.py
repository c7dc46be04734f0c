"""A report replaces no recording that it is made of, and has no figures of another session."""

import json
from collections import Counter
from pathlib import Path

import pytest

from teletaction.report.session_report import report
from tests.commands import command, one_line
from tests.unit.teletaction.held_recordings import held
from tests.unit.teletaction.recorded_examination import record


def test_the_summary_is_not_replaced_by_the_report(tmp_path: Path) -> None:
    recording, summary = record(tmp_path / "operator.mcap"), tmp_path / "summary.json"
    summary.write_text("{}", "utf-8")
    line = one_line(command("report", recording, "--out", summary), 2)
    assert f"{summary}: is the summary to report on; name another file with --out" in line
    assert summary.read_text("utf-8") == "{}"


@pytest.mark.parametrize("name", ["operator.mcap", "link.html"])
def test_a_recording_is_not_replaced_by_its_report(name: str, tmp_path: Path) -> None:
    recording = record(tmp_path / "operator.mcap")
    content = recording.read_bytes()
    (tmp_path / "link.html").symlink_to(recording)
    line = one_line(command("report", recording, "--out", tmp_path / name), 2)
    assert f"{name}: is a recording to report on; name another file with --out" in line
    assert recording.read_bytes() == content


def test_a_recording_that_is_named_twice_is_refused(tmp_path: Path) -> None:
    recording = record(tmp_path / "operator.mcap")
    line = one_line(command("report", recording, recording, "--out", tmp_path / "report.html"), 2)
    assert f"{recording}: is named twice" in line
    assert not (tmp_path / "report.html").exists()


@pytest.mark.parametrize(
    "summary",
    [
        "[]",
        '{"contacts": 12}',
        '{"fingers": "two"}',
        '{"loop": {"a": 3}}',
        '{"latency_ms": 5}',
        '{"modes": {"confusion": [1]}}',
        '{"duration_s": "long", "loop": {"a": {"behind_s": 9.0}}}',
    ],
)
def test_a_summary_of_another_program_is_refused_in_one_line(summary: str, tmp_path: Path) -> None:
    (tmp_path / "summary.json").write_text(summary, "utf-8")
    line = one_line(command("report", record(tmp_path / "operator.mcap"), "--out", tmp_path / "report.html"), 2)
    assert f"{tmp_path / 'summary.json'}: not a summary of a session: Expected" in line


@pytest.mark.parametrize(("summary", "why"), [(100_000 * "[", "nested too deeply"), ("{", "Expecting property name")])
def test_a_summary_that_is_not_json_is_refused_in_one_line(summary: str, why: str, tmp_path: Path) -> None:
    (tmp_path / "summary.json").write_text(summary, "utf-8")
    line = one_line(command("report", record(tmp_path / "operator.mcap"), "--out", tmp_path / "report.html"), 2)
    assert f"{tmp_path / 'summary.json'}: not JSON: {why}" in line


@pytest.mark.long
@pytest.mark.parametrize("more", [0, 1])
@pytest.mark.usefixtures("coarse")
def test_the_figures_of_another_session_are_left_out(
    more: int, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    recording = record(tmp_path / "session.mcap")
    counts = Counter(stream for stream, _, _ in held(recording))
    counts["operator/touch"] += more
    summary = {"recorded": counts, "scene": "of another session"}
    (tmp_path / "summary.json").write_text(json.dumps(summary), "utf-8")
    report([recording], tmp_path / "report.html")
    assert ("of another session" in (tmp_path / "report.html").read_text("utf-8")) is not bool(more)
    assert ("summary.json: is of other recordings" in caplog.text) is bool(more)
