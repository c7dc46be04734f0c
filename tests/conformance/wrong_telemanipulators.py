"""Emulated telemanipulators with one thing wrong each, by the number of the duty that they break."""

from collections.abc import Callable
from typing import Any

import numpy as np

from sim_sensors.telemanipulator import Telemanipulator
from tests.conformance.spoiled_module import over
from tests.conformance.spoiled_node import (
    ROBOT,
    WrongNodes,
    changed_states,
    hanging_on,
    telemanipulator,
)
from tests.conformance.virtual_ends import STEP_S, VirtualNode


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


def released_by_silence_alone() -> VirtualNode:
    end = telemanipulator()

    def say(values: dict[str, float], _: int) -> dict[str, float]:
        return {**values, "released": 1.0 - values["heights_alive"]}

    return changed_states(end, "TelemanipulatorState", say)


WRONG_TELEMANIPULATORS: WrongNodes = [
    ("M1", ROBOT, creeps),
    ("M2", ROBOT, goes_half_way),
    ("M3", ROBOT, hand_follows_released),
    ("M4", ROBOT, sinks_released),
    ("M5", ROBOT, does_not_rise),
    ("M6", ROBOT, slow_to_release),
    ("M7", ROBOT, hand_runs_on),
    ("M8", ROBOT, reads_at_100_hz),
    ("M9", ROBOT, released_by_silence_alone),
]
