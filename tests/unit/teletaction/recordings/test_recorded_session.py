"""A recording's own tables are named by the recording."""

from pathlib import Path

import pytest

from common.recording.recorder import Recorder
from remote_site.thermal.material_table import MaterialTable
from teletaction.recordings.recorded_session import RecordedSession


def test_a_useless_table_is_named_by_its_recording(tmp_path: Path) -> None:
    path = tmp_path / "remote.mcap"
    Recorder(path, {"remote/sensed": {}}, {}, {"materials.json": b"{}"}).close()
    with path.open("rb") as file, pytest.raises(ValueError, match="the attached") as refused:
        RecordedSession(path, file).table("", "materials", MaterialTable)
    assert str(refused.value).startswith(f"{path}: the attached materials.json: not a ")
