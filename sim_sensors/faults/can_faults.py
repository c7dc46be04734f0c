"""Faults of the CAN nodes and their bus, with the commands of `sim_sensors.faults.faults`."""

import math
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any, TypeVar

from common.fingers import FINGERS
from sim_sensors.devices.breakable_parts import Encoder, ForceSensor, Transmitter
from sim_sensors.devices.can_node import CanNode
from sim_sensors.devices.exoskeleton import Exoskeleton
from sim_sensors.devices.telemanipulator import Telemanipulator
from sim_sensors.faults.faults import Fault, switch
from sim_sensors.ports.intruder import Intruder
from sim_sensors.serving import Finger

MOST_N = 10.0
"""Largest force of a stuck drive of the exoskeleton, N."""
T = TypeVar("T", Encoder, ForceSensor)


def encoder_faults(encoders: Mapping[Finger, Encoder]) -> dict[str, Fault[Any]]:
    """Return the faults of the fingers' encoders."""
    return {"encoder": _of_fingers(encoders, "glitch", "stuck")}


def force_faults(sensors: Mapping[Finger, ForceSensor]) -> dict[str, Fault[Any]]:
    """Return the faults of the fingertips' force sensors."""
    return {"force": _of_fingers(sensors, "frozen", "biased")}


def transmitter_faults(node: CanNode) -> dict[str, Fault[Any]]:
    """Return the fault of a node's transmitter: a share of its frames is damaged."""
    return {"damage": Fault("can counter|crc SHARE", {"can": node.transmitter}, _damage)}


def exoskeleton_faults(exoskeleton: Exoskeleton, fingers: Sequence[str]) -> dict[str, Fault[Any]]:
    """Return the fault of the exoskeleton's drives: one applies a fixed force in place of the commanded one."""
    places = {str(finger): FINGERS.index(finger) for finger in fingers}
    return {"push": Fault("FINGER NEWTON", places, partial(_push, exoskeleton.stuck_n))}


def telemanipulator_faults(robot: Telemanipulator) -> dict[str, Fault[Any]]:
    """Return the fault of the telemanipulator's safe state: it ignores a commanded release."""
    return {"cling": Fault("", {"": robot}, partial(switch, "clings"))}


def intruder_faults(intruder: Intruder) -> dict[str, Fault[Any]]:
    """Return the fault of a bus: a second sender transmits the site's frames."""
    return {"intrude": Fault("", {"": intruder}, partial(switch, "active"))}


def _push(stuck_n: dict[int, float], place: int, text: str) -> Callable[[], object]:
    try:
        force_n = float(text)
    except ValueError:
        force_n = math.nan
    if not 0.0 <= force_n <= MOST_N:
        raise ValueError(f"{text!r} is not a force of 0 to {MOST_N:g} N")
    stuck_n[place] = force_n
    return partial(stuck_n.pop, place)


def _of_fingers(parts: Mapping[Finger, T], *words: str) -> Fault[T]:
    def begin(part: T, text: str) -> Callable[[], object]:
        if text not in words:
            raise ValueError(f"{text!r} is neither {' nor '.join(words)}")
        setattr(part, "fault", text)  # noqa: B010  each part has its own fault names
        return partial(setattr, part, "fault", None)

    return Fault(f"FINGER {'|'.join(words)}", {str(finger): part for finger, part in parts.items()}, begin)


def _damage(transmitter: Transmitter, text: str) -> Callable[[], object]:
    what, _, number = text.partition(" ")
    try:
        share = float(number)
    except ValueError:
        share = math.nan
    if not 0.0 < share <= 1.0:
        raise ValueError(f"{number!r} is not a share above 0 and at most 1")
    match what:
        case "counter" | "crc":
            transmitter.damage = (what, share)
        case _:
            raise ValueError(f"{what!r} is neither counter nor crc")
    return partial(setattr, transmitter, "damage", None)
