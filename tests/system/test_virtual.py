"""The command `virtual` as a process, on the simulated devices of another: the hand feels the scene."""

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from common.faults.texts import said_fault
from common.fingers import FINGERS
from common.limits import MOTOR_FLOOR_RPM
from robustness.fault_session import read_figures
from teletaction.session.demo_files import DemoOptions, prepare
from teletaction.session.processes import SessionProcesses
from tests.commands import command
from tests.system.truth import written
from tests.waiting import wait_until

pytestmark = [pytest.mark.session, pytest.mark.timeout(400)]

SCENE = "paper_textures"
INDEX = FINGERS.index("index")
WORK_S = 8.0
PATIENCE_S = 40.0


def explore(folder: Path) -> Path:
    """A session of WORK_S that has a note, an emergency stop and a clearing; returns its folder."""
    configurations = prepare(DemoOptions(fingers=1, scene=SCENE), folder)
    config = configurations["operator"]
    processes = SessionProcesses(folder)

    def until(process: str, field: str, reached: Callable[[Any], bool]) -> None:
        def there() -> bool:
            ended = {name: processes.last_words(name) for name in processes.ended()}
            assert not ended, ended
            return reached(read_figures(folder, process).get(field))

        wait_until(there, lambda: f"{process}: {field} is {read_figures(folder, process).get(field)!r}", PATIENCE_S)

    processes.start("sim-operator", configurations["sim-operator"])
    processes.start("virtual", config, "--scene", SCENE, "--seed", "3")
    try:
        until("sim-operator", "script_s", lambda script_s: script_s is not None and script_s > WORK_S)
        assert command("session", "note", "a rough spot", "--config", config).said == (0, "", "")
        stopped = command("session", "estop", "--config", config)
        assert stopped.code == 0, stopped
        assert stopped.out.startswith("stopped, confirmed by every device after")
        until("operator", "state", lambda state: state == "fault")
        assert command("session", "clear", "--config", config).code == 0
        assert json.loads(command("session", "status", "--config", config).out)["state"] == "connected"
        assert command("session", "engage", "--config", config).code == 0
        until("operator", "state", lambda state: state == "engaged")
    finally:
        killed = processes.end()
    assert killed == []
    return folder


@pytest.fixture(scope="module")
def session(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return explore(tmp_path_factory.mktemp("virtual"))


def test_the_hand_feels_force_vibration_and_heat(session: Path) -> None:
    truth = [entry for _, entry in written(session / "sim-operator.mcap", "truth_fingertips")]
    strokes = [entry for entry in truth if entry["act"] == "stroke" and entry["object"] == "sandpaper"]
    assert max(entry["force_n"][INDEX] for entry in strokes) > 0.5
    assert max(entry["motor_rpm"][INDEX] for entry in strokes) > MOTOR_FLOOR_RPM
    plate_c = [entry["plate_c"][INDEX] for entry in truth]
    assert min(plate_c) < plate_c[0] - 1.0


def test_its_recording_is_replayed_to_the_last_bit(session: Path, tmp_path: Path) -> None:
    outcome = command("replay", session / "operator.mcap", "--out", tmp_path)
    assert outcome.code == 0, outcome
    operator = json.loads((tmp_path / "replay.json").read_text("utf-8"))["operator"]["operator"]
    assert operator["rendered_rows"] == operator["identical"] > 1000
    assert operator["missing_touch_packets"] == 0


def test_the_recording_contains_the_events(session: Path) -> None:
    happened = [
        (what, text or said_fault(fault))
        for _, (what, _, text, fault) in written(session / "operator.mcap", "operator/session")
    ]
    assert happened[0] == ("connected", f"scene {SCENE}, seed 3")
    assert ("note", "a rough spot") in happened
    assert ("fault", "emergency stop by the operator") in happened
    assert [what for what, _ in happened].count("engaged") == 2
