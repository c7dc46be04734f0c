from pathlib import Path

from common.files.unique_path import free_name, set_aside
from common.recording.recorder import Recorder


def test_the_newest_has_the_name_and_the_earlier_ones_are_numbered(tmp_path: Path) -> None:
    path = tmp_path / "remote.mcap"
    assert free_name(path) == path
    for content in ("first", "second", "third"):
        set_aside(path)
        path.write_text(content, "utf-8")
    found = {file.name: file.read_text("utf-8") for file in tmp_path.iterdir()}
    assert found == {"remote-1.mcap": "first", "remote-2.mcap": "second", "remote.mcap": "third"}
    set_aside(tmp_path / "operator.mcap")
    (tmp_path / "operator.mcap").mkdir()
    set_aside(tmp_path / "operator.mcap")
    assert {file.name for file in tmp_path.iterdir()} == {*found, "operator.mcap"}, "what is no file stays"


def test_a_recording_is_never_written_over(tmp_path: Path) -> None:
    path = tmp_path / "operator.mcap"
    path.write_bytes(b"minutes of an examination")
    Recorder(path, {}, {}).close()
    assert (tmp_path / "operator-1.mcap").read_bytes() == b"minutes of an examination"
    assert path.read_bytes().startswith(b"\x89MCAP")
