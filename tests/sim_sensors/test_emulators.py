import itertools
import math
from collections.abc import Callable

import can
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.can_frames import FrameReceiver, FrameSender, by_finger
from common.fingers import FINGERS
from common.framing import Frame, FrameReader
from common.limits import PLATE_FAULT_C, SENSOR_PLATE_C
from common.serial_messages import (
    DeviceFlag,
    DeviceKind,
    HeaterCommand,
    Identity,
    MessageId,
    TactTipCommand,
    TactTipState,
    TextureSamples,
    ThermalReading,
)
from common.thermometry import ntc_c, ssr_c
from sim_sensors.exoskeleton import DRIVEN_S, Exoskeleton
from sim_sensors.serial_module import SerialModule
from sim_sensors.tacttip import TactTip, ntc_counts
from sim_sensors.telemanipulator import Telemanipulator
from sim_sensors.texture_sensor import TextureSensor
from sim_sensors.thermal_sensor import ThermalSensor


def framed(message_id: int, payload: bytes = b"", sequence: int = 0) -> bytes:
    """A frame built bit by bit, without the project's own framing."""
    body = bytes((message_id, sequence)) + payload
    crc = 0xFFFF
    for byte in body:
        crc ^= byte << 8
        for _ in range(8):
            crc = ((crc << 1) ^ 0x1021 if crc & 0x8000 else crc << 1) & 0xFFFF
    stuffed = bytearray()
    for block in (body + bytes((crc & 0xFF, crc >> 8))).split(b"\0"):
        stuffed += bytes((len(block) + 1,)) + block
    return bytes(stuffed) + b"\0"


IDENTIFY = framed(0x01)


def ssr_counts(temperature_c: float) -> int:
    return min(range(4096), key=lambda counts: abs(ssr_c(counts) - temperature_c))


def answers(module: SerialModule, now_s: float, data: bytes = b"") -> list[Frame]:
    module.feed(data, now_s)
    return FrameReader().feed(module.take_output(now_s))


class ModuleContract:
    """What every serial module promises."""

    kind: DeviceKind

    def make(self) -> SerialModule:
        raise NotImplementedError

    def test_it_says_who_it_is_on_request(self) -> None:
        frames = answers(self.make(), 0.001, IDENTIFY)
        (identity,) = [Identity.decode(f.payload) for f in frames if f.message_id == MessageId.IDENTITY]
        assert (identity.kind, identity.finger) == (self.kind, 3)
        assert identity.range_low < identity.range_high

    def test_bytes_may_come_one_by_one(self) -> None:
        module = self.make()
        for byte in IDENTIFY:
            module.feed(bytes((byte,)), 0.0)
        assert MessageId.IDENTITY in {f.message_id for f in answers(module, 0.001)}

    def test_every_damaged_byte_is_counted_and_nothing_is_done(self) -> None:
        for position in range(len(IDENTIFY) - 1):
            for damage in (0x01, 0x80, 0xFF):
                module = self.make()
                broken = bytearray(IDENTIFY)
                broken[position] ^= damage
                frames = answers(module, 0.001, bytes(broken))
                assert MessageId.IDENTITY not in {f.message_id for f in frames}
                assert module.reader.damaged >= 1
                assert MessageId.IDENTITY in {f.message_id for f in answers(module, 0.002, IDENTIFY)}

    def test_an_unknown_message_is_refused(self) -> None:
        module = self.make()
        module.feed(framed(0x7F, b"\x01\x02"), 0.0)
        assert module.refused == 1

    def test_sequence_numbers_go_up_by_one(self) -> None:
        module = self.make()
        sequences = [f.sequence for n in range(300) for f in answers(module, n * 0.01, IDENTIFY)]
        assert all((b - a) & 0xFF == 1 for a, b in itertools.pairwise(sequences))


@pytest.mark.parametrize("make", [TextureSensor, ThermalSensor, TactTip])
@given(chunks=st.lists(st.binary(max_size=40), max_size=8))
def test_any_bytes_are_survived(make: Callable[[int], SerialModule], chunks: list[bytes]) -> None:
    module = make(3)
    for chunk in chunks:
        module.feed(chunk, 0.0)
    frames = answers(module, 0.001, b"\0" + IDENTIFY)
    assert MessageId.IDENTITY in {f.message_id for f in frames}


class TestTextureSensor(ModuleContract):
    kind = DeviceKind.TEXTURE_SENSOR

    def make(self) -> SerialModule:
        return TextureSensor(3)

    def test_samples_come_in_chunks_of_ten_with_the_time_of_their_first(self) -> None:
        sensor = TextureSensor(0)
        counts = np.arange(-2048, -2048 + 25, dtype=np.int16)
        sensor.add_samples(counts[:4])
        assert answers(sensor, 0.002) == []
        sensor.add_samples(counts[4:])
        chunks = [TextureSamples.decode(f.payload) for f in answers(sensor, 0.0125)]
        assert [c.device_time_us for c in chunks] == [0, 5000]
        assert np.array_equal(np.frombuffer(b"".join(c.counts for c in chunks), "<i2"), counts[:20])

    def test_samples_that_nobody_fetches_are_lost_oldest_first_and_time_goes_on(self) -> None:
        sensor = TextureSensor(0)
        sensor.add_samples(np.arange(3000, dtype=np.int16))
        first = TextureSamples.decode(answers(sensor, 1.5)[0].payload)
        assert first.device_time_us == 2000 * 500
        assert np.frombuffer(first.counts, "<i2")[0] == 2000


class TestThermalSensor(ModuleContract):
    kind = DeviceKind.THERMAL_SENSOR

    def make(self) -> SerialModule:
        return ThermalSensor(3)

    def command(self, drive: int) -> bytes:
        return framed(MessageId.HEATER_COMMAND, HeaterCommand(drive).encode())

    def test_it_reads_a_hundred_times_a_second(self) -> None:
        sensor = ThermalSensor(0)
        sensor.measure(1234, 987)
        readings = [ThermalReading.decode(f.payload) for n in range(500) for f in answers(sensor, n * 0.002)]
        assert len(readings) == 100
        assert (readings[7].plate_counts, readings[7].ambient_counts) == (1234, 987)
        assert readings[7].device_time_us == 70_000

    def test_the_heater_runs_out_100_ms_after_the_last_command(self) -> None:
        sensor = ThermalSensor(0)
        assert sensor.flags == DeviceFlag.COMMAND_TIMEOUT
        sensor.feed(self.command(700), 1.0)
        sensor.take_output(1.0999)
        assert (sensor.drive, sensor.flags) == (0.7, 0)
        sensor.take_output(1.1001)
        assert (sensor.drive, sensor.flags) == (0.0, DeviceFlag.COMMAND_TIMEOUT)

    def test_it_does_not_heat_beyond_what_a_patient_may_touch(self) -> None:
        sensor = ThermalSensor(0)
        sensor.measure(ssr_counts(SENSOR_PLATE_C) + 2, 0)
        sensor.feed(self.command(1000), 0.0)
        assert (sensor.drive, sensor.flags) == (0.0, DeviceFlag.THERMAL_CUT_OUT)
        sensor.measure(ssr_counts(SENSOR_PLATE_C - 2.0), 0)
        sensor.feed(self.command(1000), 0.01)
        assert sensor.drive == 0.0
        sensor.feed(self.command(0), 0.02)
        sensor.feed(self.command(500), 0.03)
        assert (sensor.drive, sensor.flags) == (0.5, 0)

    def test_its_reading_tells_what_the_heater_gets(self) -> None:
        sensor = ThermalSensor(0)
        sensor.measure(ssr_counts(30.0), 0)

        def reported(now_s: float, data: bytes = b"") -> int:
            return ThermalReading.decode(answers(sensor, now_s, data)[-1].payload).heater_permille

        assert reported(0.0, self.command(-300)) == -300
        assert reported(0.05) == -300
        assert reported(0.11) == 0
        sensor.measure(ssr_counts(SENSOR_PLATE_C) + 2, 0)
        assert reported(0.2, self.command(500)) == 0

    @pytest.mark.parametrize("stuck", [400, -700])
    def test_a_stuck_drive_obeys_neither_command_nor_time_out(self, stuck: int) -> None:
        sensor = ThermalSensor(0)
        sensor.stuck_permille = stuck
        for now_s, data in ((0.0, b""), (0.01, self.command(0)), (0.02, self.command(900)), (5.0, b"")):
            sensor.measure(ssr_counts(30.0), 0)
            reading = ThermalReading.decode(answers(sensor, now_s, data)[-1].payload)
            assert (sensor.drive_permille, reading.heater_permille) == (stuck, stuck)
        sensor.stuck_permille = None
        sensor.measure(ssr_counts(30.0), 0)
        assert sensor.drive_permille == 0

    def test_the_cut_out_holds_a_stuck_heater_off_until_it_is_mended(self) -> None:
        sensor = ThermalSensor(0)
        sensor.stuck_permille = 400
        sensor.measure(ssr_counts(SENSOR_PLATE_C) + 2, 0)
        assert (sensor.drive_permille, sensor.flags & DeviceFlag.THERMAL_CUT_OUT) == (0, DeviceFlag.THERMAL_CUT_OUT)
        sensor.feed(self.command(0), 0.0)
        sensor.measure(ssr_counts(30.0), 0)
        assert sensor.drive_permille == 0  # though the host asks for no heat: the driver behind which it stands does
        sensor.stuck_permille = None
        sensor.measure(ssr_counts(30.0), 0)
        assert sensor.flags & DeviceFlag.THERMAL_CUT_OUT == 0


class TestTactTip(ModuleContract):
    kind = DeviceKind.TACTTIP

    def make(self) -> SerialModule:
        return TactTip(3)

    def command(self, motor_mv: int, drive: int, *pulse: int) -> bytes:
        return framed(MessageId.TACTTIP_COMMAND, TactTipCommand(motor_mv, drive, *pulse).encode())

    def test_commands_reach_motor_and_peltier(self) -> None:
        module = TactTip(0)
        module.feed(self.command(1410, -250), 0.0)
        assert (module.motor_v(0.0, 0.002), module.peltier_drive, module.flags) == (1.41, -0.25, 0)

    def test_a_pulse_goes_before_the_voltage_and_is_timed_by_the_module(self) -> None:
        module = TactTip(0)
        module.feed(self.command(700, 0, 3000, 15_000, 1), 1.0)
        assert module.motor_mv == 3000
        module.feed(
            self.command(600, 0, 3000, 15_000, 1), 1.01
        )  # the same pulse: it is neither prolonged nor begun anew
        assert [round(module.motor_v(t_s, t_s + 0.002), 6) for t_s in (1.01, 1.014, 1.016)] == [3.0, 1.8, 0.6]
        module.take_output(1.016)
        assert module.motor_mv == 600
        module.feed(self.command(600, 0, 3000, 15_000, 1), 1.05)
        assert module.motor_mv == 600
        module.feed(self.command(600, 0, 0, 5000, 2), 1.06)  # another one, that brakes
        assert module.motor_mv == 0
        assert module.take_motor_switches() == [(1.0, 700)]

    def test_a_world_that_is_behind_its_commands_gives_a_pulse_its_length_and_no_more(self) -> None:
        module, steps = TactTip(0), [1.0 + 0.002 * n for n in range(20)]
        module.feed(self.command(500, 0, 3000, 6000, 1), 1.0111)
        volts = [module.motor_v(t_s, t_s + 0.002) for t_s in steps]
        assert sum(volt - 0.5 for volt in volts) * 0.002 == pytest.approx(2.5 * 0.006)
        assert max(volts[:5]) == 0.5
        module.feed(self.command(0, 0), 1.0455)
        assert max(module.motor_v(t_s, t_s + 0.002) for t_s in (1.04, 1.044, 1.046)) == 0.0

    def test_a_command_without_a_pulse_ends_it_and_so_does_the_time_out(self) -> None:
        module = TactTip(0)
        module.feed(self.command(700, 0, 3000, 50_000, 1), 1.0)
        module.feed(self.command(0, 0), 1.01)
        assert (module.motor_mv, module.motor_v(1.01, 1.012)) == (0, 0.0)
        module.feed(self.command(700, 0, 3000, 50_000, 2), 2.0)
        module.take_output(2.2)
        assert (module.motor_mv, module.motor_v(2.2, 2.202)) == (0, 0.0)

    def test_a_command_beyond_the_drives_is_refused_and_feeds_no_watchdog(self) -> None:
        module = TactTip(0)
        module.feed(framed(MessageId.TACTTIP_COMMAND, bytes.fromhex("b90b00000000000000")), 0.0)  # 3001 mV
        assert (module.motor_mv, module.refused, module.flags) == (0, 1, DeviceFlag.COMMAND_TIMEOUT)

    def test_motor_and_peltier_run_out_100_ms_after_the_last_command(self) -> None:
        module = TactTip(0)
        module.feed(self.command(1000, 300), 2.0)
        module.feed(self.command(900, 300), 2.05)
        module.take_output(2.149)
        assert (module.motor_mv, module.peltier_permille) == (900, 300)
        module.take_output(2.152)
        assert (module.motor_mv, module.peltier_permille, module.flags) == (0, 0, DeviceFlag.COMMAND_TIMEOUT)
        assert module.take_motor_switches() == [(2.0, 1000), (pytest.approx(2.15), 0)]
        module.feed(self.command(800, 100), 3.0)
        assert (module.motor_mv, module.flags) == (800, 0)

    def test_damage_anywhere_in_a_command_changes_no_drive(self) -> None:
        good = self.command(1410, 1000)
        for position in range(len(good) - 1):
            broken = bytearray(good)
            broken[position] ^= 0x40
            module = TactTip(0)
            module.feed(bytes(broken), 0.0)
            assert (module.motor_mv, module.peltier_permille) == (0, 0)

    @pytest.mark.parametrize("counts", [0, 4095, ntc_counts(PLATE_FAULT_C + 0.1)])
    def test_a_hot_or_broken_ntc_cuts_the_peltier_but_not_the_motor(self, counts: int) -> None:
        module = TactTip(0)
        module.measure(counts, ntc_counts(20.0))
        module.feed(self.command(1000, 1000), 0.0)
        assert (module.motor_mv, module.peltier_permille) == (1000, 0)
        assert module.flags == DeviceFlag.THERMAL_CUT_OUT

    def test_a_plate_that_gets_hot_between_commands_is_cut_at_once(self) -> None:
        module = TactTip(0)
        module.feed(self.command(0, 1000), 0.0)
        module.measure(ntc_counts(PLATE_FAULT_C - 0.2), 0)
        assert module.peltier_permille == 1000
        module.measure(ntc_counts(PLATE_FAULT_C + 0.1), 0)
        assert module.peltier_permille == 0

    def test_its_state_tells_what_it_measures(self) -> None:
        module = TactTip(0)
        module.measure(ntc_counts(33.0), ntc_counts(20.5))
        state = TactTipState.decode(answers(module, 0.02)[0].payload)
        assert ntc_c(state.plate_counts) == pytest.approx(33.0, abs=0.03)
        assert ntc_c(state.hot_side_counts) == pytest.approx(20.5, abs=0.03)

    def test_its_state_tells_what_motor_and_peltiers_get(self) -> None:
        module = TactTip(0)
        module.measure(ntc_counts(33.0), ntc_counts(20.0))

        def reported(now_s: float, data: bytes = b"") -> tuple[int, int]:
            state = TactTipState.decode(answers(module, now_s, data)[-1].payload)
            return state.motor_mv, state.peltier_permille

        assert reported(0.0, self.command(1410, -250)) == (1410, -250)
        assert reported(0.05) == (1410, -250)
        assert reported(0.11) == (0, 0)
        module.measure(ntc_counts(PLATE_FAULT_C + 0.1), 0)
        assert reported(0.2, self.command(1000, 500)) == (1000, 0)

    def test_a_stuck_peltier_obeys_nothing_but_the_cut_out(self) -> None:
        module = TactTip(0)
        module.stuck_permille = 600
        for now_s, data in ((0.0, b""), (0.01, self.command(1000, -200)), (5.0, b"")):
            module.measure(ntc_counts(33.0), ntc_counts(20.0))
            answers(module, now_s, data)
            assert module.peltier_permille == 600
        assert module.motor_mv == 0
        module.measure(ntc_counts(PLATE_FAULT_C + 0.1), 0)
        assert module.peltier_permille == 0
        module.feed(self.command(0, 0), 6.0)
        module.measure(ntc_counts(PLATE_FAULT_C - 5.0), 0)
        assert module.peltier_permille == 0
        module.stuck_permille = None
        module.measure(ntc_counts(33.0), 0)
        module.feed(self.command(0, 300), 6.01)
        assert module.peltier_permille == 300


@given(st.floats(-10.0, 90.0))
def test_ntc_counts_and_the_drivers_conversion_agree(temperature_c: float) -> None:
    assert ntc_c(ntc_counts(temperature_c)) == pytest.approx(temperature_c, abs=0.12)


def hear(node: Exoskeleton | Telemanipulator, frame: can.Message, now_s: float) -> None:
    node.feed(frame.arbitration_id, bytes(frame.data), now_s)


def forces(newton: float) -> dict[str, float]:
    return {"enabled": 1.0, **dict.fromkeys(FINGERS, newton)}


def heights(mm: float, released: bool = False) -> dict[str, float]:
    return {"released": float(released), **dict.fromkeys(FINGERS, mm)}


def states(node: Exoskeleton | Telemanipulator, name: str, turns: int) -> list[dict[str, float]]:
    """What the node says that it does, over so many of its turns."""
    receiver = FrameReceiver(name)
    frames = [frame for _ in range(turns) for frame in node.take_frames() if frame.arbitration_id == receiver.frame_id]
    return [receiver.decode(bytes(frame.data)) for frame in frames]


class TestExoskeleton:
    def test_it_tells_pose_and_heights(self) -> None:
        exoskeleton = Exoskeleton()
        exoskeleton.measure(-0.17, 0.002, np.array([0.006, -0.002, 0.0, 0.001, 0.01]))
        pose, height = exoskeleton.take_frames()[:2]
        assert FrameReceiver("HandPose").decode(bytes(pose.data)) == {"x": -170.0, "y": 2.0}
        measured = by_finger(FrameReceiver("FingerHeights").decode(bytes(height.data)))
        assert measured == pytest.approx((6.0, -2.0, 0.0, 1.0, 10.0))

    def test_a_force_is_held_100_ms_and_gone_50_ms_later(self) -> None:
        exoskeleton, sender = Exoskeleton(), FrameSender("FingerForces")
        hear(exoskeleton, sender.encode(forces(2.0)), 1.0)
        assert exoskeleton.force_n(1.1) == pytest.approx(2.0)
        assert exoskeleton.force_n(1.125) == pytest.approx(1.0)
        assert exoskeleton.force_n(1.1501) == pytest.approx(0.0)

    def test_it_says_at_every_fifth_turn_what_it_does(self) -> None:
        exoskeleton, sender = Exoskeleton(), FrameSender("FingerForces")
        hear(exoskeleton, sender.encode(forces(2.0)), 1.0)
        for now_s, newton, enabled in ((1.0, 2.0, 1.0), (1.125, 1.0, 0.0), (1.2, 0.0, 0.0)):
            exoskeleton.force_n(now_s)
            said = states(exoskeleton, "ExoskeletonState", 50)
            assert len(said) == 10
            for state in said:
                assert state == pytest.approx({"enabled": enabled, **dict.fromkeys(FINGERS, newton)})

    def test_repeated_and_damaged_frames_do_not_keep_a_force_up(self) -> None:
        exoskeleton, sender = Exoskeleton(), FrameSender("FingerForces")
        frame = sender.encode(forces(2.0))
        hear(exoskeleton, frame, 0.0)
        for n in range(1, 100):
            hear(exoskeleton, frame, n * 0.002)
            damaged = bytearray(sender.encode(forces(5.0)).data)
            damaged[n % 8] ^= 1 << (n % 7)
            exoskeleton.feed(frame.arbitration_id, bytes(damaged), n * 0.002)
        assert exoskeleton.force_n(0.198) == pytest.approx(0.0)
        assert exoskeleton.refused >= 99

    def test_it_is_driven_once_there_was_no_gap_for_long_enough(self) -> None:
        exoskeleton, sender = Exoskeleton(), FrameSender("FingerForces")
        seen = []
        for n in range(1200):
            if not 200 <= n < 300:  # a pause of 200 ms
                hear(exoskeleton, sender.encode(forces(0.0)), n * 0.002)
            exoskeleton.force_n(n * 0.002)
            seen.append(exoskeleton.driven(n * 0.002))
        assert seen.index(True) == pytest.approx(300 + DRIVEN_S / 0.002, abs=1)


class TestTelemanipulator:
    def test_it_follows_set_points_and_stops_where_it_is_when_they_end(self) -> None:
        robot, pose, height = Telemanipulator(), FrameSender("HandSetpoint"), FrameSender("HeightSetpoint")
        robot.measure(0.01, 0.0, np.full(5, 0.004), np.zeros(5))
        assert robot.setpoint_m(0.0)[0] == 0.01
        hear(robot, pose.encode({"x": 100.0, "y": -20.0}), 0.0)
        hear(robot, height.encode(heights(-2.0)), 0.0)
        x_m, y_m, z_m = robot.setpoint_m(0.099)
        assert (x_m, y_m) == (0.1, -0.02)
        assert z_m == pytest.approx(np.full(5, -0.002))
        robot.measure(0.05, -0.01, np.full(5, 0.001), np.zeros(5))
        assert robot.setpoint_m(0.101)[:2] == (0.05, -0.01)
        robot.measure(0.06, -0.01, np.full(5, 0.0005), np.zeros(5))
        x_m, _, z_m = robot.setpoint_m(0.2)
        assert x_m == 0.05
        assert z_m == pytest.approx(np.full(5, 0.001))

    def test_released_the_hand_stays_and_fingers_only_rise(self) -> None:
        robot, pose, height = Telemanipulator(), FrameSender("HandSetpoint"), FrameSender("HeightSetpoint")
        here = np.array([0.004, -0.002, 0.0, 0.001, 0.006])

        def tell(now_s: float, x_mm: float, mm: float, released: bool) -> tuple[float, float, list[float]]:
            hear(robot, pose.encode({"x": x_mm, "y": -x_mm}), now_s)
            hear(robot, height.encode(heights(mm, released)), now_s)
            x_m, y_m, z_m = robot.setpoint_m(now_s)
            return x_m, y_m, z_m.tolist()

        assert tell(0.0, 100.0, -5.0, False) == (0.1, -0.1, pytest.approx([-0.005] * 5))
        robot.measure(0.09, -0.09, here, np.zeros(5))
        assert tell(0.01, 110.0, -5.0, True) == (0.09, -0.09, pytest.approx(here.tolist()))
        robot.measure(0.091, -0.091, here - 0.0005, np.zeros(5))  # swinging on: that is not where it shall stay
        assert tell(0.02, -300.0, -10.0, True) == (0.09, -0.09, pytest.approx(here.tolist()))
        risen = np.maximum(here, 0.002).tolist()
        assert tell(0.03, 0.0, 2.0, True) == (0.09, -0.09, pytest.approx(risen))
        assert tell(0.04, 0.0, -10.0, True) == (0.09, -0.09, pytest.approx(risen))
        assert tell(0.05, 100.0, -5.0, False) == (0.1, -0.1, pytest.approx([-0.005] * 5))

    def test_it_is_released_from_power_up_and_when_heights_end_and_says_so(self) -> None:
        robot, pose, height = Telemanipulator(), FrameSender("HandSetpoint"), FrameSender("HeightSetpoint")

        def said(now_s: float) -> tuple[float, float, float]:
            robot.setpoint_m(now_s)
            (state,) = states(robot, "TelemanipulatorState", 5)
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

    def test_it_tells_positions_and_forces_within_its_ranges(self) -> None:
        robot = Telemanipulator()
        robot.measure(0.02, 0.0, np.full(5, 0.002), np.array([-0.02, 0.5, 1.0, 2.0, 99.0]))
        data = [bytes(frame.data) for frame in robot.take_frames()]
        assert FrameReceiver("HandPoseMeasured").decode(data[0])["x"] == pytest.approx(20.0)
        assert by_finger(FrameReceiver("FingerHeightsMeasured").decode(data[1])) == pytest.approx((2.0,) * 5)
        measured = by_finger(FrameReceiver("ContactForces").decode(data[2]))
        assert measured == pytest.approx((0.0, 0.5, 1.0, 2.0, 10.23))

    def test_frames_for_others_are_let_pass(self) -> None:
        robot = Telemanipulator()
        hear(robot, FrameSender("FingerForces").encode(forces(1.0)), 0.0)
        assert robot.refused == 0
        assert math.isinf(robot.silent_s("HandSetpoint", 1.0))
