"""Emulated modules whose drives do one thing wrong each, by the number of the duty that they break."""

import struct
from collections.abc import Callable

from common.framing import Frame
from common.serial_messages import DeviceFlag, MessageId
from sim_sensors.tacttip import TactTip
from sim_sensors.thermal_sensor import ThermalSensor
from tests.conformance.spoiled_module import (
    BORN_S,
    FINGER,
    FLAGS,
    HEATER,
    AnyCrc,
    WrongModules,
    changed_reports,
    i16,
    over,
)
from tests.conformance.virtual_ends import VirtualModule


def not_off_at_power_up() -> VirtualModule:
    module = ThermalSensor(FINGER, BORN_S)

    def trickle(payload: bytearray, _: int) -> None:
        if not module._watchdog.limit_s:
            struct.pack_into("<h", payload, HEATER, 1)

    changed_reports(module, trickle)
    return VirtualModule(module)


def strange_flag() -> VirtualModule:
    module = ThermalSensor(FINGER, BORN_S)

    def flag(payload: bytearray, _: int) -> None:
        payload[FLAGS] |= 0x80

    changed_reports(module, flag)
    return VirtualModule(module)


def ambient_short() -> VirtualModule:
    module = ThermalSensor(FINGER, BORN_S)
    changed_reports(module, lambda payload, _: struct.pack_into("<H", payload, 6, 0))
    return VirtualModule(module)


def weaker_cooling() -> VirtualModule:
    module = ThermalSensor(FINGER, BORN_S)

    def obey(below: Callable[..., None], frame: Frame, now_s: float) -> None:
        below(frame, now_s)
        if module._asked < 0:
            module._asked = round(0.9 * module._asked)
            module._limit()

    over(module, "_obey", obey)
    return VirtualModule(module)


def reversed_polarity() -> VirtualModule:
    end = VirtualModule(ThermalSensor(FINGER, BORN_S))
    end.polarity = -1.0
    return end


def time_out_of_180_ms() -> VirtualModule:
    module = ThermalSensor(FINGER, BORN_S)

    def obeyed(below: Callable[[float], None], now_s: float) -> None:
        below(now_s)
        module._watchdog.due_s = now_s + 0.18

    over(module._watchdog, "obeyed", obeyed)
    return VirtualModule(module)


def a_gap_now_and_then() -> VirtualModule:
    module = ThermalSensor(FINGER, BORN_S)
    in_force = 0

    def flag(payload: bytearray, _: int) -> None:
        nonlocal in_force
        in_force = 0 if payload[FLAGS] & DeviceFlag.COMMAND_TIMEOUT else in_force + 1
        if in_force % 60 == 59:
            payload[FLAGS] |= DeviceFlag.COMMAND_TIMEOUT

    changed_reports(module, flag)
    return VirtualModule(module)


def _raw_drive(module: ThermalSensor, do: Callable[[int, float], None]) -> None:
    """What becomes of a command of the right length whose drive is out of range."""

    def obey(below: Callable[..., None], frame: Frame, now_s: float) -> None:
        if frame.message_id == MessageId.HEATER_COMMAND and len(frame.payload) == 2:
            permille = i16(bytearray(frame.payload), 0)
            if abs(permille) > 1000:
                do(permille, now_s)
                return
        below(frame, now_s)

    over(module, "_obey", obey)


def clips() -> VirtualModule:
    module = ThermalSensor(FINGER, BORN_S)

    def clip(permille: int, now_s: float) -> None:
        module._asked = max(-1000, min(1000, permille))
        module._watchdog.obeyed(now_s)
        module._limit()

    _raw_drive(module, clip)
    return VirtualModule(module)


def refuses_and_feeds() -> VirtualModule:
    module = ThermalSensor(FINGER, BORN_S)
    _raw_drive(module, lambda _, now_s: module._watchdog.obeyed(now_s))
    return VirtualModule(module)


def motor_without_a_limit() -> VirtualModule:
    module = TactTip(FINGER, BORN_S)

    def obey(below: Callable[..., None], frame: Frame, now_s: float) -> None:
        if len(frame.payload) == 9 and struct.unpack_from("<H", frame.payload)[0] > 3000:
            frame = Frame(frame.message_id, frame.sequence, struct.pack("<H", 3000) + frame.payload[2:])
        below(frame, now_s)

    over(module, "_obey", obey)
    return VirtualModule(module)


def any_length() -> VirtualModule:
    module = ThermalSensor(FINGER, BORN_S)

    def obey(below: Callable[..., None], frame: Frame, now_s: float) -> None:
        below(frame._replace(payload=frame.payload[:2]), now_s)

    over(module, "_obey", obey)
    return VirtualModule(module)


def any_crc_of_commands() -> VirtualModule:
    module = ThermalSensor(FINGER, BORN_S)
    module.reader = AnyCrc()
    module.reader.believed = MessageId.HEATER_COMMAND
    return VirtualModule(module)


def identify_feeds() -> VirtualModule:
    module = ThermalSensor(FINGER, BORN_S)

    def answer(below: Callable[[Frame], None], frame: Frame) -> None:
        below(frame)
        if not module._watchdog.expired:
            module._watchdog.due_s += 0.02

    over(module, "_answer", answer)
    return VirtualModule(module)


def unknown_frames_feed() -> VirtualModule:
    module = ThermalSensor(FINGER, BORN_S)

    def obey(below: Callable[..., None], frame: Frame, now_s: float) -> None:
        if frame.message_id == 0x7E and not module._watchdog.expired:
            module._watchdog.obeyed(now_s)
        below(frame, now_s)

    over(module, "_obey", obey)
    return VirtualModule(module)


def commands_delay_reports() -> VirtualModule:
    module = ThermalSensor(FINGER, BORN_S)

    def obey(below: Callable[..., None], frame: Frame, now_s: float) -> None:
        below(frame, now_s)
        module._reports._due_s = now_s + 0.012

    over(module, "_obey", obey)
    return VirtualModule(module)


def busy_with_commands() -> VirtualModule:
    module = ThermalSensor(FINGER, BORN_S)
    over(module, "_answer", lambda below, frame: below(frame) if module.flags else None)
    return VirtualModule(module)


WRONG_DRIVES: WrongModules = [
    ("D1", not_off_at_power_up),
    ("D2", strange_flag),
    ("D3", ambient_short),
    ("D4", weaker_cooling),
    ("D5", reversed_polarity),
    ("D6", time_out_of_180_ms),
    ("D7", a_gap_now_and_then),
    ("D8", clips),
    ("D8", refuses_and_feeds),
    ("D8", motor_without_a_limit),
    ("D9", any_length),
    ("D10", any_crc_of_commands),
    ("D11", identify_feeds),
    ("D11", unknown_frames_feed),
    ("D12", commands_delay_reports),
    ("D13", busy_with_commands),
]
