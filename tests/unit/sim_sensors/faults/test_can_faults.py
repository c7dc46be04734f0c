"""Faults of the simulated devices on the CAN buses: wrong readings, damaged frames and foreign frames."""

import numpy as np
import pytest

from common.buses.can_frames import BadFrame, FrameReceiver, FrameSender
from common.fingers import FINGERS
from sim_sensors.devices.breakable_parts import Encoder, ForceSensor, Transmitter
from sim_sensors.operator_devices import OperatorDevices
from sim_sensors.ports.simulation_loop import STEP_S
from sim_sensors.remote_devices import RemoteDevices
from tests.unit.sim_sensors.stepped import START_S, advance, forces, hear, heights, reported, send_hand

INDEX = FINGERS.index("index")


def test_an_encoder_that_glitches_is_far_off_now_and_then_and_right_between() -> None:
    encoder = Encoder()
    encoder.fault = "glitch"
    read_m = np.array([encoder.read(0.002) for _ in range(5000)])
    off = np.abs(read_m - 0.002) > 0.0
    assert set(np.round(np.abs(read_m[off] - 0.002), 9)) == {0.006}
    assert 50 <= off.sum() <= 150  # 10 a second
    encoder.fault = None
    assert encoder.read(0.001) == 0.001


def test_a_stuck_encoder_and_a_frozen_force_sensor_repeat_and_a_biased_one_says_too_much() -> None:
    encoder, sensor = Encoder(), ForceSensor()
    encoder.read(0.003)
    encoder.fault = "stuck"
    assert [encoder.read(place_m) for place_m in (0.0, -0.004)] == [0.003, 0.003]
    sensor.read(0.7)
    sensor.fault = "frozen"
    assert sensor.read(2.0) == 0.7
    sensor.fault = "biased"
    assert sensor.read(2.0) == 3.5


def sent(transmitter: Transmitter, name: str, frames: int) -> list[bytes]:
    sender = FrameSender(name)
    values = dict.fromkeys((*FINGERS, "x", "y", "enabled"), 0.0)
    return [data for _ in range(frames) for _, data in transmitter.send([sender.named_frame(values)])]


@pytest.mark.parametrize(
    ("damage", "name", "found"),
    [
        ("counter", "FingerHeights", True),
        ("counter", "HandPose", True),
        ("crc", "HandPose", True),
        ("crc", "FingerHeights", False),  # it has none that could be wrong
    ],
)
@pytest.mark.parametrize("share", [0.3, 1.0])
def test_as_many_frames_are_refused_as_were_damaged(damage: str, name: str, found: bool, share: float) -> None:
    transmitter, receiver = Transmitter(), FrameReceiver(name)
    transmitter.damage = (damage, share)  # type: ignore[assignment]
    refused = 0
    for data in sent(transmitter, name, 400):
        try:
            receiver.decode(data)
        except BadFrame:
            refused += 1
    assert refused == (pytest.approx(400 * share, abs=40) if found else 0)


def test_at_both_sites_the_hand_continues_and_only_its_reported_height_is_wrong(
    remote: RemoteDevices, operator: OperatorDevices
) -> None:
    send_hand(remote, range(1, 100), x_m=0.0)
    advance(operator, range(1, 100))
    for devices in (remote, operator):
        devices.faults.apply("encoder index stuck")

    def reported_mm() -> list[float]:
        frames = reported(remote.robot, "FingerHeightsMeasured") + reported(operator.exoskeleton, "FingerHeights")
        return [values["index"] for values in frames]

    stuck_mm = reported_mm()
    before_m = operator.hand.z_m[INDEX]
    advance(operator, range(100, 200))
    send_hand(remote, range(100, 200), x_m=0.0)
    assert reported_mm() == stuck_mm
    assert operator.hand.z_m[INDEX] != before_m
    operator.faults.apply("mend encoder index")
    advance(operator, range(200, 202))
    assert reported_mm()[-1] == pytest.approx(1e3 * operator.hand.z_m[INDEX], abs=0.01)


def test_a_force_sensor_lies_to_the_robot_and_not_to_the_world(remote: RemoteDevices) -> None:
    remote.faults.apply("force index biased")
    advance(remote, range(1, 3))
    (force_n,) = reported(remote.robot, "ContactForces", 1)
    assert force_n["index"] == pytest.approx(1.5, abs=0.1)
    assert remote.world.force_n[INDEX] == 0.0
    assert force_n["middle"] == pytest.approx(0.0, abs=0.1)


def test_one_joint_of_the_robot_is_stuck_and_the_others_go_where_they_are_sent(remote: RemoteDevices) -> None:
    send_hand(remote, range(1, 200), x_m=0.0)
    remote.faults.apply("disobey index")
    before_m = remote.world.z_m.copy()
    send_hand(remote, range(200, 500), x_m=0.02, height_mm=3.0)
    assert remote.world.z_m[INDEX] == pytest.approx(before_m[INDEX], abs=1e-4)
    assert remote.world.x_m == pytest.approx(0.02, abs=1e-4)
    remote.faults.apply("mend disobey index")
    assert remote.servos.jammed == set()


def test_one_drive_of_the_exoskeleton_pushes_whatever_is_commanded_and_reports_it(operator: OperatorDevices) -> None:
    operator.faults.apply("push index 2.5")
    hear(operator.exoskeleton, FrameSender("FingerForces").encode(forces(1.0)), START_S)
    assert operator.exoskeleton.force_n(START_S).tolist() == [1.0, 2.5, 1.0, 1.0, 1.0]
    assert operator.exoskeleton.force_n(START_S + 1.0).tolist() == [0.0, 2.5, 0.0, 0.0, 0.0]
    assert reported(operator.exoskeleton, "ExoskeletonState")[0]["index"] == 2.5
    operator.faults.apply("mend push index")
    assert not operator.exoskeleton.force_n(START_S + 1.0).any()
    for words in ("push index", "push index much", "push index 10.5", "push index -1", "push index nan"):
        with pytest.raises(ValueError, match="is not a force of 0 to 10 N"):
            operator.faults.apply(words)


def test_a_second_sender_answers_each_frame_of_a_site_and_overrides_it(operator: OperatorDevices) -> None:
    bus, node = operator.bus, operator.exoskeleton
    assert bus.intruder is not None
    frame = FrameSender("FingerForces").encode(forces(1.0))
    assert bus.intruder.answer(frame.arbitration_id, bytes(frame.data)) == []
    operator.faults.apply("intrude")
    for _ in range(40):
        frame = FrameSender("FingerForces").encode(forces(1.0))
        ((frame_id, data),) = bus.intruder.answer(frame.arbitration_id, bytes(frame.data))
        assert frame_id == frame.arbitration_id
        node.feed(frame_id, data, START_S)
    assert node.force_n(START_S).tolist() == [5.0] * len(FINGERS)
    assert bus.intruder.answer(0x100, bytes(8)) == []
    operator.faults.apply("mend intrude")
    assert bus.intruder.answer(frame.arbitration_id, bytes(frame.data)) == []


def test_a_robot_that_clings_ignores_a_commanded_release_and_not_its_time_out(remote: RemoteDevices) -> None:
    send_hand(remote, range(1, 20), x_m=0.0)
    remote.faults.apply("cling")
    now_s = START_S + 20 * STEP_S
    hear(remote.robot, FrameSender("HeightSetpoint").encode(heights(6.0, released=True)), now_s)
    remote.robot.setpoint_m(now_s)
    assert not remote.robot.released
    remote.robot.setpoint_m(now_s + 1.0)
    assert remote.robot.released
