"""A console that starts continues the unfinished examination of another run, and nothing else."""

import math
from pathlib import Path
from typing import Any
from unittest.mock import Mock

import pytest

from common.config.page_models import ConsoleConfig
from common.recording.clock_anchor import boot_id
from operator_site.console.examination import journal as keeping_module
from operator_site.console.examination.journal import Journal
from operator_site.console.examination.resume import Unfinished, unfinished
from operator_site.console.live import LiveConsole
from tests.unit.operator_site.console.page_room import AnsweringSite, MemoryJournal
from tests.unit.operator_site.console.touch_rows import sample


def session(what: str, at_s: float, pseudonym: str = "P-0417") -> dict[str, Any]:
    return {"what": what, "at_s": at_s, "pseudonym": pseudonym, "sides": None}


def finding(ident: int, at_s: float, note: str = "") -> dict[str, Any]:
    return {"id": ident, "at_s": at_s, "note": note}


SAMPLE = sample("stiffness", 1, 0.01, 0.0, 6.0, 0.01)
DAMAGED = (SAMPLE._replace(x_m=math.inf), SAMPLE._replace(variance=0.0), SAMPLE._replace(y_m=math.nan))
STREAMS = {"what": "console/session", "samples": "console/felt", "note": "console/finding"}


def run(path: Path, *kept: tuple[float, dict[str, Any]]) -> Unfinished:
    """One run of a console, which keeps this; what it found to continue."""
    keeping = Journal(path, {})
    for now_s, record in kept:
        keeping.write(next(STREAMS[key] for key in STREAMS if key in record), now_s, record)
        keeping.write("console/act", now_s, {"verb": "anything"})
    keeping.close()
    return keeping.unfinished


def test_an_examination_continues_over_any_number_of_runs(tmp_path: Path) -> None:
    path = tmp_path / "console.mcap"
    assert run(path, (1.0, session("begin", 1.0, "P-0001")), (2.0, session("end", 2.0, "P-0001"))) == Unfinished()
    assert run(path, (3.0, session("begin", 3.0)), (4.0, finding(1, 4.0)), (5.0, finding(1, 4.0, "a"))) == Unfinished()
    second = run(path, (6.0, finding(2, 6.0)))
    assert second.files == (tmp_path / "console-1.mcap",)
    assert [record.get("note") for _, record in second.records] == [None, "", "a"]
    third = run(path)
    assert third.files == (tmp_path / "console-1.mcap", tmp_path / "console-2.mcap")
    assert third.findings == {1, 2}
    assert third.cut_off == ""
    assert run(path, (9.0, session("end", 9.0))).findings == {1, 2}
    assert run(path) == Unfinished()


def test_samples_of_the_map_are_among_it(tmp_path: Path) -> None:
    path = tmp_path / "console.mcap"
    run(path, (1.0, session("begin", 1.0)), (2.0, {"samples": []}), (3.0, finding(1, 3.0)))
    before = run(path)
    assert [stream for stream, _ in before.records] == [*STREAMS.values()]
    assert [record for _, record in before.records] == [session("begin", 1.0), {"samples": []}, finding(1, 3.0)]
    assert before.findings == {1}


def test_an_examination_continues_after_the_sites_clock_began_again(tmp_path: Path) -> None:
    path = tmp_path / "console.mcap"
    samples: dict[str, Any] = {"samples": [1]}
    run(path, (3700.0, session("begin", 3700.0)), (3701.0, finding(1, 3701.0)), (100.0, finding(2, 100.0)))
    run(path, (101.0, samples), (102.0, finding(3, 102.0)))
    assert [record for _, record in run(path).records] == [
        session("begin", 3700.0),
        finding(1, 3701.0),
        finding(2, 100.0),
        samples,
        finding(3, 102.0),
    ]
    run(path, (103.0, session("end", 103.0)))
    assert run(path) == Unfinished()


def test_a_record_that_two_files_hold_counts_once(tmp_path: Path) -> None:
    """A journal that opens another file writes what it has not confirmed again."""
    path = tmp_path / "console.mcap"
    again: list[tuple[float, dict[str, Any]]] = [(2.0, {"samples": [1]}), (3.0, {"samples": [2]})]
    run(path, (1.0, session("begin", 1.0)), *again)
    run(path, *again, (4.0, finding(1, 4.0)))
    assert [record for _, record in run(path).records] == [
        session("begin", 1.0),
        *(record for _, record in again),
        finding(1, 4.0),
    ]


def test_what_was_saved_by_an_earlier_run_is_saved_and_goes_into_the_report(tmp_path: Path) -> None:
    path = tmp_path / "console.mcap"
    run(path, (1.0, session("begin", 1.0)), (2.0, finding(1, 2.0)))
    keeping = Journal(path, {})
    assert keeping.is_saved(1)
    assert keeping.files == [path, tmp_path / "console-1.mcap"]
    keeping.forget()
    assert keeping.files == [tmp_path / "console-1.mcap"]
    keeping.close()


@pytest.mark.parametrize("share", [0.2, 0.5, 0.8, 0.99])
def test_a_killed_run_leaves_what_it_had_written(tmp_path: Path, share: float) -> None:
    path = tmp_path / "console.mcap"
    keeping = Journal(path, {})
    keeping.write("console/session", 1.0, session("begin", 1.0))
    for ident in range(1, 21):
        keeping.write("console/finding", ident, finding(ident, float(ident), "x" * 500))
        while not keeping.is_saved(ident):
            keeping.step(ident)
    whole = path.read_bytes()  # not closed: as a killed process leaves it
    keeping.close()
    path.write_bytes(whole[: round(share * len(whole))])
    before = unfinished(path, boot_id())
    assert before.findings == set(range(1, len(before.findings) + 1))
    assert len(before.findings) >= 20 * share - 4


def test_what_another_run_of_the_machine_left_is_said_and_not_continued(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "console.mcap"
    with monkeypatch.context() as patch:
        patch.setattr(keeping_module, "boot_id", lambda: "another")
        run(path, (50_000.0, session("begin", 50_000.0)), (50_001.0, finding(1, 50_001.0)))
    keeping = Journal(path, {})
    assert keeping.unfinished.cut_off == "P-0417"
    assert keeping.unfinished.findings == {1}
    assert keeping.unfinished.files == (path,)
    assert not keeping.is_saved(1)
    assert keeping.files == [tmp_path / "console-1.mcap"]
    keeping.close()
    assert run(path) == Unfinished(), "it is said once"


def test_what_a_supervisor_has_set_aside_is_found(tmp_path: Path) -> None:
    path = tmp_path / "console.mcap"
    run(path, (1.0, session("begin", 1.0)), (2.0, finding(1, 2.0)))
    aside = path.rename(tmp_path / "console-20261103T140700Z.mcap")
    before = run(path, (3.0, finding(2, 3.0)))
    assert (before.files, before.findings) == ((aside,), {1})
    path.rename(tmp_path / "console-20261103T140900Z.mcap")
    assert run(path).findings == {1, 2}


@pytest.mark.parametrize("content", [b"", b"no recording at all", bytes(10_000)])
def test_a_file_that_is_none_hides_nothing(tmp_path: Path, content: bytes) -> None:
    path = tmp_path / "console.mcap"
    run(path, (1.0, session("begin", 1.0)), (2.0, finding(1, 2.0)))
    (tmp_path / "console-1.mcap").write_bytes(content)
    (tmp_path / "console-notes.mcap").write_bytes(content)
    assert unfinished(path, boot_id()).findings == {1}


def test_damaged_records_hide_no_other(tmp_path: Path) -> None:
    moment = {"kind": "warm", "finger": "index", "x_m": None, "y_m": None, "text": ""}
    records = [
        ("console/session", session("begin", 1.0)),
        ("console/finding", finding(1, 2.0) | moment),
        *(("console/finding", damaged) for damaged in ({"note": ""}, {"id": [1]})),
        *(("console/felt", {"samples": [tuple(damaged)]}) for damaged in DAMAGED),
        ("console/felt", {"samples": [tuple(SAMPLE)]}),
    ]
    journal = MemoryJournal()
    journal.unfinished = Unfinished(records=tuple(records))
    assert journal.unfinished.findings == {1}
    console = LiveConsole(ConsoleConfig(keys=tmp_path), Mock(), AnsweringSite(), journal).console
    assert [*console.examination.findings] == [1]
    assert console.tactile_map.at(0.01, 0.0).stiffness is not None
