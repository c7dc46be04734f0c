"""A recording that stopped is still known after the session: in the summary, the report and the demo's exit code."""

from pathlib import Path
from typing import Any

import pytest

from teletaction import demo
from teletaction.demo_files import PROCESSES, DemoOptions
from teletaction.incidents import incomplete_recordings
from teletaction.ping import BarePing
from teletaction.report import write_report
from teletaction.session_data import SessionData
from tests.teletaction.test_report import nothing, summary

WHY = "the process that writes it has ended"
STATUSES: dict[str, dict[str, Any]] = {
    "remote": {"recording_failed": WHY, "recording_lost": 311, "recording_failed_ns": 12_500_000_000},
    "operator": {"recording_failed": "", "recording_lost": 4, "recording_failed_ns": None},
    "sim-remote": {},
}


def session() -> SessionData:
    data = nothing()
    data.happenings.append({"time_s": 10.0, "site": "remote", "what": "connected", "text": ""})
    return data


def test_a_recording_that_stopped_or_lost_something_is_a_fault_with_its_time() -> None:
    stopped, slow = incomplete_recordings(session(), STATUSES)
    words = f"recording incomplete: {WHY}, 311 messages lost"
    assert stopped == {"site": "remote", "what": "recording", "fault": words, "time_s": 2.5}
    assert (slow["site"], slow["time_s"]) == ("operator", None)
    assert "4 messages lost" in slow["fault"]


def test_the_report_names_it(tmp_path: Path) -> None:
    found = incomplete_recordings(session(), STATUSES)
    write_report(nothing(), summary(faults=found), tmp_path / "r.html")
    assert f"remote: recording incomplete: {WHY}, 311 messages lost" in (tmp_path / "r.html").read_text("utf-8")


@pytest.mark.parametrize("complete", [False, True])
def test_the_demo_fails_and_keeps_what_each_process_wrote(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, complete: bool
) -> None:
    found = [] if complete else incomplete_recordings(session(), STATUSES)
    monkeypatch.setattr("teletaction.conclude.conclude", lambda *_: summary(faults=found, loop={}))
    for process in PROCESSES:
        (tmp_path / f"{process}.mcap").touch()
    with BarePing() as ping:
        failure = demo._conclude(DemoOptions(), tmp_path, ping, {}, 1.0, [])
    assert bool(failure) is not complete
    assert failure.startswith("" if complete else f"remote: recording incomplete: {WHY}, 311 messages lost")
    assert (tmp_path / "remote.mcap").exists() is not complete


def test_the_demo_fails_and_names_the_processes_that_it_had_to_kill(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("teletaction.conclude.conclude", lambda *_: summary(faults=[], loop={}))
    for process in PROCESSES:
        (tmp_path / f"{process}.mcap").touch()
    with BarePing() as ping:
        failure = demo._conclude(DemoOptions(), tmp_path, ping, {}, 1.0, ["operator", "remote"])
    assert failure == "killed, since they did not end within 10 s: operator, remote"
