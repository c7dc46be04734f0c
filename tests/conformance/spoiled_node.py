"""Ways to make one thing wrong in an emulated CAN node."""

from collections.abc import Callable

import can

from common.can_frames import frame_crc, packing
from sim_sensors.exoskeleton import Exoskeleton
from sim_sensors.telemanipulator import Telemanipulator
from teletaction.conformance.node_talk import NodeName
from tests.conformance.spoiled_module import over
from tests.conformance.virtual_ends import VirtualNode

WrongNodes = list[tuple[str, NodeName, Callable[[], VirtualNode]]]
"""Number of a duty, the node, and one that breaks it."""
EXO, ROBOT = NodeName.EXOSKELETON, NodeName.TELEMANIPULATOR
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
