"""The emulated devices beyond the duties of docs/protocols.md, which the tests of conformance try on them."""

import math
from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.buses.can_frames import FrameSender
from common.buses.serial_messages import (
    DeviceFlag,
    Frame,
    FrameReader,
    HeaterCommand,
    MessageId,
    TactTipCommand,
    TactTipState,
    TextureSamples,
    ThermalReading,
    encode_frame,
)
from common.buses.thermometry import ntc_c
from common.fingers import FINGERS
from common.limits import PLATE_FAULT_C, SENSOR_PLATE_C
from sim_sensors.devices.exoskeleton import DRIVEN_S, Exoskeleton
from sim_sensors.devices.serial_module import SerialModule
from sim_sensors.devices.tacttip import TactTip, ntc_counts
from sim_sensors.devices.telemanipulator import Telemanipulator
from sim_sensors.devices.texture_sensor import TextureSensor
from sim_sensors.devices.thermal_sensor import ThermalSensor
from tests.unit.sim_sensors.stepped import forces, hear, heights, reported
from tests.unit.teletaction.conformance.virtual_ends import ssr_counts


def answers(module: SerialModule, now_s: float, data: bytes = b"") -> list[Frame]:
    module.feed(data, now_s)
    return FrameReader().feed(module.take_output(now_s))


def heat(permille: int) -> bytes:
    return encode_frame(MessageId.HEATER_COMMAND, 0, HeaterCommand(permille).encode())


def drive(motor_mv: int, permille: int, *pulse: int) -> bytes:
    return encode_frame(MessageId.TACTTIP_COMMAND, 0, TactTipCommand(motor_mv, permille, *pulse).encode())


@pytest.mark.parametrize("make", [TextureSensor, ThermalSensor, TactTip])
@given(chunks=st.lists(st.binary(max_size=40), max_size=8))
def test_any_bytes_are_survived(make: Callable[[int], SerialModule], chunks: list[bytes]) -> None:
    module = make(3)
    for chunk in chunks:
        module.feed(chunk, 0.0)
    frames = answers(module, 0.001, b"\0" + encode_frame(MessageId.IDENTIFY, 0))
    assert MessageId.IDENTITY in {f.message_id for f in frames}


def test_samples_come_in_chunks_of_ten_with_the_time_of_their_first() -> None:
    sensor = TextureSensor(0)
    counts = np.arange(-2048, -2048 + 25, dtype=np.int16)
    sensor.add_samples(counts[:4])
    assert answers(sensor, 0.002) == []
    sensor.add_samples(counts[4:])
    chunks = [TextureSamples.decode(f.payload) for f in answers(sensor, 0.0125)]
    assert [c.device_time_us for c in chunks] == [0, 5000]
    assert np.array_equal(np.frombuffer(b"".join(c.counts for c in chunks), "<i2"), counts[:20])


def test_samples_that_nobody_fetches_are_lost_oldest_first_and_time_continues() -> None:
    sensor = TextureSensor(0)
    sensor.add_samples(np.arange(3000, dtype=np.int16))
    first = TextureSamples.decode(answers(sensor, 1.5)[0].payload)
    assert first.device_time_us == 2000 * 500
    assert np.frombuffer(first.counts, "<i2")[0] == 2000


def test_a_sensor_does_not_heat_beyond_what_a_patient_may_touch() -> None:
    sensor = ThermalSensor(0)
    sensor.measure(ssr_counts(SENSOR_PLATE_C) + 2, 0)
    sensor.feed(heat(1000), 0.0)
    assert (sensor.drive, sensor.flags) == (0.0, DeviceFlag.THERMAL_CUT_OUT)
    sensor.measure(ssr_counts(SENSOR_PLATE_C - 2.0), 0)
    sensor.feed(heat(1000), 0.01)
    assert sensor.drive == 0.0
    sensor.feed(heat(0), 0.02)
    sensor.feed(heat(500), 0.03)
    assert (sensor.drive, sensor.flags) == (0.5, 0)


def test_a_pulse_goes_before_the_voltage_and_is_timed_by_the_module() -> None:
    module = TactTip(0)
    module.feed(drive(700, 0, 3000, 15_000, 1), 1.0)
    assert module.motor_mv == 3000
    module.feed(drive(600, 0, 3000, 15_000, 1), 1.01)  # the same pulse: it is neither prolonged nor begun again
    assert [round(module.motor_v(t_s, t_s + 0.002), 6) for t_s in (1.01, 1.014, 1.016)] == [3.0, 1.8, 0.6]
    module.take_output(1.016)
    assert module.motor_mv == 600
    module.feed(drive(600, 0, 3000, 15_000, 1), 1.05)
    assert module.motor_mv == 600
    module.feed(drive(600, 0, 0, 5000, 2), 1.06)  # another one, that brakes
    assert module.motor_mv == 0
    assert module.take_motor_switches() == [(1.0, 700)]


@pytest.mark.parametrize("number", [0, 1, 255])
def test_the_first_pulse_after_power_up_may_have_any_number(number: int) -> None:
    module = TactTip(0)
    module.feed(drive(700, 0, 3000, 15_000, number), 1.0)
    assert module.motor_mv == 3000


def test_a_world_that_is_behind_its_commands_gives_a_pulse_its_length_and_no_more() -> None:
    module, steps = TactTip(0), [1.0 + 0.002 * n for n in range(20)]
    module.feed(drive(500, 0, 3000, 6000, 1), 1.0111)
    volts = [module.motor_v(t_s, t_s + 0.002) for t_s in steps]
    assert sum(volt - 0.5 for volt in volts) * 0.002 == pytest.approx(2.5 * 0.006)
    assert max(volts[:5]) == 0.5
    module.feed(drive(0, 0), 1.0455)
    assert max(module.motor_v(t_s, t_s + 0.002) for t_s in (1.04, 1.044, 1.046)) == 0.0


def test_a_command_without_a_pulse_ends_it_and_so_does_the_time_out() -> None:
    module = TactTip(0)
    module.feed(drive(700, 0, 3000, 50_000, 1), 1.0)
    module.feed(drive(0, 0), 1.01)
    assert (module.motor_mv, module.motor_v(1.01, 1.012)) == (0, 0.0)
    module.feed(drive(700, 0, 3000, 50_000, 2), 2.0)
    module.take_output(2.2)
    assert (module.motor_mv, module.motor_v(2.2, 2.202)) == (0, 0.0)


def test_motor_and_peltier_run_out_100_ms_after_the_last_command() -> None:
    module = TactTip(0)
    module.feed(drive(1000, 300), 2.0)
    module.feed(drive(900, 300), 2.05)
    module.take_output(2.149)
    assert (module.motor_mv, module.drive_permille) == (900, 300)
    module.take_output(2.152)
    assert (module.motor_mv, module.drive_permille, module.flags) == (0, 0, DeviceFlag.COMMAND_TIMEOUT)
    assert module.take_motor_switches() == [(2.0, 1000), (pytest.approx(2.15), 0)]
    module.feed(drive(800, 100), 3.0)
    assert (module.motor_mv, module.flags) == (800, 0)


@pytest.mark.parametrize("counts", [0, 4095, ntc_counts(PLATE_FAULT_C + 0.1)])
def test_a_hot_or_broken_ntc_cuts_the_peltier_at_once_but_not_the_motor(counts: int) -> None:
    module = TactTip(0)
    module.feed(drive(1000, 1000), 0.0)
    module.measure(ntc_counts(PLATE_FAULT_C - 0.2), ntc_counts(20.0))
    assert (module.motor_mv, module.drive_permille, module.flags) == (1000, 1000, 0)
    module.measure(counts, ntc_counts(20.0))
    for now_s in (0.0, 0.01):
        assert (module.motor_mv, module.drive_permille, module.flags) == (1000, 0, DeviceFlag.THERMAL_CUT_OUT)
        module.feed(drive(1000, 1000), now_s)


@pytest.mark.parametrize("kind", [ThermalSensor, TactTip])
@pytest.mark.parametrize("stuck", [600, -700])
def test_a_stuck_drive_obeys_nothing_but_the_cut_out_until_it_is_mended(
    kind: type[ThermalSensor | TactTip], stuck: int
) -> None:
    module = kind(0)

    def driven(now_s: float, permille: int | None, plate_c: float) -> tuple[int, int]:
        """Thousandths that the Peltiers get, and those that are reported, after a command and a measurement."""
        thermal = isinstance(module, ThermalSensor)
        if permille is not None:
            module.feed(heat(permille) if thermal else drive(0, permille), now_s)
        module.measure(ssr_counts(plate_c) if thermal else ntc_counts(plate_c), 1000)
        report = answers(module, now_s)[-1].payload
        if isinstance(module, ThermalSensor):
            return module.drive_permille, ThermalReading.decode(report).heater_permille
        return module.drive_permille, TactTipState.decode(report).peltier_permille

    module.stuck_permille = stuck
    for now_s, permille in ((0.0, None), (0.01, 0), (0.02, 900), (5.0, None)):
        assert driven(now_s, permille, 30.0) == (stuck, stuck)
    assert driven(6.0, None, PLATE_FAULT_C + 0.1) == (0, 0)
    assert module.flags & DeviceFlag.THERMAL_CUT_OUT
    # It stands behind the driver: that the host asks for no heat lets it go only where the driver does not heat either.
    held = 0 if stuck > 0 else stuck
    assert driven(6.01, 0, 30.0) == (held, held)
    module.stuck_permille = None
    assert driven(6.02, None, 30.0) == (0, 0)
    assert driven(6.03, 300, 30.0) == (300, 300)
    assert module.flags == 0


@given(st.floats(-10.0, 90.0))
def test_ntc_counts_and_the_drivers_conversion_agree(temperature_c: float) -> None:
    assert ntc_c(ntc_counts(temperature_c)) == pytest.approx(temperature_c, abs=0.12)


def test_a_force_is_held_100_ms_and_gone_50_ms_later_and_every_fifth_turn_says_so() -> None:
    exoskeleton = Exoskeleton()
    hear(exoskeleton, FrameSender("FingerForces").encode(forces(2.0)), 1.0)
    for now_s, newton, enabled in ((1.0, 2.0, 1.0), (1.0999, 2.0, 1.0), (1.125, 1.0, 0.0), (1.1501, 0.0, 0.0)):
        assert exoskeleton.force_n(now_s) == pytest.approx(newton)
        said = reported(exoskeleton, "ExoskeletonState", 50)
        assert len(said) == 10
        for state in said:
            assert state == pytest.approx({"enabled": enabled, **dict.fromkeys(FINGERS, newton)})


def test_an_exoskeleton_is_driven_once_there_was_no_gap_for_long_enough() -> None:
    exoskeleton, sender = Exoskeleton(), FrameSender("FingerForces")
    seen = []
    for n in range(1200):
        if not 200 <= n < 300:  # a pause of 200 ms
            hear(exoskeleton, sender.encode(forces(0.0)), n * 0.002)
        exoskeleton.force_n(n * 0.002)
        seen.append(exoskeleton.driven(n * 0.002))
    assert seen.index(True) == pytest.approx(300 + DRIVEN_S / 0.002, abs=1)


def test_a_released_telemanipulators_hand_stays_and_fingers_only_rise() -> None:
    robot, pose, height = Telemanipulator(), FrameSender("HandSetpoint"), FrameSender("HeightSetpoint")
    here = np.array([0.004, -0.002, 0.0, 0.001, 0.006])

    def ask(now_s: float, x_mm: float, mm: float, released: bool) -> tuple[float, float, list[float]]:
        hear(robot, pose.encode({"x": x_mm, "y": -x_mm}), now_s)
        hear(robot, height.encode(heights(mm, released)), now_s)
        x_m, y_m, z_m = robot.setpoint_m(now_s)
        return x_m, y_m, z_m.tolist()

    assert ask(0.0, 100.0, -5.0, False) == (0.1, -0.1, pytest.approx([-0.005] * 5))
    robot.measure(0.09, -0.09, here, np.zeros(5))
    assert ask(0.01, 110.0, -5.0, True) == (0.09, -0.09, pytest.approx(here.tolist()))
    robot.measure(0.091, -0.091, here - 0.0005, np.zeros(5))  # swinging on: that is not where it shall stay
    assert ask(0.02, -300.0, -10.0, True) == (0.09, -0.09, pytest.approx(here.tolist()))
    risen = np.maximum(here, 0.002).tolist()
    assert ask(0.03, 0.0, 2.0, True) == (0.09, -0.09, pytest.approx(risen))
    assert ask(0.04, 0.0, -10.0, True) == (0.09, -0.09, pytest.approx(risen))
    assert ask(0.05, 100.0, -5.0, False) == (0.1, -0.1, pytest.approx([-0.005] * 5))


def test_a_telemanipulator_is_released_from_power_up_and_when_heights_end_and_says_so() -> None:
    robot, pose, height = Telemanipulator(), FrameSender("HandSetpoint"), FrameSender("HeightSetpoint")

    def said(now_s: float) -> tuple[float, float, float]:
        robot.setpoint_m(now_s)
        (state,) = reported(robot, "TelemanipulatorState")
        return state["released"], state["hand_alive"], state["heights_alive"]

    assert said(0.0) == (1, 0, 0)
    hear(robot, pose.encode({"x": 100.0, "y": 0.0}), 0.0)
    assert said(0.0) == (1, 1, 0)
    assert robot.setpoint_m(0.0)[0] == 0.0
    hear(robot, height.encode(heights(0.0)), 0.05)
    assert said(0.05) == (0, 1, 1)
    assert robot.setpoint_m(0.05)[0] == 0.1
    robot.measure(0.1, 0.0, np.full(5, 0.003), np.zeros(5))
    assert said(0.101) == (0, 0, 1)
    hear(robot, pose.encode({"x": 200.0, "y": 0.0}), 0.14)
    assert said(0.151) == (1, 1, 0)
    x_m, _, z_m = robot.setpoint_m(0.151)
    assert x_m == 0.1  # no hand is moved whose fingers are not commanded
    assert z_m == pytest.approx(np.full(5, 0.003))
    hear(robot, height.encode(heights(0.0, released=True)), 0.16)
    assert said(0.16) == (1, 1, 1)


def test_frames_for_others_are_let_pass() -> None:
    robot = Telemanipulator()
    hear(robot, FrameSender("FingerForces").encode(forces(1.0)), 0.0)
    assert robot.refused == 0
    assert math.isinf(robot.silent_s("HandSetpoint", 1.0))
