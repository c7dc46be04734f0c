"""Files of the project are deleted and noted; every other file, every link and what lies behind it is kept."""

import io
import json
import os
import shutil
import time
from pathlib import Path

import msgpack
import pytest

from common.recording.recorder import Recorder
from teletaction.privacy.forget import FORGOTTEN
from teletaction.privacy.project_files import kind_of
from tests.commands import Outcome, command, one_line
from tests.unit.teletaction.recorded_examination import record, record_findings

pytestmark = pytest.mark.long


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder as an examination leaves it, with exports in a folder below."""
    folder = tmp_path_factory.mktemp("made")
    record(folder / "operator.mcap")
    record_findings(folder / "console.mcap", [{}])
    (folder / "remote.mcap").write_bytes((folder / "operator.mcap").read_bytes()[:3000])
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("teletaction.report.report_parts.DPI", 20)
        assert command("report", folder / "operator.mcap", "--out", folder / "report.html").code == 0
    for to in ("csv", "foxglove", "fhir"):
        done = command("export", folder / "operator.mcap", "--to", to, "--out", folder / "exports" / to)
        assert done.code == 0, done.err
    (folder / "summary.json").write_text(json.dumps({"duration_s": 4.0, "contacts": []}))
    (folder / "operator.json").write_text(json.dumps({"process": "operator", "rss_mib": 60.0}))
    (folder / "console.log").write_text("1.0 console INFO operator_site.console: OR-1: begin, P-0417\n")
    return folder


FOREIGN = {
    "notes.txt": b"mine",
    "other.mcap": b"\x89MCAP0\r\n\x01" + (20).to_bytes(8, "little") + bytes(4) + b"\x05\0\0\0other" + bytes(7),
    "empty.mcap": b"",
    "summary.json": b'{"title": "of another program"}',
    "report.html": b"<!doctype html><title>Examination P-0417</title>",
    "report.pdf": b"%PDF-1.4\n% other\n",
    "remote-touch.csv": b"time,value\n1,2\n",
    "operator.json": b"{}",
    "console.log": b"of another program",
    "site.key_secret": b"secret",
    FORGOTTEN: b"",
}


@pytest.fixture
def folder(made: Path, tmp_path: Path) -> Path:
    return Path(shutil.copytree(made, tmp_path / "examination"))


def files(folder: Path) -> set[str]:
    return {str(path.relative_to(folder)) for path in folder.rglob("*") if not path.is_dir() or path.is_symlink()}


def forget(*words: object) -> Outcome:
    return command("forget", *words)


def test_everything_of_an_examination_is_deleted_and_noted(folder: Path) -> None:
    sizes = {name: (folder / name).stat().st_size for name in files(folder)}
    assert {"operator.mcap", "report.html", "exports/csv/operator-touch.csv", "exports/foxglove/layout.json"} <= set(
        sizes
    )
    done = forget(folder, "--yes")
    assert (done.code, done.out) == (0, "")
    assert files(folder) == {FORGOTTEN}
    (line,) = (folder / FORGOTTEN).read_text().splitlines()
    noted = json.loads(line)
    assert {each["name"]: each["bytes"] for each in noted["files"]} == sizes
    assert noted["why"] == "requested"
    assert noted["time"].endswith("+00:00")
    assert "P-0417" not in line
    assert forget(folder, "--yes").err == "nothing to delete\n"
    assert len((folder / FORGOTTEN).read_text().splitlines()) == 1


def test_what_a_killed_command_has_left_is_deleted(folder: Path) -> None:
    for name in ("exports/csv/operator-touch.csv", "exports/foxglove/session.mcap", "report.html", "operator.json"):
        for end in (".0123abcd.part", ".part"):
            shutil.copy(folder / name, folder / (name + end))
    assert forget(folder, "--yes").code == 0
    assert files(folder) == {FORGOTTEN}


def test_foreign_files_are_named_and_kept(tmp_path: Path) -> None:
    for name, content in FOREIGN.items():
        (tmp_path / name).write_bytes(content)
    done = forget(tmp_path, "--yes")
    assert files(tmp_path) == set(FOREIGN)
    for name in FOREIGN.keys() - {FORGOTTEN}:
        assert f"keep   {tmp_path / name} (forget deletes no such file)" in done.err
    assert done.err.endswith("nothing to delete\n")


def test_a_dry_run_deletes_nothing(folder: Path) -> None:
    before = files(folder)
    done = forget(folder, "--dry-run", "--yes")
    assert files(folder) == before
    assert f"delete {folder / 'report.html'} (report, " in done.err
    assert done.err.endswith(f"{len(before)} files would be deleted\n")


def test_without_a_terminal_or_yes_nothing_is_deleted(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before = files(folder)
    monkeypatch.setattr("sys.stdin", io.StringIO("y\n"))
    done = forget(folder)
    assert done.code == 2
    assert done.err.splitlines()[-1].startswith("teletaction: forget: no terminal to ask at; give --yes")
    assert files(folder) == before


@pytest.mark.parametrize("answer", ["y", "n", ""])
def test_on_a_terminal_it_asks(folder: Path, answer: str, monkeypatch: pytest.MonkeyPatch) -> None:
    class Terminal(io.StringIO):
        def isatty(self) -> bool:
            return True

    before = files(folder)
    monkeypatch.setattr("sys.stdin", Terminal(f"{answer}\n"))
    done = forget(folder)
    assert "They cannot be brought back." in done.err
    assert files(folder) == ({FORGOTTEN} if answer == "y" else before)
    assert done.code == (0 if answer == "y" else 130)


def test_links_are_kept_and_not_followed(folder: Path, tmp_path: Path) -> None:
    outside = tmp_path / "outside"
    outside.mkdir()
    record_findings(outside / "console.mcap", [{}])
    (folder / "link.mcap").symlink_to(outside / "console.mcap")
    (folder / "linked").symlink_to(outside)
    done = forget(folder, "--yes")
    assert (outside / "console.mcap").is_file()
    assert files(folder) == {FORGOTTEN, "link.mcap", "linked"}
    assert f"keep   {folder / 'linked'} (a link)" in done.err
    assert one_line(forget(folder / "linked", "--yes"), 2).endswith(
        "linked: is a symbolic link; name the folder or file itself"
    )
    assert (outside / "console.mcap").is_file()


def test_a_linked_note_is_refused_before_anything_is_deleted(folder: Path, tmp_path: Path) -> None:
    (folder / FORGOTTEN).symlink_to(tmp_path / "elsewhere")
    before = files(folder)
    assert forget(folder, "--yes").code == 2
    assert files(folder) == before
    assert not (tmp_path / "elsewhere").exists()


def test_only_files_older_than_the_limit_are_deleted(folder: Path) -> None:
    old_s = time.time() - 31 * 86_400
    for name in ("console.mcap", "report.html"):
        os.utime(folder / name, (old_s, old_s))
    before = files(folder)
    done = forget(folder, "--older-than-days", 30, "--yes")
    assert before - files(folder) == {"console.mcap", "report.html"}
    assert f"keep   {folder / 'operator.mcap'} (changed within 30 days)" in done.err
    assert json.loads((folder / FORGOTTEN).read_text())["why"] == "older than 30 days"


def test_single_files_are_deleted_once_and_noted_in_their_folder(folder: Path) -> None:
    done = forget(folder / "console.mcap", folder / "console.mcap", folder / "exports" / "csv", "--yes")
    assert done.code == 0
    assert [each["name"] for each in json.loads((folder / FORGOTTEN).read_text())["files"]] == ["console.mcap"]
    assert files(folder / "exports" / "csv") == {FORGOTTEN}
    assert (folder / "operator.mcap").is_file()


def test_what_was_deleted_before_a_failure_is_noted(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    unlink = Path.unlink

    def refuse(path: Path, missing_ok: bool = False) -> None:
        if path.name == "report.html":
            raise PermissionError(1, "Operation not permitted", str(path))
        unlink(path, missing_ok)

    monkeypatch.setattr(Path, "unlink", refuse)
    done = forget(folder, "--yes")
    assert done.code == 2
    assert "report.html" in done.err.splitlines()[-1]
    noted = {each["name"] for each in json.loads((folder / FORGOTTEN).read_text())["files"]}
    assert "operator.mcap" in noted
    assert not noted & files(folder)


@pytest.mark.parametrize("words", [["absent"], ["folder", "--older-than-days", "-1"], []])
def test_bad_input_is_one_clear_line(words: list[str], tmp_path: Path) -> None:
    (tmp_path / "folder").mkdir()
    words = [str(tmp_path / word) if not word.startswith("-") else word for word in words]
    assert one_line(forget(*words), 2)


def test_encrypted_files_and_parts_are_recognised(tmp_path: Path) -> None:
    (tmp_path / "part").write_bytes(b"\x89TACENC\n" + bytes(200))
    assert kind_of(tmp_path / "part") == "encrypted file"
    Recorder(tmp_path / "empty.mcap", {}, {}).close()
    assert kind_of(tmp_path / "empty.mcap") == "recording"
    os.mkfifo(tmp_path / "pipe")
    assert kind_of(tmp_path / "pipe") is None
    assert kind_of(tmp_path) is None
    (tmp_path / "r.pdf").write_bytes(b"%PDF-1.4\n%%EOF\n% teletaction\n")
    assert kind_of(tmp_path / "r.pdf") == "report"
    (tmp_path / "rendering.csv").write_bytes(b"time_s,index_force_n,index_motor_rpm,fault\n")
    assert kind_of(tmp_path / "rendering.csv") == "replay"
    (tmp_path / "payload").write_bytes(msgpack.packb({"a": 1}))
    assert kind_of(tmp_path / "payload") is None
