"""The table of safe states against the gates and the emulated devices that bring them about, in virtual time."""

import math
from collections.abc import Callable
from itertools import pairwise
from typing import Any

import pytest

from common.buses.can_frames import FrameSender
from common.buses.serial_messages import HeaterCommand, MessageId, TactTipCommand, encode_frame
from common.faults.fault import Fault, FaultCode
from common.fingers import FINGERS
from common.limits import COMFORT
from common.timing.safe_states import SAFE_STATES, TICK_S, SafeState
from operator_site.safety.gated_output import Outputs
from operator_site.safety.operator_gate import OperatorGate
from operator_site.safety.sampled_wall import SampledWall
from remote_site.safety.patient_gate import PatientGate
from sim_sensors.devices.exoskeleton import Exoskeleton
from sim_sensors.devices.tacttip import TactTip
from sim_sensors.devices.telemanipulator import Telemanipulator
from sim_sensors.devices.thermal_sensor import ThermalSensor

FIVE = len(FINGERS)
NOW_S = 100.0
STEP_S = 0.0005
ROUNDING_S = 1e-6


def row(actuator: str) -> SafeState:
    return next(state for state in SAFE_STATES if state.actuator == actuator)


def operator_outputs(tick_s: float, age: Callable[[float], float], fault_s: float) -> list[tuple[float, Any]]:
    """Half a second of the operator's gate in full work, with an input age over time and a fault at a time."""
    gate = OperatorGate(COMFORT, SampledWall(1e9, tick_s))
    found = []
    t_s = -1.0
    while t_s < 0.5:
        if t_s >= fault_s - 1e-9:
            gate.trip(Fault(FaultCode.TIME_NOT_FINITE))
        output = gate.step(
            NOW_S + t_s,
            True,
            age(t_s),
            Outputs([10.0] * FIVE, [9000.0] * FIVE, [34.0] * FIVE, [0.1] * FIVE, [0] * FIVE),
            plate_measured_c=[33.0 + 0.05 * math.sin(10.0 * t_s)] * FIVE,
            measurement_age_s=[0.0] * FIVE,
            z_m=[0.0] * FIVE,
            height_age_s=0.0,
        )
        found.append((t_s, output))
        t_s += tick_s
    return found


@pytest.mark.parametrize("tick_s", [0.001, 0.002, TICK_S])
@pytest.mark.parametrize(
    ("actuator", "field"),
    [("finger force", "force_n"), ("vibration motor", "motor_rpm"), ("Peltier element", "peltier_drive")],
)
@pytest.mark.parametrize("cause", ["link_silent", "fault"])
def test_the_operators_gate_meets_the_times_of_the_table(tick_s: float, actuator: str, field: str, cause: str) -> None:
    def age(t_s: float) -> float:
        return max(0.0, t_s) if cause == "link_silent" else 0.0

    outputs = operator_outputs(tick_s, age, fault_s=0.0 if cause == "fault" else math.inf)
    within_s = getattr(row(actuator), cause).within_s
    before = [getattr(output, field) for t_s, output in outputs if t_s < -1e-9]
    assert min(before[-1]) > 0.0, "in full work before"
    after = [getattr(output, field) for t_s, output in outputs if t_s > within_s - ROUNDING_S]
    assert after
    assert all(value == [0.0] * FIVE for value in after)


@pytest.mark.parametrize("tick_s", [0.001, 0.002, TICK_S])
@pytest.mark.parametrize("cause", ["link_silent", "fault"])
def test_the_patients_gate_meets_the_times_of_the_table(tick_s: float, cause: str) -> None:
    gate = PatientGate()
    x_m = z_m = 0.0
    still_m: list[tuple[float, float, float]] = []
    heights: list[tuple[float, list[float]]] = []
    t_s = -1.0
    while t_s < 0.5:
        if cause == "fault" and t_s >= -1e-9:
            gate.trip(Fault(FaultCode.TIME_NOT_FINITE))
        command = gate.step(
            NOW_S + t_s,
            True,
            max(0.0, t_s) if cause == "link_silent" else 0.0,
            wanted_x_m=x_m + 1.0,
            wanted_y_m=0.0,
            wanted_z_m=[-0.005] * FIVE,
            measured_x_m=x_m,
            measured_y_m=0.0,
            measured_z_m=[z_m] * FIVE,
            force_n=[0.0] * FIVE,
            force_age_s=0.0,
            heater_drive=[0.3] * FIVE,
            sensor_c=[33.0 + 0.5 * math.sin(3.0 * t_s)] * FIVE,
            ambient_c=[23.0] * FIVE,
            sensor_age_s=[0.0] * FIVE,
            in_contact=[False] * FIVE,
        )
        x_m, z_m = command.x_m, command.z_m[0]
        still_m.append((t_s, command.x_m, command.z_m[0]))
        heights.append((t_s, command.heater_drive))
        t_s += tick_s
    heater_s = getattr(row("sensor heater"), cause).within_s
    assert min(next(drive for t_s, drive in reversed(heights) if t_s < -1e-9)) > 0.0, "in full work before"
    assert all(drive == [0.0] * FIVE for t_s, drive in heights if t_s > heater_s - ROUNDING_S)
    for actuator, column in (("hand along the bench", 1), ("finger heights", 2)):
        within_s = getattr(row(actuator), cause).within_s
        after = [entry[column] for entry in still_m if entry[0] > within_s - ROUNDING_S]
        assert len(after) > 10
        if column == 1:
            assert max(after) - min(after) < 1e-9
        else:
            assert all(later >= earlier for earlier, later in pairwise(after)), "never lower"


def when_off(is_off: Callable[[float], bool]) -> float:
    """First time after a last command at 0 from which a device's output stays off, s."""
    last_on_s = 0.0
    for step in range(1, round(0.5 / STEP_S)):
        if not is_off(step * STEP_S):
            last_on_s = step * STEP_S
    return last_on_s + STEP_S


def test_an_exoskeleton_without_commands_releases_within_its_time() -> None:
    device = Exoskeleton()
    command = FrameSender("FingerForces").encode({"enabled": 1.0, **dict.fromkeys(FINGERS, 10.0)})
    device.feed(command.arbitration_id, bytes(command.data), NOW_S)
    assert min(device.force_n(NOW_S + STEP_S)) == 10.0
    off_s = when_off(lambda t_s: not device.force_n(NOW_S + t_s).any())
    assert 0.1 < off_s <= row("finger force").device_alone.within_s + STEP_S


@pytest.mark.parametrize(
    ("actuator", "drive"), [("vibration motor", "motor_mv"), ("Peltier element", "drive_permille")]
)
def test_a_module_without_commands_switches_off_within_its_time(actuator: str, drive: str) -> None:
    module = TactTip(0, NOW_S)
    module.measure(1700, 2047)
    module.feed(encode_frame(MessageId.TACTTIP_COMMAND, 0, TactTipCommand(1410, -500).encode()), NOW_S)
    assert getattr(module, drive) != 0

    def is_off(t_s: float) -> bool:
        module.take_output(NOW_S + t_s)
        return bool(getattr(module, drive) == 0)

    assert 0.05 < when_off(is_off) <= row(actuator).site_dead.within_s + STEP_S


def test_a_heater_without_commands_switches_off_within_its_time() -> None:
    sensor = ThermalSensor(0, NOW_S)
    sensor.measure(2000, 1600)
    sensor.feed(encode_frame(MessageId.HEATER_COMMAND, 0, HeaterCommand(500).encode()), NOW_S)
    assert sensor.drive != 0

    def is_off(t_s: float) -> bool:
        sensor.take_output(NOW_S + t_s)
        return bool(sensor.drive == 0)

    assert 0.05 < when_off(is_off) <= row("sensor heater").site_dead.within_s + STEP_S


def test_a_telemanipulator_without_commands_stands_still_within_its_time() -> None:
    device = Telemanipulator()
    hand = FrameSender("HandSetpoint").encode({"x": 300.0, "y": 0.0})
    heights = FrameSender("HeightSetpoint").encode({"released": 0.0, **dict.fromkeys(FINGERS, -5.0)})
    for frame in (hand, heights):
        device.feed(frame.arbitration_id, bytes(frame.data), NOW_S)
    measured_m = 0.0
    targets = []
    for step in range(1, 400):
        t_s = step * STEP_S
        measured_m = min(0.3, measured_m + 0.0001)  # it is on its way
        device.measure(measured_m, 0.0, [-measured_m / 100.0] * FIVE, [0.0] * FIVE)  # type: ignore[arg-type]
        targets.append((t_s, device.setpoint_m(NOW_S + t_s)))
    assert targets[0][1][0] == pytest.approx(0.3)
    for actuator in ("hand along the bench", "finger heights"):
        within_s = row(actuator).site_dead.within_s
        stopped = [target for t_s, target in targets if t_s > within_s + STEP_S]
        assert len({(target[0], float(target[2][0])) for target in stopped}) == 1
        assert stopped[0][0] < 0.3, "it stands where it was, not at its set-point"


def test_every_actuator_has_a_way_to_safety_for_every_cause() -> None:
    assert {state.site for state in SAFE_STATES} == {"operator", "remote"}
    for state in SAFE_STATES:
        for way in (state.link_silent, state.site_dead, state.device_alone, state.fault):
            assert 0.0 < way.within_s <= 0.2
            assert way.by
