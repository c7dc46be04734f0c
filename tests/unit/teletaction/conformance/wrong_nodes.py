"""Emulated CAN nodes with one thing wrong each, under the number of the duty that they break."""

from collections.abc import Callable, Sequence
from typing import Any

import can
import numpy as np

from common.buses.can_frames import frame_crc
from common.fingers import FINGERS
from sim_sensors.devices.exoskeleton import Exoskeleton
from sim_sensors.devices.telemanipulator import Telemanipulator
from tests.unit.teletaction.conformance.spoiled_module import over
from tests.unit.teletaction.conformance.spoiled_node import (
    HELD_FRAMES,
    changed_states,
    hanging_on,
    remade,
    with_counter,
    wrong,
    wrong_frames,
    wrong_hearing,
    wrong_states,
    wrong_way,
)
from tests.unit.teletaction.conformance.virtual_ends import STEP_S

Values = dict[str, float]


@wrong_frames("N1")
def babbles(frame: can.Message, count: int) -> list[can.Message]:
    other = can.Message(arbitration_id=0x555, data=bytes(8), is_extended_id=False)
    return [frame, other] if count % 100 == 0 else [frame]


@wrong_frames("N1")
def errors(frame: can.Message, count: int) -> list[can.Message]:
    error = can.Message(arbitration_id=0x004, data=bytes(8), is_error_frame=True)
    return [frame, error] if count % 400 == 0 else [frame]


@wrong_frames("N2")
def unnamed_bits(frame: can.Message, _: int) -> list[can.Message]:
    data = bytearray(frame.data)
    data[5] |= 0x10
    return [remade(frame, bytes(data))]


@wrong_frames("N2")
def extended(frame: can.Message, count: int) -> list[can.Message]:
    frame.is_extended_id = count % 100 == 0
    return [frame]


@wrong_frames("N3")
def repeats_a_counter(frame: can.Message, count: int) -> list[can.Message]:
    return [with_counter(frame, count - count // 50)]


@wrong_frames("N3")
def counts_to_14(frame: can.Message, count: int) -> list[can.Message]:
    return [with_counter(frame, count % 15)]


@wrong_frames("N4")
def wrong_crc_at_times(frame: can.Message, count: int) -> list[can.Message]:
    if count % 100 == 0:
        frame.data[7] ^= 0xFF
    return [frame]


@wrong_frames("N5")
def at_250_hz(frame: can.Message, count: int) -> list[can.Message]:
    return [] if count % 2 else [with_counter(frame, count // 2)]


@wrong_states("N6", Exoskeleton)
def enabled_at_power_up(end: Any, values: Values) -> Values:
    return values if end.node._heard_s else {**values, "enabled": 1.0}


@wrong_states("N6", Exoskeleton)
def pushes_at_power_up(end: Any, values: Values) -> Values:
    return values if end.node._heard_s else {**values, "little": 0.01}


@wrong_states("N6", Telemanipulator)
def not_released_at_power_up(end: Any, values: Values) -> Values:
    return values if end.node._heard_s else {**values, "released": 0.0}


@wrong("N7", Exoskeleton)
def drops_out(end: Any) -> None:
    enabled = 0

    def drop(values: Values) -> Values:
        nonlocal enabled
        enabled = enabled + 1 if values["enabled"] else 0
        return {**values, "enabled": 0.0} if enabled % 25 == 24 else values

    changed_states(end, drop)


@wrong("N8", Exoskeleton)
def slow_to_time_out(end: Any) -> None:
    hanging_on(end, "enabled", 1.0)


@wrong("N8", Telemanipulator)
def slow_to_stop_its_hand(end: Any) -> None:
    hanging_on(end, "hand_alive", 1.0)


def _with_right_crc(frame_id: int, data: bytes) -> bytes:
    return data[:7] + bytes((frame_crc(frame_id, data),))


def _of_another(frame_id: int, data: bytes) -> bool:
    return len(data) == 8 and data[7] == frame_crc(frame_id + 1, data)


@wrong_hearing("N9")
def any_crc(node: Any, below: Callable[..., None], frame_id: int, data: bytes, now_s: float) -> None:
    kept = _of_another(frame_id, data) or len(data) < 8
    below(frame_id, data if kept else _with_right_crc(frame_id, data), now_s)


@wrong_hearing("N10")
def crc_of_any_identifier(node: Any, below: Callable[..., None], frame_id: int, data: bytes, now_s: float) -> None:
    below(frame_id, _with_right_crc(frame_id, data) if _of_another(frame_id, data) else data, now_s)


@wrong_hearing("N11")
def any_counter(node: Any, below: Callable[..., None], frame_id: int, data: bytes, now_s: float) -> None:
    node._receivers[frame_id].begin()
    below(frame_id, data, now_s)


@wrong("N12", Exoskeleton)
def no_gaps(end: Any) -> None:
    seen: int | None = None

    def feed(below: Callable[..., None], frame_id: int, data: bytes, now_s: float) -> None:
        nonlocal seen
        counter = data[6] >> 4
        follows = seen is None or (counter - seen) & 0xF in (0, 1)
        seen = counter
        if follows:
            below(frame_id, data, now_s)

    over(end.node, "feed", feed)


@wrong_hearing("N13")
def any_length(node: Any, below: Callable[..., None], frame_id: int, data: bytes, now_s: float) -> None:
    below(frame_id, data if len(data) == 8 else _with_right_crc(frame_id, data), now_s)


@wrong_states("E1", Exoskeleton)
def crossed_fingers(end: Any, values: Values) -> Values:
    return {**values, "index": values["ring"], "ring": values["index"]}


@wrong("E2", Exoskeleton)
def enabled_or_not(end: Any) -> None:
    def obey(below: Callable[..., None], name: str, values: Sequence[float], now_s: float) -> None:
        below(name, values, now_s)
        end.node._force_n = np.array(values[: len(FINGERS)])

    over(end.node, "_obey", obey)


@wrong("E3", Exoskeleton)
def lets_go_slowly(end: Any) -> None:
    left = 0

    def linger(values: Values) -> Values:
        nonlocal left
        left = HELD_FRAMES if values["thumb"] > 0.0 else left - 1
        return {**values, "thumb": max(values["thumb"], 0.02)} if left > 0 else values

    changed_states(end, linger)


@wrong("E4", Exoskeleton)
def falls_late(end: Any) -> None:
    """A force that is commanded to be less is so only after 250 ms."""
    before: list[Values] = []

    def hold(values: Values) -> Values:
        before.append(values)
        held = {finger: max(each[finger] for each in before[-25:]) for finger in FINGERS if values[finger] > 0.0}
        return {**values, **held}

    changed_states(end, hold)


@wrong_states("E5", Exoskeleton)
def enabled_by_any_frame(end: Any, values: Values) -> Values:
    return {**values, "enabled": float(end.node.alive("FingerForces", end.now()))}


def _creep_m(speed_m_s: float) -> float:
    """How far ahead the hand's servo must be set so that it creeps."""
    return speed_m_s * STEP_S / 0.2


@wrong_way("M1")
def creeps(node: Any, hand: Any, x_m: float, y_m: float, z_m: Any) -> tuple[float, float, Any]:
    silent = not (node._hand_alive or node._heights_alive)
    return (hand.x_m + _creep_m(0.0002) if silent else x_m), y_m, z_m


@wrong_way("M2")
def goes_half_way(node: Any, hand: Any, x_m: float, y_m: float, z_m: Any) -> tuple[float, float, Any]:
    return 0.5 * x_m, y_m, z_m


@wrong_way("M3")
def hand_follows_released(node: Any, hand: Any, x_m: float, y_m: float, z_m: Any) -> tuple[float, float, Any]:
    return (*node._asked_pose, z_m) if node.released and node._hand_alive else (x_m, y_m, z_m)


@wrong_way("M4")
def sinks_released(node: Any, hand: Any, x_m: float, y_m: float, z_m: Any) -> tuple[float, float, Any]:
    return x_m, y_m, np.minimum(z_m, node._asked_z) if node.released and node._heights_alive else z_m


@wrong_way("M5")
def does_not_rise(node: Any, hand: Any, x_m: float, y_m: float, z_m: Any) -> tuple[float, float, Any]:
    return x_m, y_m, hand.z_m if node.released else z_m


@wrong("M6", Telemanipulator)
def slow_to_release(end: Any) -> None:
    hanging_on(end, "released", 0.0)


@wrong_way("M7")
def hand_runs_on(node: Any, hand: Any, x_m: float, y_m: float, z_m: Any) -> tuple[float, float, Any]:
    alone = not (node.released or node._hand_alive)
    return (hand.x_m + _creep_m(0.0006) if alone else x_m), y_m, z_m


@wrong("M8", Telemanipulator)
def reads_at_100_hz(end: Any) -> None:
    turns, kept = 0, None

    def measure(below: Callable[..., None], x_m: float, y_m: float, z_m: Any, force_n: Any) -> None:
        nonlocal turns, kept
        kept = z_m.copy() if turns % 5 == 0 else kept
        turns += 1
        below(x_m, y_m, kept, force_n)

    over(end.node, "measure", measure)


@wrong_states("M9", Telemanipulator)
def released_by_silence_alone(end: Any, values: Values) -> Values:
    return {**values, "released": 1.0 - values["heights_alive"]}
