"""After the end of a session, each recording is called complete or incomplete, with the reason."""

import json
from pathlib import Path

from common.recording.recorder import Recorder
from teletaction.session.saved import incomplete_recordings, saved_words


def test_whole_recordings_are_complete(tmp_path: Path) -> None:
    for name in ("remote", "operator"):
        Recorder(tmp_path / f"{name}.mcap", {"a": {}}, {}).close()
    assert incomplete_recordings(tmp_path) == []
    assert saved_words(tmp_path, 12.4, []) == f"saved 12 s of exploration in {tmp_path}: 2 recordings, complete"


def test_a_cut_recording_and_lost_messages_are_named(tmp_path: Path) -> None:
    for name in ("remote", "operator"):
        Recorder(tmp_path / f"{name}.mcap", {"a": {}}, {}).close()
    whole = (tmp_path / "remote.mcap").read_bytes()
    (tmp_path / "remote.mcap").write_bytes(whole[:-20])
    (tmp_path / "operator.json").write_text(json.dumps({"time_ns": 1, "recording_lost": 7}))
    incomplete = incomplete_recordings(tmp_path)
    assert incomplete == [
        f"remote: cut off, `teletaction recover {tmp_path / 'remote.mcap'}` reads the rest",
        "operator: recording incomplete: the disk was slower than the data, 7 messages lost",
    ]
    assert "2 recordings, not complete: remote: cut off" in saved_words(tmp_path, 12.4, incomplete)
