"""Inject faults into the simulated devices with text commands.

FAULT TARGET [VALUE]      begins a fault, as in `thermistor index open`
mend FAULT TARGET         ends it; `plug DEVICE` is short for `mend unplug DEVICE`
mend                      ends all faults
"""

import logging
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Generic, Protocol, TypeVar

import numpy as np
from numpy.typing import NDArray

from common.buses.serial_messages import DRIVE_FULL, MOTOR_MAX_MV
from common.buses.serial_port import BAUD
from common.fingers import FINGERS
from sim_sensors.devices.breakable_parts import DRIFT_M_S, Babble, Hang, Piezo, Servos, Thermistor
from sim_sensors.devices.tacttip import TactTip
from sim_sensors.physics.finger_plate import FingerPlates
from sim_sensors.ports.node_bus import NodeBus
from sim_sensors.ports.serial_server import SerialServer
from sim_sensors.serving import Finger

log = logging.getLogger(__name__)

LONGEST_HANG_S = 60.0
"""Longest hang of a process, s."""

T = TypeVar("T")
End = Callable[[], object]


class Drive(Protocol):
    """Module whose drive can be stuck: `stuck_permille`, -1000..1000, overrides the command; None while it is sound."""

    stuck_permille: int | None


@dataclass(frozen=True, slots=True)
class Fault(Generic[T]):
    """One kind of fault.

    Attributes:
        usage: arguments of the command, as help text.
        targets: possible targets by name; an empty name stands for the only target.
        begin: breaks a target, given the text behind its name. It returns the function that mends the target,
            None if the fault ends by itself. It raises ValueError for an invalid text, before anything is broken.
    """

    usage: str
    targets: Mapping[str, T]
    begin: Callable[[T, str], End | None]

    def aim(self, words: str) -> tuple[str, str]:
        """Split a command's arguments into the target's name and the text behind it.

        Raises:
            ValueError: no target of that name.
        """
        for name in self.targets:
            if not name or words == name or words.startswith(f"{name} "):
                return name, words[len(name) :].strip()
        raise ValueError(f"unknown target {words!r}; known: {', '.join(self.targets)}")


class Faults:
    """Begin and end faults, and list those in force."""

    def __init__(self, kinds: Mapping[str, Fault[Any]]) -> None:
        self._kinds = kinds
        self._ends: dict[str, End] = {}

    @property
    def in_force(self) -> list[str]:
        """Name and target of each fault in force."""
        return list(self._ends)

    def apply(self, line: str) -> str:
        """Execute one command; return the faults in force after it, separated by commas.

        Raises:
            ValueError: the command is invalid; nothing has changed.
        """
        name, _, words = " ".join(line.split()).partition(" ")
        if name == "mend":
            self._mend(words)
        elif name == "plug":
            self._mend(f"unplug {words}")
        else:
            self._begin(name, words)
        log.info("%s", line)
        return ", ".join(self._ends)

    def _begin(self, name: str, words: str) -> None:
        kind = self._kinds.get(name)
        if kind is None:
            usages = [f"{each} {known.usage}".strip() for each, known in self._kinds.items()]
            raise ValueError(f"no fault {name!r}; use {', '.join(usages)}, plug DEVICE, or mend [FAULT TARGET]")
        try:
            target, text = kind.aim(words)
            end = kind.begin(kind.targets[target], text)
        except ValueError as error:
            raise ValueError(f"{name} {kind.usage}: {error}") from None
        if end is not None:
            self._ends[f"{name} {target}".strip()] = end

    def _mend(self, words: str) -> None:
        if words and words not in self._ends:
            raise ValueError(f"{words!r} is not in force; in force: {', '.join(self._ends) or 'nothing'}")
        for name in [words] if words else list(self._ends):
            self._ends[name]()
            del self._ends[name]


def device_faults(
    serial: Mapping[str, SerialServer],
    bus: NodeBus,
    drives: Mapping[Finger, Drive],
    thermistors: Mapping[Finger, Thermistor],
    hang: Hang,
) -> dict[str, Fault[Any]]:
    """Return the faults that the devices of both sites can have, by name.

    Args:
        serial: serial lines by device.
        bus: the CAN gateway.
        drives: modules whose Peltier drive can be stuck, by finger.
        thermistors: temperature sensors by finger.
        hang: pause of the whole process.
    """
    lines: dict[str, SerialServer | NodeBus] = {**serial, "can": bus}
    return {
        "unplug": Fault("DEVICE", lines, _unplug),
        "silence": Fault("DEVICE", lines, partial(switch, "silent")),
        "deafen": Fault("DEVICE", lines, partial(switch, "deaf")),
        "babble": Fault("DEVICE", serial, _babble),
        "bus_off": Fault("", {"": bus}, _turn_off),
        "stuck": Fault("FINGER PERMILLE", {str(finger): each for finger, each in drives.items()}, _stick),
        "thermistor": Fault(
            "FINGER open|short|frozen", {str(finger): each for finger, each in thermistors.items()}, _break_thermistor
        ),
        "hang": Fault("SECONDS", {"": hang}, _hang),
    }


def motor_faults(modules: Mapping[Finger, TactTip]) -> dict[str, Fault[Any]]:
    """Return the fault of the vibration motors' drivers: one applies a fixed voltage in place of the commanded one."""
    return {"motor": Fault("FINGER MILLIVOLT", {str(finger): each for finger, each in modules.items()}, _stick_motor)}


def servo_faults(servos: Servos) -> dict[str, Fault[Any]]:
    """Return the faults of the telemanipulator's drives, of one finger or of all."""
    targets: dict[str, tuple[Servos, int | None]] = {name: (servos, index) for index, name in enumerate(FINGERS)}
    return {"disobey": Fault("[FINGER|drift]", {**targets, "": (servos, None)}, _disobey)}


def piezo_faults(piezos: Mapping[Finger, Piezo]) -> dict[str, Fault[Any]]:
    """Return the faults of the texture sensors' piezo elements."""
    targets = {str(finger): piezo for finger, piezo in piezos.items()}
    return {"piezo": Fault("FINGER saturated|clipped|cut|loose", targets, _break_piezo)}


def plate_faults(plates: FingerPlates, fingers: Sequence[Finger]) -> dict[str, Fault[Any]]:
    """Return the faults of the operator's plates: no cooling water, or Peltiers wired in reverse."""
    places = {str(finger): FINGERS.index(finger) for finger in fingers}
    return {
        "water": Fault("FINGER", places, partial(_mark, plates.dry)),
        "reverse": Fault("FINGER", places, partial(_mark, plates.reversed)),
    }


def _unplug(line: SerialServer | NodeBus, text: str) -> End:
    _nothing(text)
    line.unplug()
    return line.plug


def switch(attribute: str, target: object, text: str) -> End:
    """Begin a fault by setting an attribute of its target to True; return the function that ends it."""
    _nothing(text)
    setattr(target, attribute, True)
    return partial(setattr, target, attribute, False)


def _babble(line: SerialServer, text: str) -> End:
    _nothing(text)
    line.babble = Babble(BAUD)
    return partial(setattr, line, "babble", None)


def _stick(module: Drive, text: str) -> End:
    try:
        permille = int(text)
    except ValueError:
        raise ValueError(f"{text!r} is not a whole number") from None
    if not -DRIVE_FULL <= permille <= DRIVE_FULL:
        raise ValueError(f"{permille} is not within -{DRIVE_FULL}..{DRIVE_FULL}")
    module.stuck_permille = permille
    return partial(setattr, module, "stuck_permille", None)


def _stick_motor(module: TactTip, text: str) -> End:
    if not text.isascii() or not text.isdecimal() or not int(text) <= MOTOR_MAX_MV:
        raise ValueError(f"{text!r} is not a whole number of millivolts, 0 to {MOTOR_MAX_MV}")
    module.stuck_mv = int(text)
    return partial(setattr, module, "stuck_mv", None)


def _break_thermistor(thermistor: Thermistor, text: str) -> End:
    match text:
        case "open" | "short" | "frozen":
            thermistor.fault = text
            return partial(setattr, thermistor, "fault", None)
        case _:
            raise ValueError(f"{text!r} is neither open, short nor frozen")


def _break_piezo(piezo: Piezo, text: str) -> End:
    match text:
        case "saturated" | "clipped" | "cut" | "loose":
            piezo.fault = text
            return partial(setattr, piezo, "fault", None)
        case _:
            raise ValueError(f"{text!r} is neither saturated, clipped, cut nor loose")


def _mark(broken: NDArray[np.bool_], place: int, text: str) -> End:
    _nothing(text)
    broken[place] = True
    return partial(broken.__setitem__, place, False)


def _turn_off(bus: NodeBus, text: str) -> End:
    _nothing(text)
    bus.turn_off()
    return bus.turn_on


def _disobey(target: tuple[Servos, int | None], text: str) -> End:
    servos, finger = target
    if finger is not None:
        _nothing(text)
        servos.jammed.add(finger)
        return partial(servos.jammed.discard, finger)
    if text not in ("", "drift"):
        raise ValueError(f"{text!r} is not drift")
    servos.disobey(DRIFT_M_S if text else 0.0)
    return servos.mend


def _hang(hang: Hang, text: str) -> None:
    try:
        seconds = float(text)
    except ValueError:
        seconds = math.nan
    if not 0.0 < seconds <= LONGEST_HANG_S:
        raise ValueError(f"{text!r} is not a number of seconds above 0 and at most {LONGEST_HANG_S:g}")
    hang.begin(seconds)


def _nothing(text: str) -> None:
    if text:
        raise ValueError(f"unexpected argument {text!r}")
