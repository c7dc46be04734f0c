"""Studies of recordings say what they look for, and where."""

import re
from pathlib import Path

import pytest

from studies.registry import study
from studies.running import Unavailable

MOTION = "time_s,leader_rad,follower_rad,hand_torque_nm,environment_torque_nm\n"


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


@pytest.mark.parametrize(
    ("name", "file", "text", "words"),
    [
        ("deadband", "bilateral_1dof/hand.csv", MOTION, "no line of data"),
        (
            "deadband",
            "bilateral_1dof/hand.csv",
            MOTION + "0.0,0.1,0.1,-,0.0\n0.1,x,0.1,-,0.0\n",
            "line 3: .* leader_rad",
        ),
        (
            "teleoperation-stability",
            "bilateral_1dof/foam.csv",
            "time_s,leader_rad\n0.0,0.1\n",
            "hand_torque_nm is missing",
        ),
        ("teleoperation-stability", "network_rtt/link.csv", "send_time_s,rtt_ms\n0.0,20\n0.1,\n", "line 3: .* rtt_ms"),
        (
            "teleoperation-stability",
            "bilateral_1dof/hand.csv",
            MOTION + "0.0,0.1,0.1,0.0,0.0\n",
            "the name contains none",
        ),
    ],
)
def test_a_recording_that_cannot_be_read_is_named_with_its_line(
    name: str, file: str, text: str, words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("TELETACTION_DATA", str(tmp_path))
    path = tmp_path / file
    path.parent.mkdir()
    path.write_text(text)
    with pytest.raises(ValueError, match=f"{re.escape(str(path))}: .*{words}"):
        study(name).run(quick=False, seed=0, progress=lambda _: None)
