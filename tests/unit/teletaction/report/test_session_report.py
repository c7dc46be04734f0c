"""A report replaces no recording that it is made of."""

from pathlib import Path

import pytest

from tests.commands import command, one_line
from tests.unit.teletaction.recorded_examination import record


@pytest.mark.parametrize("name", ["operator.mcap", "link.html"])
def test_a_recording_is_not_replaced_by_its_report(name: str, tmp_path: Path) -> None:
    recording = record(tmp_path / "operator.mcap")
    content = recording.read_bytes()
    (tmp_path / "link.html").symlink_to(recording)
    line = one_line(command("report", recording, "--out", tmp_path / name), 2)
    assert f"{name}: is a recording to report on; name another file with --out" in line
    assert recording.read_bytes() == content
