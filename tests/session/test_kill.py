"""Whatever process dies, every actuator of both sites is safe within the hold times, seen at the simulated devices."""

import json
import os
import signal
import time
from pathlib import Path
from typing import Any

import msgpack
import pytest
from mcap.records import Channel, Message
from mcap.stream_reader import StreamReader

from common.limits import FORCE_SAFE_S, MOTOR_FLOOR_RPM, MOTOR_SAFE_S, MOTOR_STILL_S, THERMAL_SAFE_S
from teletaction.demo_files import PROCESSES, DemoOptions, prepare
from teletaction.processes import SessionProcesses

pytestmark = [pytest.mark.session, pytest.mark.timeout(90)]

INDEX = 1
SCENE = """
name = "stroking"
calibrated = ["pine"]
[[objects]]
name = "rough"
material = "cardboard"
surface = "sandpaper"
x_m = 0.0
length_m = 0.30
[[script]]
act = "move"
object = "rough"
u = 0.1
[[script]]
act = "touch"
[[script]]
act = "stroke"
to_object = "rough"
u = 0.95
speed_mm_s = 50.0
[[script]]
act = "lift"
"""
"""Six seconds of stroking: force, vibration and heat all act when the process dies."""
OBSERVED_S = 1.0
LATE_S = 0.030
"""What the machine may add to a hold time: a log entry every 10 ms, and a scheduler that others use too."""


def status(out: Path, name: str) -> dict[str, Any]:
    try:
        found: dict[str, Any] = json.loads((out / f"{name}.json").read_text("utf-8"))
    except (FileNotFoundError, ValueError):
        return {}
    return found


def wait_until_stroking(out: Path, deadline_s: float = 40.0) -> None:
    """Until the hand is deep in its work: in contact, with force, heat and vibration."""
    end_s = time.monotonic() + deadline_s
    while time.monotonic() < end_s:
        if float(status(out, "sim-operator").get("script_s") or 0.0) > 3.0:
            return
        time.sleep(0.02)
    raise AssertionError("the session did not get to work")


def truth(path: Path, stream: str) -> list[tuple[float, dict[str, Any]]]:
    """Entries of a stream, from a recording that may have been cut by a kill."""
    topics: dict[int, str] = {}
    found = []
    with path.open("rb") as file:
        try:
            for record in StreamReader(file).records:
                if isinstance(record, Channel):
                    topics[record.id] = record.topic
                elif isinstance(record, Message) and topics[record.channel_id] == stream:
                    found.append((record.log_time * 1e-9, msgpack.unpackb(record.data)))
        except EOFError:
            pass
    return found


@pytest.fixture(params=PROCESSES)
def killed(request: pytest.FixtureRequest, tmp_path: Path) -> tuple[str, float, Path]:
    """A session in full work in which one process was killed: its name, when, and the output folder."""
    name: str = request.param
    scene = tmp_path / "materials.toml"
    scene.write_text(SCENE, "utf-8")
    configurations = prepare(DemoOptions(seconds=60.0, fingers=1, scene=str(scene)), tmp_path)
    processes = SessionProcesses(tmp_path)
    try:
        for process in PROCESSES:
            processes.start(process, configurations[process])
        wait_until_stroking(tmp_path)
        killed_s = time.monotonic()
        os.kill(processes.running[name].pid, signal.SIGKILL)
        time.sleep(OBSERVED_S)
    finally:
        processes.end()
    return name, killed_s, tmp_path


def test_actuators_are_safe_within_their_hold_times(killed: tuple[str, float, Path]) -> None:
    name, killed_s, out = killed
    if name != "sim-operator":
        entries = truth(out / "sim-operator.mcap", "truth_fingertips")
        before = [entry for t, entry in entries if killed_s - 0.1 <= t <= killed_s]
        assert max(entry["force_n"][INDEX] for entry in before) > 0.2, "the finger must feel force before the kill"
        assert max(entry["motor_mv"][INDEX] for entry in before) > 0, "and vibration"
        after = {t - killed_s: entry for t, entry in entries if t > killed_s}
        assert max(after) > 0.6
        # A dead sim-remote is noticed by the remote site first, and by the operator from what that then says.
        late_s = LATE_S + (0.150 if name == "sim-remote" else 0.0)
        for since_s, entry in after.items():
            if since_s > FORCE_SAFE_S + late_s:
                assert entry["force_n"][INDEX] == 0.0, since_s
            if since_s > MOTOR_SAFE_S + late_s:
                assert entry["motor_mv"][INDEX] == 0, since_s
            if since_s > MOTOR_STILL_S + late_s:
                assert entry["motor_rpm"][INDEX] < MOTOR_FLOOR_RPM, since_s
            if since_s > THERMAL_SAFE_S + late_s and name != "sim-remote":
                assert entry["peltier"][INDEX] == 0.0, since_s
    if name != "sim-remote":
        contact = [(t - killed_s, e) for t, e in truth(out / "sim-remote.mcap", "truth_contact") if t > killed_s]
        assert max(t for t, _ in contact) > 0.6
        assert all(entry["heater"][INDEX] == 0.0 for t, entry in contact if t > THERMAL_SAFE_S + LATE_S)
        if name != "remote":
            # Motion is missing but the site lives: stop, then retreat along the normal until clear of the object.
            assert contact[-1][1]["force_n"][INDEX] == 0.0
        else:
            heights = [entry["z_m"][INDEX] for t, entry in contact if t > 0.3]
            assert max(heights) - min(heights) < 1e-4, "the telemanipulator stops by itself"
