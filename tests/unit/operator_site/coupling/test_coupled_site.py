"""Clutch and scale in a whole operator site on a scene: command, recording and replay."""

from itertools import pairwise
from pathlib import Path

import pytest

from common.config.file import to_toml
from common.link.session_state import Refused
from common.recording.reader import RecordingReader
from common.recording.recorder import Recorder
from common.wire.messages import Motion
from operator_site.coupling.coupling import DIRECT, Coupling
from operator_site.recorded_rows import Rendered
from operator_site.site_recording import SCHEMAS
from teletaction.replay.replay import replay
from tests.unit.operator_site.virtual_touch import CONFIG, INDEX, Working

PLACE_M = 0.05
"""Of an object of the scene."""


def session(path: Path) -> Working:
    """A press, a clutch with a new place of the hand, a change of scale, and strokes in it."""
    with Recorder(path, SCHEMAS, {"configuration": to_toml(CONFIG)}) as recorder:
        working = Working(recorder=recorder)
        working.press(PLACE_M)
        working.ask("clutch", open=True)
        working.go(0.3)
        working.go(0.4, x_m=-0.02, z_m=0.006)
        working.ask("scale", scale=2)
        working.go(0.1)
        working.ask("clutch", open=False)
        working.go(0.5, z_m=0.003)
        working.go(0.8, x_m=0.04, z_m=0.001)
        working.ask("disengage")
        working.go(0.2)
        working.ask("engage")
        working.go(0.5, x_m=0.0)
    assert recorder.lost == 0
    return working


def recorded(path: Path, stream: str) -> list[bytes]:
    with path.open("rb") as file:
        return [message.data for _, _, message in RecordingReader(path, file).messages([stream])]


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("coupled") / "operator.mcap"
    session(path)
    return path


@pytest.mark.long
def test_a_replay_through_clutch_and_scale_is_identical_to_the_last_bit(recording: Path, tmp_path: Path) -> None:
    result = replay(recording, tmp_path)["operator"]["operator"]
    assert result["rendered_rows"] == result["identical"] == result["ticks"]
    forces = [Rendered.unpack(row).force_n[INDEX] for row in recorded(recording, "operator/rendered")]
    assert max(forces) > 0.5


def test_each_change_is_recorded_once_and_noted(recording: Path) -> None:
    rows = [Coupling.unpack(row) for row in recorded(recording, "operator/coupling")]
    assert [(row.open, row.scale) for row in rows] == [(True, 1), (True, 2), (False, 2)]


def test_motion_packets_hold_the_command_and_never_step(recording: Path) -> None:
    places = [Motion.decode(packet).rows[INDEX] for packet in recorded(recording, "operator/motion")]
    steps_m = [max(abs(a - b) for a, b in zip(now, before, strict=True)) for before, now in pairwise(places)]
    assert max(steps_m) <= 0.06 / 0.8 * 0.002 + 1e-6, "no faster than the hand"
    held = places[600:800]
    assert len(set(held)) < len(held)


def test_a_session_without_clutch_and_scale_records_none(tmp_path: Path) -> None:
    with Recorder(tmp_path / "operator.mcap", SCHEMAS, {"configuration": to_toml(CONFIG)}) as recorder:
        working = Working(recorder=recorder)
        working.press(PLACE_M)
    assert recorded(tmp_path / "operator.mcap", "operator/coupling") == []
    assert working.site.coupling.now is DIRECT


def test_the_scale_is_refused_while_a_finger_presses() -> None:
    working = Working()
    working.press(PLACE_M)
    working.site.coupling.pressed_n = max(working.site.rendering.pushed_n)
    with pytest.raises(Refused, match="a finger presses"):
        working.ask("scale", scale=2)
    assert working.site.coupling.now is DIRECT


def test_figures_have_the_coupling() -> None:
    working = Working()
    working.go(0.1)
    working.ask("scale", scale=5)
    coupling = working.site.figures()["coupling"]
    assert isinstance(coupling, dict)
    assert (coupling["open"], coupling["scale"]) == (False, 5)
