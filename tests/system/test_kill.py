"""When any process dies, every actuator of both sites is safe within the hold times, seen at the simulated devices."""

import os
import signal
import time
from pathlib import Path

import pytest

from common.limits import FORCE_SAFE_S, MOTOR_FLOOR_RPM, MOTOR_SAFE_S, MOTOR_STILL_S, THERMAL_SAFE_S
from robustness.fault_judge import FELT_N
from robustness.fault_session import read_figures
from robustness.stroking_scene import write_stroking_scene
from teletaction.session.demo_files import PROCESSES, DemoOptions, prepare
from teletaction.session.processes import SessionProcesses
from tests.system.truth import LATE_S, written
from tests.waiting import wait_until

pytestmark = [pytest.mark.session, pytest.mark.timeout(90)]

INDEX = 1
OBSERVED_S = 1.0


def strokes(out: Path) -> bool:
    """Whether the hand is deep in its work: in contact, with force, heat and vibration."""
    return float(read_figures(out, "sim-operator").get("script_s") or 0.0) > 3.0


@pytest.fixture(params=PROCESSES)
def killed(request: pytest.FixtureRequest, tmp_path: Path) -> tuple[str, float, Path]:
    """A session in full work in which one process was killed: its name, when, and the output folder."""
    name: str = request.param
    scene = write_stroking_scene(tmp_path, 0.1, 0.95)  # six seconds: force, vibration and heat all act
    configurations = prepare(DemoOptions(seconds=60.0, fingers=1, scene=str(scene)), tmp_path)
    processes = SessionProcesses(tmp_path)
    try:
        for process in PROCESSES:
            processes.start(process, configurations[process])
        wait_until(lambda: strokes(tmp_path), "the session did not get to work", 40.0)
        killed_s = time.monotonic()
        os.kill(processes.running[name].pid, signal.SIGKILL)
        time.sleep(OBSERVED_S)
    finally:
        processes.end()
    return name, killed_s, tmp_path


def test_actuators_are_safe_within_their_hold_times(killed: tuple[str, float, Path]) -> None:
    name, killed_s, out = killed
    if name != "sim-operator":
        entries = written(out / "sim-operator.mcap", "truth_fingertips", may_be_cut=True)
        before = [entry for t, entry in entries if killed_s - 0.1 <= t <= killed_s]
        assert max(entry["force_n"][INDEX] for entry in before) > FELT_N, "the finger must feel force before the kill"
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
        touched = written(out / "sim-remote.mcap", "truth_contact", may_be_cut=True)
        contact = [(t - killed_s, entry) for t, entry in touched if t > killed_s]
        assert max(t for t, _ in contact) > 0.6
        assert all(entry["heater"][INDEX] == 0.0 for t, entry in contact if t > THERMAL_SAFE_S + LATE_S)
        if name != "remote":
            # Motion is missing but the site lives: stop, then retreat along the normal until clear of the object.
            assert contact[-1][1]["force_n"][INDEX] == 0.0
        else:
            heights = [entry["z_m"][INDEX] for t, entry in contact if t > 0.3]
            assert max(heights) - min(heights) < 1e-4, "the telemanipulator stops by itself"
