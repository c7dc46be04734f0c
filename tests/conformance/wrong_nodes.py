"""Emulated CAN nodes with one thing wrong each, by the number of the duty that they break."""

from collections.abc import Callable
from typing import Any

import can
import numpy as np

from common.can_frames import frame_crc, packing
from common.fingers import FINGERS
from sim_sensors.exoskeleton import Exoskeleton
from sim_sensors.telemanipulator import Telemanipulator
from teletaction.conformance.node_talk import NodeName
from tests.conformance.virtual_ends import STEP_S, VirtualNode
from tests.conformance.wrong_modules import over

POSE_ID, STATE_ID, ROBOT_STATE_ID = 0x100, 0x102, 0x213
HANGS_ON = 6
"""State frames, 60 ms."""


def exoskeleton() -> VirtualNode:
    return VirtualNode(Exoskeleton())


def telemanipulator() -> VirtualNode:
    return VirtualNode(Telemanipulator())


def remade(frame: can.Message, data: bytes) -> can.Message:
    """A frame of other bytes, and with the right CRC."""
    crc = frame_crc(frame.arbitration_id, data)
    return can.Message(
        timestamp=frame.timestamp,
        arbitration_id=frame.arbitration_id,
        data=data[:7] + bytes((crc,)),
        is_extended_id=False,
    )


def with_counter(frame: can.Message, counter: int) -> can.Message:
    """A frame whose counter stands in the low half of byte 6."""
    return remade(frame, bytes(frame.data[:6]) + bytes((counter & 0xF,)) + b"\0")


def spoiled(end: VirtualNode, frame_id: int, change: Callable[[can.Message, int], list[can.Message]]) -> VirtualNode:
    """Change the frames of one identifier, which come with their number."""
    count = 0

    def spoil(frame: can.Message) -> list[can.Message]:
        nonlocal count
        if frame.arbitration_id != frame_id:
            return [frame]
        count += 1
        return change(frame, count)

    end.spoil = spoil
    return end


def changed_states(
    end: VirtualNode, name: str, change: Callable[[dict[str, float], int], dict[str, float]]
) -> VirtualNode:
    """Change the values of the state frames, which come with their number."""
    layout = packing(name)

    def remake(frame: can.Message, count: int) -> list[can.Message]:
        values, counter = layout.unpack(bytes(frame.data))
        return [remade(frame, layout.pack(change(values, count), counter))]

    return spoiled(end, layout.frame_id, remake)


def hanging_on(end: VirtualNode, name: str, signal: str, value: float, turns: int = HANGS_ON) -> VirtualNode:
    """A state that says a signal for some frames longer than it is so."""
    left = 0

    def hang(values: dict[str, float], _: int) -> dict[str, float]:
        nonlocal left
        left = turns if values[signal] == value else left - 1
        return {**values, signal: value} if left > 0 else values

    return changed_states(end, name, hang)


def heard(end: VirtualNode, do: Callable[[Callable[..., None], int, bytes, float], None]) -> VirtualNode:
    """Change what the node hears."""
    over(end.node, "feed", do)
    return end


# --- every node


def babbles() -> VirtualNode:
    other = can.Message(arbitration_id=0x555, data=bytes(8), is_extended_id=False)
    return spoiled(exoskeleton(), POSE_ID, lambda frame, n: [frame, other] if n % 100 == 0 else [frame])


def errors() -> VirtualNode:
    error = can.Message(arbitration_id=0x004, data=bytes(8), is_error_frame=True)
    return spoiled(exoskeleton(), POSE_ID, lambda frame, n: [frame, error] if n % 400 == 0 else [frame])


def unnamed_bits() -> VirtualNode:
    def set_bit(frame: can.Message, _: int) -> list[can.Message]:
        data = bytearray(frame.data)
        data[5] |= 0x10
        return [remade(frame, bytes(data))]

    return spoiled(exoskeleton(), POSE_ID, set_bit)


def extended() -> VirtualNode:
    def extend(frame: can.Message, count: int) -> list[can.Message]:
        frame.is_extended_id = count % 100 == 0
        return [frame]

    return spoiled(exoskeleton(), POSE_ID, extend)


def repeats_a_counter() -> VirtualNode:
    return spoiled(exoskeleton(), POSE_ID, lambda frame, n: [with_counter(frame, n - n // 50)])


def counts_to_14() -> VirtualNode:
    return spoiled(exoskeleton(), POSE_ID, lambda frame, n: [with_counter(frame, n % 15)])


def wrong_crc_at_times() -> VirtualNode:
    def spoil(frame: can.Message, count: int) -> list[can.Message]:
        if count % 100 == 0:
            frame.data[7] ^= 0xFF
        return [frame]

    return spoiled(exoskeleton(), POSE_ID, spoil)


def at_250_hz() -> VirtualNode:
    return spoiled(exoskeleton(), POSE_ID, lambda frame, n: [] if n % 2 else [with_counter(frame, n // 2)])


def enabled_at_power_up() -> VirtualNode:
    end = exoskeleton()

    def enable(values: dict[str, float], _: int) -> dict[str, float]:
        return values if end.node._heard_s else {**values, "enabled": 1.0}

    return changed_states(end, "ExoskeletonState", enable)


def pushes_at_power_up() -> VirtualNode:
    end = exoskeleton()

    def push(values: dict[str, float], _: int) -> dict[str, float]:
        return values if end.node._heard_s else {**values, "little": 0.01}

    return changed_states(end, "ExoskeletonState", push)


def not_released_at_power_up() -> VirtualNode:
    end = telemanipulator()

    def hold(values: dict[str, float], _: int) -> dict[str, float]:
        return values if end.node._heard_s else {**values, "released": 0.0}

    return changed_states(end, "TelemanipulatorState", hold)


def drops_out() -> VirtualNode:
    enabled = 0

    def drop(values: dict[str, float], _: int) -> dict[str, float]:
        nonlocal enabled
        enabled = enabled + 1 if values["enabled"] else 0
        return {**values, "enabled": 0.0} if enabled % 25 == 24 else values

    return changed_states(exoskeleton(), "ExoskeletonState", drop)


def slow_to_time_out() -> VirtualNode:
    return hanging_on(exoskeleton(), "ExoskeletonState", "enabled", 1.0)


def slow_to_stop_its_hand() -> VirtualNode:
    return hanging_on(telemanipulator(), "TelemanipulatorState", "hand_alive", 1.0)


def _with_right_crc(frame_id: int, data: bytes) -> bytes:
    return data[:7] + bytes((frame_crc(frame_id, data),))


def any_crc() -> VirtualNode:
    def feed(below: Callable[..., None], frame_id: int, data: bytes, now_s: float) -> None:
        of_another = len(data) == 8 and data[7] == frame_crc(frame_id + 1, data)
        below(frame_id, data if of_another or len(data) < 8 else _with_right_crc(frame_id, data), now_s)

    return heard(exoskeleton(), feed)


def crc_of_any_identifier() -> VirtualNode:
    def feed(below: Callable[..., None], frame_id: int, data: bytes, now_s: float) -> None:
        of_another = len(data) == 8 and data[7] == frame_crc(frame_id + 1, data)
        below(frame_id, _with_right_crc(frame_id, data) if of_another else data, now_s)

    return heard(exoskeleton(), feed)


def any_counter() -> VirtualNode:
    end = exoskeleton()

    def feed(below: Callable[..., None], frame_id: int, data: bytes, now_s: float) -> None:
        end.node._receivers[frame_id].begin()
        below(frame_id, data, now_s)

    return heard(end, feed)


def no_gaps() -> VirtualNode:
    seen: int | None = None

    def feed(below: Callable[..., None], frame_id: int, data: bytes, now_s: float) -> None:
        nonlocal seen
        counter = data[6] >> 4
        follows = seen is None or (counter - seen) & 0xF in (0, 1)
        seen = counter
        if follows:
            below(frame_id, data, now_s)

    return heard(exoskeleton(), feed)


def any_length() -> VirtualNode:
    def feed(below: Callable[..., None], frame_id: int, data: bytes, now_s: float) -> None:
        below(frame_id, data if len(data) == 8 else _with_right_crc(frame_id, data), now_s)

    return heard(exoskeleton(), feed)


# --- exoskeleton


def crossed_fingers() -> VirtualNode:
    return changed_states(
        exoskeleton(),
        "ExoskeletonState",
        lambda values, _: {**values, "index": values["ring"], "ring": values["index"]},
    )


def enabled_or_not() -> VirtualNode:
    end = exoskeleton()

    def obey(below: Callable[..., None], name: str, values: dict[str, float], now_s: float) -> None:
        below(name, values, now_s)
        end.node._force_n = np.array([values[finger] for finger in FINGERS])

    over(end.node, "_obey", obey)
    return end


def lets_go_slowly() -> VirtualNode:
    left = 0

    def linger(values: dict[str, float], _: int) -> dict[str, float]:
        nonlocal left
        left = HANGS_ON if values["thumb"] > 0.0 else left - 1
        return {**values, "thumb": max(values["thumb"], 0.02)} if left > 0 else values

    return changed_states(exoskeleton(), "ExoskeletonState", linger)


# --- telemanipulator


def going(change: Callable[[Telemanipulator, Any, float, float, Any], tuple[float, float, Any]]) -> VirtualNode:
    """A telemanipulator that goes elsewhere; `change` is given the node, its world, and where it should go."""
    end = telemanipulator()

    def setpoint(below: Callable[[float], Any], now_s: float) -> Any:
        return change(end.node, end.hand, *below(now_s))

    over(end.node, "setpoint_m", setpoint)
    return end


def creep_m(speed_m_s: float) -> float:
    """How far ahead the hand's servo must be set so that it creeps."""
    return speed_m_s * STEP_S / 0.2


def creeps() -> VirtualNode:
    def change(node: Telemanipulator, hand: Any, x_m: float, y_m: float, z_m: Any) -> tuple[float, float, Any]:
        silent = not (node._hand_alive or node._heights_alive)
        return (hand.x_m + creep_m(0.0002) if silent else x_m), y_m, z_m

    return going(change)


def goes_half_way() -> VirtualNode:
    return going(lambda node, hand, x_m, y_m, z_m: (0.5 * x_m, y_m, z_m))


def hand_follows_released() -> VirtualNode:
    def change(node: Telemanipulator, hand: Any, x_m: float, y_m: float, z_m: Any) -> tuple[float, float, Any]:
        return (*node._asked_pose, z_m) if node.released and node._hand_alive else (x_m, y_m, z_m)

    return going(change)


def sinks_released() -> VirtualNode:
    def change(node: Telemanipulator, hand: Any, x_m: float, y_m: float, z_m: Any) -> tuple[float, float, Any]:
        lower = np.minimum(z_m, node._asked_z) if node.released and node._heights_alive else z_m
        return x_m, y_m, lower

    return going(change)


def does_not_rise() -> VirtualNode:
    def change(node: Telemanipulator, hand: Any, x_m: float, y_m: float, z_m: Any) -> tuple[float, float, Any]:
        return x_m, y_m, (hand.z_m if node.released else z_m)

    return going(change)


def slow_to_release() -> VirtualNode:
    return hanging_on(telemanipulator(), "TelemanipulatorState", "released", 0.0)


def hand_runs_on() -> VirtualNode:
    def change(node: Telemanipulator, hand: Any, x_m: float, y_m: float, z_m: Any) -> tuple[float, float, Any]:
        alone = not (node.released or node._hand_alive)
        return (hand.x_m + creep_m(0.0006) if alone else x_m), y_m, z_m

    return going(change)


def reads_at_100_hz() -> VirtualNode:
    end = telemanipulator()
    turns, kept = 0, None

    def measure(below: Callable[..., None], x_m: float, y_m: float, z_m: Any, force_n: Any) -> None:
        nonlocal turns, kept
        kept = z_m.copy() if turns % 5 == 0 else kept
        turns += 1
        below(x_m, y_m, kept, force_n)

    over(end.node, "measure", measure)
    return end


EXO, ROBOT = NodeName.EXOSKELETON, NodeName.TELEMANIPULATOR
WRONG_NODES: list[tuple[str, NodeName, Callable[[], VirtualNode]]] = [
    ("N1", EXO, babbles),
    ("N1", EXO, errors),
    ("N2", EXO, unnamed_bits),
    ("N2", EXO, extended),
    ("N3", EXO, repeats_a_counter),
    ("N3", EXO, counts_to_14),
    ("N4", EXO, wrong_crc_at_times),
    ("N5", EXO, at_250_hz),
    ("N6", EXO, enabled_at_power_up),
    ("N6", EXO, pushes_at_power_up),
    ("N6", ROBOT, not_released_at_power_up),
    ("N7", EXO, drops_out),
    ("N8", EXO, slow_to_time_out),
    ("N8", ROBOT, slow_to_stop_its_hand),
    ("N9", EXO, any_crc),
    ("N10", EXO, crc_of_any_identifier),
    ("N11", EXO, any_counter),
    ("N12", EXO, no_gaps),
    ("N13", EXO, any_length),
    ("E1", EXO, crossed_fingers),
    ("E2", EXO, enabled_or_not),
    ("E3", EXO, lets_go_slowly),
    ("M1", ROBOT, creeps),
    ("M2", ROBOT, goes_half_way),
    ("M3", ROBOT, hand_follows_released),
    ("M4", ROBOT, sinks_released),
    ("M5", ROBOT, does_not_rise),
    ("M6", ROBOT, slow_to_release),
    ("M7", ROBOT, hand_runs_on),
    ("M8", ROBOT, reads_at_100_hz),
]
