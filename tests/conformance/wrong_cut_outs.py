"""Emulated modules whose temperature limit is wrong in one thing, by the number of the duty that they break."""

import struct
from collections.abc import Callable

from common.serial_messages import DeviceFlag
from sim_sensors.serial_module import CutOut
from sim_sensors.tacttip import TactTip
from sim_sensors.thermal_sensor import ThermalSensor
from tests.conformance.spoiled_module import (
    BORN_S,
    FINGER,
    FLAGS,
    MOTOR,
    PELTIER,
    WrongModules,
    changed_reports,
    over,
)
from tests.conformance.virtual_ends import VirtualModule


def cuts_out_late() -> VirtualModule:
    module = ThermalSensor(FINGER, BORN_S)
    module._cut_out = CutOut(42.5)
    module._cut_out.measure(25.0)
    return VirtualModule(module)


def cuts_out_early() -> VirtualModule:
    module = TactTip(FINGER, BORN_S)

    def measure(below: Callable[[float], None], measured_c: float) -> None:
        below(measured_c + (3.0 if not module._cut_out.tripped else 0.0))

    over(module._cut_out, "measure", measure)
    return VirtualModule(module)


def cuts_out_a_report_late() -> VirtualModule:
    module = TactTip(FINGER, BORN_S)
    seen = False

    def trickle(payload: bytearray, _: int) -> None:
        nonlocal seen
        cut_out = bool(payload[FLAGS] & DeviceFlag.THERMAL_CUT_OUT)
        if cut_out and not seen:
            struct.pack_into("<h", payload, PELTIER, 300)
        seen = cut_out

    changed_reports(module, trickle)
    return VirtualModule(module)


def lets_go_while_heat_is_asked() -> VirtualModule:
    module = TactTip(FINGER, BORN_S)
    cut_out = module._cut_out
    over(cut_out, "allows", lambda below, permille: below(permille) or below(min(0, permille)))
    return VirtualModule(module)


def lets_go_to_cool() -> VirtualModule:
    module = TactTip(FINGER, BORN_S)
    over(module._cut_out, "allows", lambda below, permille: below(permille) or permille < 0)
    return VirtualModule(module)


def never_lets_go() -> VirtualModule:
    module = TactTip(FINGER, BORN_S)
    tripped = False

    def allows(below: Callable[[int], bool], permille: int) -> bool:
        nonlocal tripped
        tripped = not below(permille) or tripped
        module._cut_out.tripped = tripped
        return not tripped

    over(module._cut_out, "allows", allows)
    return VirtualModule(module)


def stops_its_motor_too() -> VirtualModule:
    module = TactTip(FINGER, BORN_S)

    def stop(payload: bytearray, _: int) -> None:
        if payload[FLAGS] & DeviceFlag.THERMAL_CUT_OUT:
            struct.pack_into("<H", payload, MOTOR, 0)

    changed_reports(module, stop)
    return VirtualModule(module)


def deaf_when_cut_out() -> VirtualModule:
    module = TactTip(FINGER, BORN_S)
    cut_out = DeviceFlag.THERMAL_CUT_OUT
    over(module, "_answer", lambda below, frame: None if module.flags & cut_out else below(frame))
    return VirtualModule(module)


WRONG_CUT_OUTS: WrongModules = [
    ("D14", cuts_out_late),
    ("D14", cuts_out_early),
    ("D14", cuts_out_a_report_late),
    ("D15", lets_go_while_heat_is_asked),
    ("D15", lets_go_to_cool),
    ("D15", never_lets_go),
    ("D16", stops_its_motor_too),
    ("D16", deaf_when_cut_out),
]
