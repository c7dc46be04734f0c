"""Ways to make one thing wrong in an emulated CAN node, and to enter it under the duty that it breaks."""

from collections.abc import Callable
from functools import wraps
from typing import Any

import can

from common.buses.can_frames import frame_crc, packing
from sim_sensors.devices.exoskeleton import Exoskeleton
from sim_sensors.devices.telemanipulator import Telemanipulator
from tests.unit.teletaction.conformance.spoiled_module import over
from tests.unit.teletaction.conformance.virtual_ends import VirtualNode

WRONG_NODES: list[tuple[str, Callable[[], VirtualNode]]] = []
"""Number of a duty, and a node that breaks it."""
Kind = type[Exoskeleton] | type[Telemanipulator]
Entered = Callable[[Callable[..., Any]], Callable[[], VirtualNode]]
Going = Callable[[Any, Any, float, float, Any], tuple[float, float, Any]]
"""Where a node goes instead: it is given the node, its world, and where it should go."""
POSE_ID = 0x100
HELD_FRAMES = 6
"""State frames, 60 ms."""


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


def changed_states(end: VirtualNode, change: Callable[[dict[str, float]], dict[str, float]]) -> VirtualNode:
    """Change the values of the state frames."""
    layout = packing(f"{type(end.node).__name__}State")

    def remake(frame: can.Message, _: int) -> list[can.Message]:
        values, counter = layout.unpack(bytes(frame.data))
        return [remade(frame, layout.pack(change(values), counter))]

    return spoiled(end, layout.frame_id, remake)


def hanging_on(end: VirtualNode, signal: str, value: float) -> None:
    """A state that says a signal for some frames longer than it is so."""
    left = 0

    def hang(values: dict[str, float]) -> dict[str, float]:
        nonlocal left
        left = HELD_FRAMES if values[signal] == value else left - 1
        return {**values, signal: value} if left > 0 else values

    changed_states(end, hang)


def going(change: Going) -> VirtualNode:
    """A telemanipulator that goes elsewhere."""
    end = VirtualNode(Telemanipulator())
    over(end.node, "setpoint_m", lambda below, now_s: change(end.node, end.hand, *below(now_s)))
    return end


def _entered(number: str, name: Callable[..., Any], make: Callable[[], VirtualNode]) -> Callable[[], VirtualNode]:
    made = wraps(name)(make)
    WRONG_NODES.append((number, made))
    return made


def wrong(number: str, kind: Kind) -> Entered:
    """Enter a node that breaks a duty; the function makes it wrong, given a sound one on a bus."""

    def enter(spoil: Callable[[VirtualNode], None]) -> Callable[[], VirtualNode]:
        def made() -> VirtualNode:
            end = VirtualNode(kind())
            spoil(end)
            return end

        return _entered(number, spoil, made)

    return enter


def wrong_frames(number: str) -> Entered:
    """The function makes of a frame with the exoskeleton's pose, and of the frame's number, what is sent instead."""
    return lambda change: _entered(number, change, lambda: spoiled(VirtualNode(Exoskeleton()), POSE_ID, change))


def wrong_states(number: str, kind: Kind) -> Entered:
    """The function makes of a node and the values of its state what is sent instead."""

    def enter(change: Callable[[Any, dict[str, float]], dict[str, float]]) -> Callable[[], VirtualNode]:
        def made() -> VirtualNode:
            end = VirtualNode(kind())
            return changed_states(end, lambda values: change(end, values))

        return _entered(number, change, made)

    return enter


def wrong_hearing(number: str) -> Entered:
    """The function stands over what the exoskeleton hears: it is given the node, that method, and a frame."""

    def enter(do: Callable[..., None]) -> Callable[[], VirtualNode]:
        def made() -> VirtualNode:
            end = VirtualNode(Exoskeleton())
            over(end.node, "feed", lambda below, *frame: do(end.node, below, *frame))
            return end

        return _entered(number, do, made)

    return enter


def wrong_way(number: str) -> Entered:
    """The function says where a telemanipulator goes."""
    return lambda change: _entered(number, change, lambda: going(change))
