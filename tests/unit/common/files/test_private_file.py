"""Status files and recordings concern a patient: only their owner reads them, and no link redirects them."""

import errno
import json
import logging
import os
import resource
import stat
from collections.abc import Iterator
from pathlib import Path
from typing import IO

import pytest

from common.files.private_file import create_private, creating, replacing, write_private
from common.recording.recorder import Recorder
from common.runtime.status_file import StatusFile


def mode(path: Path) -> int:
    return stat.S_IMODE(path.lstat().st_mode)


@pytest.fixture
def open_umask() -> Iterator[None]:
    before = os.umask(0)
    yield
    os.umask(before)


@pytest.fixture
def victim(tmp_path: Path) -> Path:
    path = tmp_path / "victim"
    path.write_text("precious", "utf-8")
    return path


@pytest.mark.usefixtures("open_umask")
def test_status_files_and_recordings_are_readable_by_their_owner_only_and_leave_nothing_beside(tmp_path: Path) -> None:
    path = tmp_path / "s.json"
    (tmp_path / "s.json.part").write_text("left by a process that was killed", "utf-8")
    status = StatusFile(path, "s")
    for number in range(2):
        status.write(float(number), {"number": number})
        assert mode(path) == 0o600
    assert json.loads(path.read_text("utf-8"))["number"] == 1
    assert [file.name for file in tmp_path.iterdir()] == ["s.json"]
    Recorder(tmp_path / "s.mcap", {}, {}).close()
    assert mode(tmp_path / "s.mcap") == 0o600


def test_a_folder_in_place_of_a_recording_is_called_one(tmp_path: Path) -> None:
    with pytest.raises(IsADirectoryError, match="Is a directory"):
        Recorder(tmp_path, {}, {})


@pytest.mark.parametrize("dangling", [False, True])
def test_a_recording_is_not_written_through_a_link(tmp_path: Path, victim: Path, dangling: bool) -> None:
    link = tmp_path / "s.mcap"
    link.symlink_to(tmp_path / "absent" if dangling else victim)
    with pytest.raises(OSError, match=r"symbolic link, refused.*s\.mcap"):
        Recorder(link, {}, {})
    assert link.is_symlink(), "it is not set aside either"
    assert victim.read_text("utf-8") == "precious"
    assert not (tmp_path / "absent").exists()


def test_a_status_file_is_not_written_through_a_link_and_a_later_link_is_reported_once(
    tmp_path: Path, victim: Path, caplog: pytest.LogCaptureFixture
) -> None:
    path = tmp_path / "s.json"
    status = StatusFile(path, "s")
    path.symlink_to(victim)
    with pytest.raises(OSError, match=r"symbolic link, refused.*s\.json"):
        StatusFile(path, "s")
    with caplog.at_level(logging.WARNING):
        for second in range(3):
            status.write(float(second), {})
    assert victim.read_text("utf-8") == "precious"
    (line,) = caplog.messages
    assert line == f"status file: [Errno 40] is a symbolic link, refused: '{path}'"
    path.unlink()
    status.write(4.0, {})
    assert json.loads(path.read_text("utf-8"))["process"] == "s"


@pytest.mark.parametrize("reason", [errno.ENOSPC, errno.EDQUOT])
def test_a_status_file_on_a_full_disk_is_overwritten(
    reason: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """Recording and status share a disk: the status says why the recording stopped."""

    def full(path: Path) -> IO[bytes]:
        path.touch()
        raise OSError(reason, os.strerror(reason), str(path))

    path = tmp_path / "s.json"
    status = StatusFile(path, "s")
    status.write(0.0, {"long": 300 * "x"})
    monkeypatch.setattr("common.runtime.status_file.create_private", full)
    status.write(1.0, {"disk_full": True})
    written = path.read_text("utf-8")
    assert json.loads(written)["disk_full"]
    assert (mode(path), list(tmp_path.iterdir()), caplog.messages) == (0o600, [path], [])
    status.write(2.0, {"long": 50_000 * "x"})
    assert path.read_text("utf-8") == written, "no room for it"
    assert os.strerror(reason) in caplog.text


def test_a_link_in_place_of_the_temporary_file_is_not_followed(tmp_path: Path, victim: Path) -> None:
    path = tmp_path / "s.json"
    (tmp_path / "s.json.part").symlink_to(victim)
    StatusFile(path, "s").write(0.0, {})
    assert victim.read_text("utf-8") == "precious"
    assert not path.is_symlink()
    assert json.loads(path.read_text("utf-8"))["process"] == "s"


def test_a_file_that_exists_is_kept_and_one_that_is_to_be_replaced_is_a_new_one(victim: Path, tmp_path: Path) -> None:
    """Who has the old one open keeps its content and its mode."""
    with pytest.raises(FileExistsError):
        create_private(victim)
    assert victim.read_text("utf-8") == "precious"
    (tmp_path / "other").hardlink_to(victim)
    with create_private(victim, replace=True) as file:
        file.write(b"new")
    assert (mode(victim), victim.read_text("utf-8")) == (0o600, "new")
    assert (tmp_path / "other").read_text("utf-8") == "precious"


def test_a_file_that_does_not_fit_on_the_disk_leaves_the_one_before_and_is_named(victim: Path) -> None:
    before = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1000, before[1]))
    try:
        with pytest.raises(OSError, match="victim") as caught:
            write_private(victim, 2000 * b"x")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, before)
    assert caught.value.errno == errno.EFBIG
    assert victim.read_text("utf-8") == "precious"
    assert list(victim.parent.iterdir()) == [victim]


def test_a_full_disk_is_named_with_the_file_although_the_write_names_none(victim: Path) -> None:
    with pytest.raises(OSError, match=r"No space left.*victim'$"), replacing(victim):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))
    with pytest.raises(OSError, match=r"Input/output error$"), replacing(victim):
        raise OSError(errno.EIO, os.strerror(errno.EIO))  # of another file, perhaps
    assert victim.read_text("utf-8") == "precious"
    assert list(victim.parent.iterdir()) == [victim]


def test_two_commands_that_write_one_file_at_once_each_leave_a_whole_one(victim: Path) -> None:
    with replacing(victim) as slow, create_private(slow, replace=True) as file:
        file.write(b"slow, ")
        write_private(victim, b"whole")
        assert victim.read_text("utf-8") == "whole"
        file.write(b"also whole")
    assert victim.read_text("utf-8") == "slow, also whole"
    assert list(victim.parent.iterdir()) == [victim]


def test_a_file_that_must_not_exist_is_absent_until_it_is_whole_and_replaces_none(tmp_path: Path) -> None:
    path = tmp_path / "new"
    with creating(path) as made, create_private(made, replace=True) as file:
        file.write(b"whole")
        assert not path.exists()
    assert path.read_text("utf-8") == "whole"
    with pytest.raises(FileExistsError, match="new"), creating(path):
        raise AssertionError("it exists")
    path.unlink()
    with pytest.raises(FileExistsError, match="new"), creating(path):
        path.write_text("first", "utf-8")
    assert path.read_text("utf-8") == "first"
    assert list(tmp_path.iterdir()) == [path]


def test_a_device_is_written_and_stays() -> None:
    write_private(Path(os.devnull), b"x")
    assert Path(os.devnull).is_char_device()


def test_what_a_killed_process_left_is_removed_an_hour_later(tmp_path: Path) -> None:
    path = tmp_path / "report.html"
    names = ["report.html.0123abcd.part", "report.html.part", "other.html.0123abcd.part", "report.html.mine.part"]
    live = tmp_path / "report.html.89abcdef.part"
    for name in names:
        (tmp_path / name).write_text("half", "utf-8")
        os.utime(tmp_path / name, (0.0, 0.0))
    live.write_text("another command is writing it", "utf-8")
    write_private(path, b"whole")
    assert {each.name for each in tmp_path.iterdir()} == {path.name, live.name, *names[2:]}
