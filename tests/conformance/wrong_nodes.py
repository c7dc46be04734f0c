"""Emulated CAN nodes with one thing wrong each, by the number of the duty that they break."""

from collections.abc import Callable

import can

from common.can_frames import frame_crc
from tests.conformance.spoiled_node import (
    EXO,
    POSE_ID,
    ROBOT,
    WrongNodes,
    changed_states,
    exoskeleton,
    hanging_on,
    heard,
    remade,
    spoiled,
    telemanipulator,
    with_counter,
)
from tests.conformance.virtual_ends import VirtualNode


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


WRONG_NODES: WrongNodes = [
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
]
