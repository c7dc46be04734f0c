import json
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

import msgpack
import numpy as np
import pytest
from mcap.reader import make_reader

from common.buses.can_frames import FrameSender
from common.buses.serial_messages import HeaterCommand, MessageId, TactTipCommand, encode_frame
from common.config.simulation_models import SimOperatorConfig, SimPatientSwitchConfig, SimRemoteConfig
from sim_sensors.devices.exoskeleton import DRIVEN_S
from sim_sensors.operator_devices import OperatorDevices
from sim_sensors.operator_hand.hand_plan import HOVER_M
from sim_sensors.ports.select_loop import SelectLoop
from sim_sensors.ports.simulation_loop import MOST_STEPS, STEP_S, StepClock, run_world
from sim_sensors.remote_devices import RemoteDevices
from tests.ports import free_port
from tests.unit.sim_sensors.stepped import START_S, advance, forces, hear, send_hand
from tests.waiting import wait_until


def entries(path: Path) -> dict[str, list[tuple[int, dict[str, Any]]]]:
    found: dict[str, list[tuple[int, dict[str, Any]]]] = {}
    with path.open("rb") as file:
        for _, channel, message in make_reader(file).iter_messages():
            found.setdefault(channel.topic, []).append((message.log_time, msgpack.unpackb(message.data)))
    return found


@pytest.fixture
def operator(tmp_path: Path) -> Iterator[OperatorDevices]:
    config = SimOperatorConfig(
        fingers=("index",),
        tacttip={"index": "pty"},
        can_port=free_port(),
        seconds=4.0,
        record=tmp_path / "truth.mcap",
    )
    devices = OperatorDevices(config, SelectLoop(lambda: START_S))
    yield devices
    devices.close()


def drive_operator(devices: OperatorDevices, steps: range, motor_mv: int = 0) -> None:
    """Advance, with force frames each step and a command to the module every 10 ms."""
    sender = FrameSender("FingerForces")
    for step in steps:
        now_s = START_S + step * STEP_S
        hear(devices.exoskeleton, sender.encode(forces(0.0)), now_s)
        if step % 5 == 0:
            command = TactTipCommand(motor_mv, 0).encode()
            devices.modules["index"].feed(encode_frame(MessageId.TACTTIP_COMMAND, 0, command), now_s)
        devices.step(now_s)


@pytest.mark.long
def test_the_hand_works_once_its_exoskeleton_was_driven_and_for_the_seconds_asked(operator: OperatorDevices) -> None:
    advance(operator, range(1, 500))
    assert operator.hand.script_s == 0.0
    driven = 500 + round(DRIVEN_S / STEP_S)
    drive_operator(operator, range(500, driven + 2))
    assert operator.hand.script_s == pytest.approx(0.0, abs=2 * STEP_S)
    drive_operator(operator, range(driven + 2, driven + 1150))
    assert operator.hand.script_s == pytest.approx(2.296, abs=3 * STEP_S)
    assert not operator.hand.finished
    drive_operator(operator, range(driven + 1150, driven + 2150))
    assert operator.hand.finished
    assert np.all(np.abs(operator.hand.z_m - HOVER_M) < 0.5e-3)


def test_what_reached_the_finger_is_recorded_with_exact_times(operator: OperatorDevices, tmp_path: Path) -> None:
    drive_operator(operator, range(1, 100), motor_mv=1000)
    advance(operator, range(100, 250))  # nobody drives it any more
    operator.close()
    found = entries(tmp_path / "truth.mcap")
    assert len(found["truth_fingertips"]) == 49
    assert [(entry["finger"], entry["motor_mv"]) for _, entry in found["truth_motor"]] == [(1, 1000), (1, 0)]
    first_s, last_s = START_S + 5 * STEP_S, START_S + 95 * STEP_S + 0.1
    assert [time_ns * 1e-9 for time_ns, _ in found["truth_motor"]] == pytest.approx([first_s, last_s], abs=1e-7)
    rpm = [entry["motor_rpm"][1] for _, entry in found["truth_fingertips"]]
    assert max(rpm) > 5000.0
    assert rpm[-1] < 100.0


def test_the_remote_fingers_go_where_they_are_sent_and_contacts_are_recorded(tmp_path: Path) -> None:
    config = SimRemoteConfig(
        fingers=("index", "middle"),
        texture={"index": "pty", "middle": "pty"},
        thermal_sensors={"index": "pty", "middle": "pty"},
        can_port=free_port(),
        record=tmp_path / "truth.mcap",
    )
    devices = RemoteDevices(config, SelectLoop(lambda: START_S))
    plate_c = devices.world.plate_c.copy()
    heater = encode_frame(MessageId.HEATER_COMMAND, 0, HeaterCommand(500).encode())
    for step in range(1, 501, 10):
        devices.thermal["middle"].feed(heater, START_S + step * STEP_S)
        send_hand(devices, range(step, step + 10), x_m=-0.17, height_mm=6.0 if step < 250 else -2.0)
    devices.close()
    assert devices.world.plate_c[2] > plate_c[2] + 0.5
    assert devices.world.plate_c[1] < plate_c[1] + 0.2
    found = entries(tmp_path / "truth.mcap")
    assert len(found["truth_contact"]) == 100
    contacts = [(time_ns, entry) for time_ns, entry in found["truth_event"] if entry["kind"] == "contact"]
    assert {entry["finger"] for _, entry in contacts} == {1, 2}
    for time_ns, entry in contacts:
        assert entry["material"] == "aluminium"
        assert START_S + 0.5 < time_ns * 1e-9 < START_S + 0.6


def test_fingers_without_an_address_are_named_and_nothing_stays_open() -> None:
    port = free_port()
    config = SimOperatorConfig(fingers=("thumb", "index"), tacttip={"index": "pty"}, can_port=port)
    with pytest.raises(ValueError, match="tacttip: has addresses for index, fingers says thumb, index"):
        OperatorDevices(config, SelectLoop())
    free = SimOperatorConfig(fingers=("index",), tacttip={"index": "pty"}, can_port=port)
    for _ in range(2):  # the port is given back each time
        OperatorDevices(free, SelectLoop()).close()


def test_after_a_stall_the_world_catches_up_to_a_limit_and_counts_the_rest() -> None:
    clock = StepClock(10.0)
    assert clock.due(10.0041) == pytest.approx([10.002, 10.004])
    assert clock.due(10.0045) == []
    assert len(clock.due(10.034)) == 15
    times = clock.due(11.034)
    assert len(times) == MOST_STEPS
    assert times[-1] == pytest.approx(11.034)
    assert clock.lost_s == pytest.approx(1.0 - MOST_STEPS * STEP_S)


class Counting:
    """A world that only counts."""

    def __init__(self) -> None:
        self.calls: Counter[str] = Counter()

    def step(self, now_s: float) -> None:
        self.calls["step"] += 1

    def figures(self) -> dict[str, object]:
        return {"answer": 42}


class ImaginedTime(SelectLoop):
    """Sockets with a clock of their own. It advances while they wait, by 20 us too much, and when a world stalls."""

    def __init__(self) -> None:
        super().__init__(lambda: self.t_s)
        self.t_s = 10.0

    def serve(self, seconds: float) -> None:
        self.t_s += seconds + 20e-6


class Stalling(Counting):
    """A world that stands still once, for two periods and 0.7 of one, and notes how late its steps are made."""

    def __init__(self, sockets: ImaginedTime) -> None:
        super().__init__()
        self._sockets = sockets
        self.late_s: list[float] = []

    def step(self, now_s: float) -> None:
        super().step(now_s)
        self.late_s.append(self._sockets.t_s - now_s)
        if self.calls["step"] == 10:
            self._sockets.t_s += 2.7 * STEP_S


def test_after_a_stall_devices_are_on_time_again() -> None:
    sockets = ImaginedTime()
    world = Stalling(sockets)
    run_world(world, sockets, lambda: world.calls["step"] >= 50, "sim-test", None)
    on_time = [late_s < 1e-4 for late_s in world.late_s]
    assert all(on_time[:10])
    assert not all(on_time[10:13])
    assert all(on_time[13:])


def test_the_loop_never_runs_ahead_of_real_time_and_writes_its_status(tmp_path: Path) -> None:
    world, sockets = Counting(), SelectLoop()
    start_s = sockets.now()
    run_world(world, sockets, lambda: world.calls["step"] >= 50, "sim-test", tmp_path / "status.json")
    assert sockets.now() - start_s >= (world.calls["step"] - 1) * 0.002
    status = json.loads((tmp_path / "status.json").read_text("utf-8"))
    assert (status["process"], status["answer"]) == ("sim-test", 42)
    assert status["loop"]["period_ms"] == 2.0


def test_tender_places_move_with_the_patient() -> None:
    config = SimRemoteConfig(
        fingers=("index",),
        scene="tender_place",
        texture={"index": "pty"},
        thermal_sensors={"index": "pty"},
        patient_switch=SimPatientSwitchConfig(port="pty", reaction_s=0.1),
        can_port=free_port(),
    )
    pain = []
    for command in ("mend", "shift 30 0 0"):
        devices = RemoteDevices(config, SelectLoop(lambda: START_S))
        devices.faults.apply(command)
        send_hand(devices, range(1, 301), x_m=0.006, height_mm=6.0)
        send_hand(devices, range(301, 601), x_m=0.006, height_mm=-6.0)
        assert devices.world.forces_n[1] > 3.0
        assert devices.patient_switch is not None
        pain.append(devices.patient_switch.pain)
        devices.close()
    assert pain[0] > 0.0
    assert pain[1] == 0.0


@pytest.mark.parametrize("side", [RemoteDevices, OperatorDevices])
def test_a_full_disk_is_in_the_status(side: Callable[..., RemoteDevices | OperatorDevices]) -> None:
    if not Path("/dev/full").exists():
        pytest.skip("no /dev/full here")
    given: dict[str, Any] = {"fingers": ("index",), "can_port": free_port(), "record": Path("/dev/full")}
    lines = {"index": "pty"}
    config: SimRemoteConfig | SimOperatorConfig = SimOperatorConfig(**given, tacttip=lines)
    if side is RemoteDevices:
        config = SimRemoteConfig(**given, texture=lines, thermal_sensors=lines)
    with closing(side(config, SelectLoop(lambda: START_S))) as devices:
        advance(devices, range(2000))
        wait_until(lambda: devices.figures()["recording_failed"], "the status has no failed recording")


def test_broken_parts_of_two_fingers_do_not_fail_in_step() -> None:
    lines = {"index": "pty", "middle": "pty"}
    config = SimRemoteConfig(
        fingers=("index", "middle"), can_port=free_port(), texture=lines, thermal_sensors=lines, record=None
    )
    with closing(RemoteDevices(config, SelectLoop(lambda: START_S))) as devices:
        counts, jumps = [], []
        for finger in config.fingers:
            devices.piezos[finger].fault, devices.encoders[finger].fault = "loose", "glitch"
            counts.append(devices.piezos[finger].read(np.zeros(100, np.int16)).tolist())
            jumps.append([devices.encoders[finger].read(0.001) for _ in range(1000)])
    assert counts[0] != counts[1]
    assert jumps[0] != jumps[1]
