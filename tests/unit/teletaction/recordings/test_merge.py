"""A message that cannot be read is left in a merged recording for its reader."""

from pathlib import Path

from common.recording.recorder import Recorder
from teletaction.recordings.merge import merge_recordings


def test_an_unreadable_offset_of_the_clocks_keeps_no_recording_from_being_merged(tmp_path: Path) -> None:
    with Recorder(tmp_path / "operator.mcap", {"operator/clock": {}}, {}) as recorder:
        recorder.write("operator/clock", 1, b"\x03")
    assert merge_recordings([tmp_path / "operator.mcap"], tmp_path / "session.mcap") == {"operator/clock": 1}
