"""A person's latched stop is kept in a file, also on a full disk; a damaged file is a stop."""

import errno
import os
import time
from pathlib import Path
from unittest.mock import Mock

import pytest

from common.faults.fault import Fault, FaultCode
from common.faults.texts import fault_text
from remote_site.session.stop_file import StopFile
from tests.waiting import wait_until


@pytest.fixture
def status(tmp_path: Path) -> Path:
    return tmp_path / "remote.json"


def latched_later(status: Path) -> Fault | None:
    """Return the stop that the next process of the site finds."""
    with StopFile(status) as file:
        return file.latched()


def keep(status: Path, *stops: FaultCode | None) -> str:
    """Keep one stop after the other; return the problem."""
    with StopFile(status) as file:
        for stop in stops:
            file.keep(stop)
    return file.problem


@pytest.mark.parametrize("stop", [FaultCode.OPERATOR_STOP, FaultCode.REMOTE_STOP, FaultCode.PATIENT_STOP])
def test_a_stop_is_found_by_the_next_process_until_it_is_cleared(stop: FaultCode, status: Path) -> None:
    assert latched_later(status) is None
    assert keep(status, None, stop, stop) == ""
    file = status.with_name("remote.stop")
    assert file.read_text() == f"{stop}\n"
    assert file.stat().st_mode & 0o777 == 0o600
    assert latched_later(status) == latched_later(status) == Fault(stop)
    with StopFile(status) as kept:
        kept.latched()
        kept.keep(None)
    assert [*status.parent.iterdir()] == []
    assert latched_later(status) is None


def test_a_later_stop_replaces_the_earlier_one(status: Path) -> None:
    keep(status, FaultCode.OPERATOR_STOP, FaultCode.PATIENT_STOP, FaultCode.REMOTE_STOP)
    assert latched_later(status) == Fault(FaultCode.REMOTE_STOP)


@pytest.mark.parametrize("content", [b"", b"patient", b"\xff\x00\n", b"plate-too-hot\n", bytes(100)])
def test_a_damaged_file_is_a_stop_that_names_it(content: bytes, status: Path) -> None:
    file = status.with_name("remote.stop")
    file.write_bytes(content)
    found = latched_later(status)
    assert found is not None
    assert found.code is FaultCode.UNKNOWN
    assert fault_text(found) == f"unknown fault in {file}"


def test_a_link_and_a_folder_in_its_place_are_stops_and_nothing_is_written_through_them(status: Path) -> None:
    file, victim = status.with_name("remote.stop"), status.with_name("victim")
    victim.write_text("kept")
    file.symlink_to(victim)
    assert "would keep the latched stop without its cause" in keep(status, FaultCode.PATIENT_STOP)
    assert victim.read_text() == "kept"
    file.unlink()
    file.mkdir()
    found = latched_later(status)
    assert found is not None
    assert found.code is FaultCode.UNKNOWN
    assert "would latch the cleared stop again" in keep(status, FaultCode.PATIENT_STOP, None)


def test_on_a_full_disk_the_stop_survives_without_its_cause(status: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def full(number: int, content: object) -> int:
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))

    with StopFile(status) as file:
        monkeypatch.setattr("remote_site.session.kept_text.os.write", full)
        file.keep(FaultCode.PATIENT_STOP)
    assert "keep the latched stop without its cause" in file.problem
    assert "No space left" in file.problem
    found = latched_later(status)
    assert found is not None
    assert found.code is FaultCode.UNKNOWN


def test_where_nothing_can_be_kept_the_site_says_so_and_runs(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    missing = tmp_path / "missing" / "remote.json"
    for status, why in ((None, "no status file is configured"), (missing, "cannot be written")):
        caplog.clear()
        with StopFile(status) as file:
            assert file.latched() is None
            assert f"would clear a latched stop: {'' if status is None else tmp_path}" in file.problem
            assert why in caplog.text
            file.keep(FaultCode.PATIENT_STOP)
        assert "would clear a latched stop" in file.problem


@pytest.mark.parametrize("cleared", [False, True])
def test_what_could_not_be_written_is_written_once_the_disk_takes_it_again(
    cleared: bool, status: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr("remote_site.session.kept_text.AGAIN_S", 0.02)
    file = status.with_name("remote.stop")
    keep(status, FaultCode.PATIENT_STOP if cleared else None)
    with StopFile(status) as kept:
        kept.latched()
        with monkeypatch.context() as disk:
            for name in ("open", "unlink"):
                disk.setattr(
                    f"remote_site.session.kept_text.os.{name}", Mock(side_effect=OSError(errno.EMFILE, "full"))
                )
            kept.keep(None if cleared else FaultCode.PATIENT_STOP)
            wait_until(lambda: bool(kept.problem))
            time.sleep(0.1)
        wait_until(lambda: file.exists() is not cleared)
        wait_until(lambda: not kept.problem)
    assert len([line for line in caplog.messages if "would" in line]) == 1
    assert (latched_later(status) is None) is cleared
