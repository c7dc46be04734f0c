"""Define the kinds of faults of the simulated devices, for the commands of `sim_sensors.faults.faults`."""

import math
import re
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, Literal, TypeVar

import numpy as np
from numpy.typing import NDArray

from common.buses.serial_messages import DRIVE_FULL, MOTOR_MAX_MV
from common.buses.serial_port import BAUD
from common.fingers import FINGERS
from sim_sensors.devices.breakable_parts import DRIFT_M_S, Babble, Encoder, ForceSensor, Hang, Piezo, Servos, Thermistor
from sim_sensors.devices.can_node import CanNode
from sim_sensors.devices.exoskeleton import Exoskeleton
from sim_sensors.devices.patient_switch import GONE, PatientSwitch
from sim_sensors.devices.plate_module import PlateModule
from sim_sensors.devices.tacttip import TactTip
from sim_sensors.devices.telemanipulator import Telemanipulator
from sim_sensors.faults.faults import End, Fault
from sim_sensors.physics.finger_plate import FingerPlates
from sim_sensors.physics.remote_world import RemoteWorld
from sim_sensors.physics.thermistor_contacts import ThermistorContacts
from sim_sensors.ports.camera_server import CameraServer
from sim_sensors.ports.intruder import Intruder
from sim_sensors.ports.node_bus import NodeBus
from sim_sensors.ports.serial_server import SerialServer
from sim_sensors.serving import Finger

LONGEST_HANG_S = 60.0
"""Longest hang of a process, s."""
MOST_N = 10.0
"""Largest force of a stuck drive of the exoskeleton, N."""
FARTHEST_MM = 50.0
"""Longest movement of the patient along one axis, mm."""
MOST_PERMILLE = 65535
"""Largest number that a report has for the pain slider; 1000 is its end."""

T = TypeVar("T")
Kinds = dict[str, Fault[Any]]


def device_faults(
    serial: Mapping[str, SerialServer],
    bus: NodeBus,
    node: CanNode,
    drives: Mapping[Finger, PlateModule],
    thermistors: Mapping[Finger, Thermistor],
    contacts: ThermistorContacts,
    encoders: Mapping[Finger, Encoder],
    intruder: Intruder,
    hang: Hang,
) -> Kinds:
    """Return the faults that the devices of both sites can have, by name.

    Args:
        serial: serial lines by device.
        bus: the CAN gateway.
        node: the CAN node; a share of its frames can be damaged.
        drives: modules whose Peltier drive can be stuck, by finger.
        thermistors: temperature sensors by finger.
        contacts: thermal contacts of all five of them, which can loosen.
        encoders: encoders of the node by finger.
        intruder: second sender on the bus.
        hang: pause of the whole process.
    """
    lines: dict[str, SerialServer | NodeBus] = {**serial, "can": bus}
    places = {str(finger): FINGERS.index(finger) for finger in thermistors}
    return {
        "unplug": Fault("DEVICE", lines, _unplug),
        "silence": Fault("DEVICE", lines, _setting("silent", _no_argument, False)),
        "deafen": Fault("DEVICE", lines, _setting("deaf", _no_argument, False)),
        "babble": Fault("DEVICE", serial, _setting("babble", _babble)),
        "bus_off": Fault("", {"": bus}, _turn_off),
        "stuck": Fault("FINGER PERMILLE", _by_finger(drives), _setting("stuck_permille", _permille)),
        "thermistor": _of_parts(thermistors, "open", "short", "frozen"),
        "loosen": Fault("FINGER CONTACT_PER_S", places, partial(_loosen, contacts.lost_per_s)),
        "hang": Fault("SECONDS", {"": hang}, _hang),
        "damage": Fault("can counter|crc SHARE", {"can": node.transmitter}, _setting("damage", _damage)),
        "encoder": _of_parts(encoders, "glitch", "stuck"),
        "intrude": Fault("", {"": intruder}, _setting("active", _no_argument, False)),
    }


def remote_faults(
    robot: Telemanipulator,
    servos: Servos,
    force_sensors: Mapping[Finger, ForceSensor],
    piezos: Mapping[Finger, Piezo],
    world: RemoteWorld,
    patient_switch: PatientSwitch | None = None,
    camera: CameraServer | None = None,
) -> Kinds:
    """Return the faults of the remote devices alone.

    Args:
        robot: the telemanipulator; it can ignore a commanded release.
        servos: its drives; one or all can ignore the set-points.
        force_sensors: its force sensors by finger.
        piezos: piezo elements of the texture sensors by finger.
        world: the patient in it can move.
        patient_switch: the patient's stop switch; the patient can press it, it can repeat its last report, and its
            slider can be stuck, out of range, or gone.
        camera: the camera; it can stay connected and send nothing.
    """
    cameras = {} if camera is None else {"": camera}
    switch = {} if patient_switch is None else {"": patient_switch}
    targets: dict[str, tuple[Servos, int | None]] = {name: (servos, index) for index, name in enumerate(FINGERS)}
    return {
        "cling": Fault("", {"": robot}, _setting("clings", _no_argument, False)),
        "disobey": Fault("[FINGER|drift]", {**targets, "": (servos, None)}, _disobey),
        "force": _of_parts(force_sensors, "frozen", "biased"),
        "freeze": Fault("", cameras, _setting("frozen", _no_argument, False)),
        "press": Fault("", switch, _setting("pressed", _no_argument, False)),
        "repeat": Fault("", switch, _setting("hung", _no_argument, False)),
        "shift": Fault("X Y Z in mm", {"": world}, _shift),
        "slider": Fault("PERMILLE|gone", switch, _setting("slider", _slider)),
        "piezo": _of_parts(piezos, "saturated", "clipped", "cut", "loose"),
    }


def operator_faults(exoskeleton: Exoskeleton, modules: Mapping[Finger, TactTip], plates: FingerPlates) -> Kinds:
    """Return the faults of the operator's devices alone.

    Args:
        exoskeleton: its drives can apply a fixed force in place of the commanded one.
        modules: TactTips by finger; the motor's driver can apply a fixed voltage in place of the commanded one.
        plates: plates of the TactTips; they can lack cooling water, their Peltiers can be wired in reverse.
    """
    places = {str(finger): FINGERS.index(finger) for finger in modules}
    return {
        "push": Fault("FINGER NEWTON", places, partial(_push, exoskeleton.stuck_n)),
        "water": Fault("FINGER", places, partial(_mark, plates.dry)),
        "reverse": Fault("FINGER", places, partial(_mark, plates.reversed)),
        "motor": Fault("FINGER MILLIVOLT", _by_finger(modules), _setting("stuck_mv", _millivolt)),
    }


def _by_finger(parts: Mapping[Finger, T]) -> dict[str, T]:
    return {str(finger): part for finger, part in parts.items()}


def _of_parts(parts: Mapping[Finger, T], *words: str) -> Fault[T]:
    """Return a fault whose words are the values of a part's `fault`."""

    def word(text: str) -> str:
        if text not in words:
            raise ValueError(f"{text!r} is neither {', '.join(words[:-1])} nor {words[-1]}")
        return text

    return Fault(f"FINGER {'|'.join(words)}", _by_finger(parts), _setting("fault", word))


def _setting(attribute: str, parse: Callable[[str], object], sound: object = None) -> Callable[[object, str], End]:
    """Return the begin of a fault that sets an attribute to the parsed argument, and to `sound` at its end."""

    def begin(target: object, text: str) -> End:
        setattr(target, attribute, parse(text))
        return partial(setattr, target, attribute, sound)

    return begin


def _no_argument(text: str) -> Literal[True]:
    if text:
        raise ValueError(f"unexpected argument {text!r}")
    return True


def _number(text: str) -> float:
    try:
        return float(text)
    except ValueError:
        return math.nan


def _babble(text: str) -> Babble:
    _no_argument(text)
    return Babble(BAUD)


def _whole(text: str, unit: str, low: int, high: int) -> int:
    if not re.fullmatch("-?[0-9]+", text) or not low <= int(text) <= high:
        raise ValueError(f"{text!r} is not a whole number of {unit}, {low} to {high}")
    return int(text)


def _permille(text: str) -> int:
    return _whole(text, "thousandths", -DRIVE_FULL, DRIVE_FULL)


def _slider(text: str) -> int:
    return GONE if text == "gone" else _whole(text, "thousandths", 0, MOST_PERMILLE)


def _millivolt(text: str) -> int:
    return _whole(text, "millivolts", 0, MOTOR_MAX_MV)


def _damage(text: str) -> tuple[str, float]:
    kind, _, number = text.partition(" ")
    share = _number(number)
    if not 0.0 < share <= 1.0:
        raise ValueError(f"{number!r} is not a share above 0 and at most 1")
    if kind not in ("counter", "crc"):
        raise ValueError(f"{kind!r} is neither counter nor crc")
    return kind, share


def _unplug(line: SerialServer | NodeBus, text: str) -> End:
    _no_argument(text)
    line.unplug()
    return line.plug


def _turn_off(bus: NodeBus, text: str) -> End:
    _no_argument(text)
    bus.turn_off()
    return bus.turn_on


def _push(stuck_n: dict[int, float], place: int, text: str) -> End:
    force_n = _number(text)
    if not 0.0 <= force_n <= MOST_N:
        raise ValueError(f"{text!r} is not a force of 0 to {MOST_N:g} N")
    stuck_n[place] = force_n
    return partial(stuck_n.pop, place)


def _mark(broken: NDArray[np.bool_], place: int, text: str) -> End:
    broken[place] = _no_argument(text)
    return partial(broken.__setitem__, place, False)


def _loosen(lost_per_s: NDArray[np.float64], place: int, text: str) -> End:
    per_s = _number(text)
    if not 0.0 < per_s <= 1.0:
        raise ValueError(f"{text!r} is not a share per second above 0 and at most 1")
    lost_per_s[place] = per_s
    return partial(lost_per_s.__setitem__, place, 0.0)


def _disobey(target: tuple[Servos, int | None], text: str) -> End:
    servos, finger = target
    if finger is not None:
        _no_argument(text)
        servos.jammed.add(finger)
        return partial(servos.jammed.discard, finger)
    if text not in ("", "drift"):
        raise ValueError(f"{text!r} is not drift")
    servos.disobey(DRIFT_M_S if text else 0.0)
    return servos.mend


def _shift(world: RemoteWorld, text: str) -> End:
    numbers = [_number(word) for word in text.split()]
    if len(numbers) != 3 or not all(abs(number) <= FARTHEST_MM for number in numbers):
        raise ValueError(f"{text!r} are not three numbers of millimetres, each within {FARTHEST_MM:g}")
    world.shift_m = (1e-3 * numbers[0], 1e-3 * numbers[1], 1e-3 * numbers[2])
    return partial(setattr, world, "shift_m", (0.0, 0.0, 0.0))


def _hang(hang: Hang, text: str) -> None:
    seconds = _number(text)
    if not 0.0 < seconds <= LONGEST_HANG_S:
        raise ValueError(f"{text!r} is not a number of seconds above 0 and at most {LONGEST_HANG_S:g}")
    hang.begin(seconds)
