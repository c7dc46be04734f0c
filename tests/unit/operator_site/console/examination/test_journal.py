"""Saved findings are on the disk; what a full disk did not take is kept, and written when there is room again."""

import errno
import os
import resource
import shutil
import signal
import subprocess
from collections import Counter
from contextlib import suppress
from pathlib import Path
from typing import Any
from unittest.mock import MagicMock, Mock

import pytest

from operator_site.console.examination.journal import AGAIN_S, Journal
from tests.system.truth import written
from tests.waiting import wait_until


def finding(ident: int, note: str = "") -> dict[str, Any]:
    return {"id": ident, "note": note}


def until_saved(keeping: Journal, ident: int, now_s: float) -> None:
    def saved() -> bool:
        keeping.step(now_s)
        return keeping.is_saved(ident)

    wait_until(saved)


def test_a_finding_is_saved_when_its_newest_record_is_on_the_disk(tmp_path: Path) -> None:
    keeping = Journal(tmp_path / "console.mcap", {})
    for note in ("", "a", "ab"):
        keeping.write("console/finding", 1.0, finding(1, note))
    keeping.write("console/act", 1.0, {"verb": "finding"})
    assert not keeping.is_saved(1)
    until_saved(keeping, 1, 2.0)
    kept = written(tmp_path / "console.mcap", "console/finding", may_be_cut=True)
    assert [record["note"] for _, record in kept] == ["", "a", "ab"], "it is there before it is called saved"
    keeping.write("console/finding", 3.0, finding(1, "abc"))
    assert not keeping.is_saved(1), "its new note is not"
    until_saved(keeping, 1, 3.0)
    assert keeping.unsaved == 0
    keeping.close()


def no_more_room(path: Path) -> None:
    """The process that writes the file may not enlarge it."""
    for opened in Path("/proc").glob("[0-9]*/fd/*"):
        with suppress(OSError):
            if opened.samefile(path):
                size = path.stat().st_size
                resource.prlimit(int(opened.parts[2]), resource.RLIMIT_FSIZE, (size, size))
                return
    raise AssertionError("no process writes it")


def test_a_full_disk_loses_nothing_and_is_tried_again(tmp_path: Path) -> None:
    keeping = Journal(tmp_path / "console.mcap", {})
    keeping.write("console/finding", 0.5, finding(1))
    until_saved(keeping, 1, 0.5)
    no_more_room(tmp_path / "console.mcap")
    keeping.write("console/finding", 1.0, finding(2, "lesion"))
    wait_until(lambda: keeping.failed)
    keeping.write("console/finding", 2.0, finding(3))
    keeping.write("console/act", 2.0, {"verb": "finding"})
    assert not keeping.is_saved(2)
    assert keeping.is_saved(1)
    keeping.step(10.0)
    until_saved(keeping, 3, 10.0)
    assert keeping.is_saved(2)
    keeping.close()
    again = written(tmp_path / "console-1.mcap", "console/finding")
    assert [record["id"] for _, record in again] == [2, 3]
    assert [time_s for time_s, _ in again] == [1.0, 2.0], "they keep their own times"


def test_a_further_examination_gets_a_file_of_its_own(tmp_path: Path) -> None:
    """The report of the examination before is written later, and must not find the next one in its file."""
    keeping = Journal(tmp_path / "console.mcap", {})
    keeping.forget()
    keeping.write("console/session", 1.0, {"what": "begin", "pseudonym": "P-0417"})
    keeping.write("console/finding", 2.0, finding(1))
    until_saved(keeping, 1, 2.0)
    keeping.write("console/session", 3.0, {"what": "end", "pseudonym": "P-0417"})
    first = keeping.files
    keeping.forget()
    keeping.write("console/session", 4.0, {"what": "begin", "pseudonym": "P-0418"})
    keeping.write("console/finding", 5.0, finding(1))
    assert not keeping.is_saved(1)
    until_saved(keeping, 1, 5.0)
    assert first == [tmp_path / "console.mcap"]
    assert keeping.files == [tmp_path / "console-1.mcap"]
    keeping.close()
    named = [{entry["pseudonym"] for _, entry in written(path, "console/session")} for path in (*first, *keeping.files)]
    assert named[0] == {"P-0417"}
    assert "P-0418" in named[1]


def test_only_the_first_record_is_confirmed_when_it_is_written_during_a_step(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    counts = iter([0])
    written = MagicMock()
    written.__getitem__.side_effect = lambda stream: next(counts, 1) if stream == "console/finding" else 0
    recorder = Mock(failed=None, written=written)
    monkeypatch.setattr("operator_site.console.examination.journal.Recorder", Mock(return_value=recorder))
    keeping = Journal(tmp_path / "console.mcap", {})
    for ident in (1, 2):
        keeping.write("console/finding", 1.0, finding(ident))
    keeping.step(1.1)
    assert not keeping.is_saved(2)
    keeping.step(1.2)
    assert [keeping.is_saved(ident) for ident in (1, 2)] == [True, False]


def test_a_record_that_memory_has_no_room_for_confirms_no_other(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    recorder = Mock(failed=None, written=Counter())
    monkeypatch.setattr("operator_site.console.examination.journal.Recorder", Mock(return_value=recorder))
    monkeypatch.setattr("operator_site.console.examination.journal._MOST_UNSAVED", 2)
    keeping = Journal(tmp_path / "console.mcap", {})
    for ident in (1, 2, 3):
        keeping.write("console/finding", 1.0, finding(ident))
    for on_disk, saved in ((1, []), (2, [2]), (3, [2, 3])):
        recorder.written = Counter({"console/finding": on_disk})
        keeping.step(1.0)
        assert [ident for ident in (1, 2, 3) if keeping.is_saved(ident)] == saved


def test_pictures_that_wait_for_a_stalled_disk_leave_room_for_findings(tmp_path: Path) -> None:
    keeping = Journal(tmp_path / "console.mcap", {})
    assert keeping._recorder is not None
    writer = keeping._recorder._process.pid
    os.kill(writer, signal.SIGSTOP)
    try:
        for _ in range(21_000):  # more than the recorder queues
            keeping.write_media("console/camera", 1.0, {"content": b""})
        keeping.write("console/finding", 1.0, finding(1))
    finally:
        os.kill(writer, signal.SIGCONT)
    wait_until(lambda: keeping._recorder is not None and keeping._recorder.written["console/camera"] > 1000)
    keeping.write("console/finding", 2.0, finding(2))
    until_saved(keeping, 2, 3.0)
    assert keeping.is_saved(1)
    keeping.close()
    assert [record["id"] for _, record in written(tmp_path / "console.mcap", "console/finding")] == [1, 2]


def test_a_console_starts_on_a_full_disk_which_is_tried_every_few_seconds(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    opening = Mock(side_effect=OSError(errno.ENOSPC, "No space left on device"))
    with monkeypatch.context() as patch:
        patch.setattr("operator_site.console.examination.journal.Recorder", opening)
        keeping = Journal(tmp_path / "console.mcap", {})
        for tenth in range(100, 200):
            keeping.step(0.1 * tenth)
            keeping.write("console/finding", 0.1 * tenth, finding(tenth))
        assert keeping.failed
        assert opening.call_count == pytest.approx(1.0 + 10.0 / AGAIN_S, abs=1)
        assert keeping.unsaved == 100
        assert not any(keeping.is_saved(tenth) for tenth in range(100, 200))
    until_saved(keeping, 199, 30.0)
    assert keeping.unsaved == 0
    keeping.close()
    with pytest.raises(FileNotFoundError):
        Journal(tmp_path / "no such folder" / "console.mcap", {})


def test_a_disk_that_stays_full_is_not_strewn_with_files_and_room_is_used_at_once(tmp_path: Path) -> None:
    """A real one of 64 kB."""
    disk = tmp_path / "disk"
    disk.mkdir()
    mount = ("mount", "-t", "tmpfs", "-o", "size=64k", "teletaction-test", str(disk))
    if shutil.which("mount") is None or subprocess.run(mount, capture_output=True, check=False).returncode:
        pytest.skip("no disk can be mounted here")
    try:
        keeping = Journal(disk / "console.mcap", {})
        keeping.write("console/finding", 0.5, finding(1))
        until_saved(keeping, 1, 0.5)
        (disk / "other").write_bytes(bytes(shutil.disk_usage(disk).free))
        keeping.write("console/finding", 1.0, finding(2, "x" * 10_000))
        now_s, tries = 10.0, 5
        for _ in range(tries):
            now_s += AGAIN_S
            keeping.step(now_s)
            wait_until(lambda: keeping.failed)
            keeping.write("console/finding", now_s, finding(3))
            assert (keeping.is_saved(1), keeping.is_saved(2), keeping.is_saved(3)) == (True, False, False)
        assert len([*disk.glob("console*.mcap")]) <= 2
        (disk / "other").unlink()
        now_s += AGAIN_S
        until_saved(keeping, 3, now_s)
        assert keeping.is_saved(2)
        keeping.close()
        assert [record["id"] for _, record in written(disk / "console-1.mcap", "console/finding")] == [2] + [3] * tries
        assert keeping.files == [disk / "console.mcap", disk / "console-1.mcap"]
    finally:
        subprocess.run(("umount", str(disk)), check=True)


def test_without_a_file_nothing_is_ever_saved() -> None:
    keeping = Journal(None, {})
    keeping.write("console/finding", 1.0, finding(1))
    keeping.step(2.0)
    assert not keeping.is_saved(1)
    assert not keeping.enabled
    keeping.close()
