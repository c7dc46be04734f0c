"""A recording that stopped is still known after the session: in the summary, the report and the demo's exit code."""

from pathlib import Path
from typing import Any

import pytest

from teletaction.recordings.incidents import incomplete_recordings, interruptions
from teletaction.recordings.session_data import SessionData
from teletaction.report.report import write_report
from teletaction.session import demo
from teletaction.session.conclude import remove_merged
from teletaction.session.demo_files import DemoOptions
from tests.unit.teletaction.report.test_report import nothing, summary

WHY = "the process that writes it has ended"
STOPPED = f"recording incomplete: {WHY}, 311 messages lost"
SLOW = "recording incomplete: the disk was slower than the data, 4 messages lost"
STATUSES: dict[str, dict[str, Any]] = {
    "remote": {"recording_failed": WHY, "recording_lost": 311, "recording_failed_ns": 12_500_000_000},
    "operator": {"recording_failed": "", "recording_lost": 4, "recording_failed_ns": None},
    "sim-remote": {},
}


def session() -> SessionData:
    data = nothing()
    data.happenings.append({"time_s": 10.0, "site": "remote", "what": "connected", "text": ""})
    return data


def test_a_recording_that_stopped_or_lost_something_is_a_fault_with_its_time_and_in_the_report(tmp_path: Path) -> None:
    found = stopped, slow = incomplete_recordings(session(), STATUSES)
    assert stopped == {"site": "remote", "what": "recording", "fault": STOPPED, "time_s": 2.5}
    assert slow == {"site": "operator", "what": "recording", "fault": SLOW, "time_s": None}
    write_report(nothing(), summary(faults=found), tmp_path / "r.html")
    assert f"remote: {STOPPED}" in (tmp_path / "r.html").read_text("utf-8")


def test_changes_of_clutch_and_scale_are_listed_with_what_interrupted() -> None:
    data = session()
    for time_s, what, text in ((11.0, "clutch", "open"), (12.0, "scale", "1:5"), (12.5, "engaged", "")):
        happening = {"time_s": time_s, "site": "operator", "what": what, "text": text, "fault": None}
        data.happenings.append(happening)
    found = [(entry["what"], entry["fault"], entry["time_s"]) for entry in interruptions(data)]
    assert found == [("clutch", "open", 1.0), ("scale", "1:5", 2.0)]


@pytest.mark.parametrize(("stopped", "failure"), [(True, f"remote: {STOPPED}; operator: {SLOW}"), (False, "")])
def test_the_demo_fails_where_a_recording_stopped_and_keeps_what_is_needed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, stopped: bool, failure: str
) -> None:
    found = incomplete_recordings(session(), STATUSES) if stopped else []
    monkeypatch.setattr("teletaction.session.conclude.conclude", lambda *_: summary(faults=found, loop={}))
    assert demo._conclude(DemoOptions(), tmp_path) == failure
    recording = tmp_path / "remote.mcap"
    recording.touch()
    remove_merged([recording], summary(faults=found))
    assert recording.exists() is stopped


def test_the_demo_fails_where_a_process_was_killed() -> None:
    assert demo.killed_words([]) == ""
    assert demo.killed_words(["operator", "remote"]) == "killed, since they did not end within 10 s: operator, remote"
