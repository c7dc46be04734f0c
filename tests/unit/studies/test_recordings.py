"""Studies of recordings say what they look for, and where."""

from pathlib import Path

import pytest

from studies.registry import study
from studies.running import Unavailable


@pytest.mark.parametrize(
    ("name", "folder"),
    [
        ("recorded-strokes", "groove_boards"),
        ("recorded-touches", "thermal_contact"),
        ("palpation", "palpation"),
        ("texture-world", "textures"),
    ],
)
def test_without_recordings_a_study_names_their_folder(
    name: str, folder: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def run() -> None:
        study(name).run(quick=True, seed=0, progress=lambda _: None)

    monkeypatch.setenv("TELETACTION_DATA", str(tmp_path))
    with pytest.raises(Unavailable, match=str(tmp_path / folder)):
        run()
    monkeypatch.delenv("TELETACTION_DATA")
    with pytest.raises(Unavailable, match=f"TELETACTION_DATA .* holds {folder}"):
        run()
