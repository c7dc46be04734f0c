"""Simulated devices that a test moves step by step."""

from collections.abc import Callable

import can

from common.buses.can_frames import FrameReceiver, FrameSender
from common.fingers import FINGERS
from sim_sensors.devices.can_node import STATE_EVERY, CanNode
from sim_sensors.operator_devices import OperatorDevices
from sim_sensors.ports.select_loop import SelectLoop
from sim_sensors.ports.simulation_loop import STEP_S
from sim_sensors.remote_devices import RemoteDevices
from tests.waiting import wait_until

START_S = 100.0


def until(loop: SelectLoop, done: Callable[[], object], patience_s: float = 10.0) -> None:
    """Serve sockets until it is done."""
    wait_until(lambda: loop.serve(0.002) or done(), "nothing came of it", patience_s, every_s=0.0)  # type: ignore[func-returns-value]


def advance(devices: RemoteDevices | OperatorDevices, steps: range) -> None:
    for step in steps:
        devices.step(START_S + step * STEP_S)


def hear(node: CanNode, frame: can.Message, now_s: float) -> None:
    node.feed(frame.arbitration_id, bytes(frame.data), now_s)


def reported(node: CanNode, name: str, turns: int = STATE_EVERY) -> list[dict[str, float]]:
    """The values of each frame of that name that a node sends in its next turns."""
    receiver = FrameReceiver(name)
    frames = [frame for _ in range(turns) for frame in node.take_turn()]
    return [receiver.decode(data) for frame_id, data in frames if frame_id == receiver.frame_id]


def forces(newton: float) -> dict[str, float]:
    return {"enabled": 1.0, **dict.fromkeys(FINGERS, newton)}


def heights(mm: float, released: bool = False) -> dict[str, float]:
    return {"released": float(released), **dict.fromkeys(FINGERS, mm)}


def send_hand(devices: RemoteDevices, steps: range, x_m: float, height_mm: float = 6.0) -> None:
    """Advance with fresh set-points each step."""
    pose, height = FrameSender("HandSetpoint"), FrameSender("HeightSetpoint")
    for step in steps:
        now_s = START_S + step * STEP_S
        for frame in (pose.encode({"x": x_m * 1e3, "y": 0.0}), height.encode(heights(height_mm))):
            hear(devices.robot, frame, now_s)
        devices.step(now_s)
