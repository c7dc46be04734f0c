"""Emulated modules whose drives or limits are wrong in one thing, under the number of the duty that they break."""

import struct
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from common.buses.serial_messages import DeviceFlag, Frame, MessageId, TactTipCommand
from sim_sensors.devices.plate_module import CutOut
from sim_sensors.devices.tacttip import TactTip
from sim_sensors.devices.thermal_sensor import ThermalSensor
from tests.unit.teletaction.conformance.spoiled_module import (
    FLAGS,
    HEATER,
    MOTOR,
    PELTIER,
    AnyCrc,
    changed_reports,
    i16,
    over,
    wrong,
    wrong_method,
    wrong_reports,
)


@wrong_reports("D1", ThermalSensor)
def not_off_at_power_up(module: Any, payload: bytearray, _: int) -> None:
    if not module._watchdog.limit_s:
        struct.pack_into("<h", payload, HEATER, 1)


@wrong_reports("D2", ThermalSensor)
def strange_flag(module: Any, payload: bytearray, _: int) -> None:
    payload[FLAGS] |= 0x80


@wrong_reports("D3", ThermalSensor)
def ambient_short(module: Any, payload: bytearray, _: int) -> None:
    struct.pack_into("<H", payload, 6, 0)


@wrong_method("D4", ThermalSensor, "_obey")
def weaker_cooling(module: Any, below: Callable[..., None], frame: Frame, now_s: float) -> None:
    below(frame, now_s)
    if module._asked_permille < 0:
        module._asked_permille = round(0.9 * module._asked_permille)
        module._limit()


@wrong("D5", ThermalSensor)
def reversed_polarity(end: Any) -> None:
    end.polarity = -1.0


@wrong("D6", ThermalSensor)
def time_out_of_180_ms(end: Any) -> None:
    watchdog = end.module._watchdog

    def obeyed(below: Callable[[float], None], now_s: float) -> None:
        below(now_s)
        watchdog.due_s = now_s + 0.18

    over(watchdog, "obeyed", obeyed)


@wrong("D7", ThermalSensor)
def a_gap_now_and_then(end: Any) -> None:
    in_force = 0

    def flag(payload: bytearray, _: int) -> None:
        nonlocal in_force
        in_force = 0 if payload[FLAGS] & DeviceFlag.COMMAND_TIMEOUT else in_force + 1
        if in_force % 60 == 59:
            payload[FLAGS] |= DeviceFlag.COMMAND_TIMEOUT

    changed_reports(end.module, flag)


def beyond_full(frame: Frame) -> bool:
    """Whether it is a command of the right length whose drive is out of range."""
    command = frame.message_id == MessageId.HEATER_COMMAND and len(frame.payload) == 2
    return command and abs(i16(frame.payload, 0)) > 1000


@wrong_method("D8", ThermalSensor, "_obey")
def clips(module: Any, below: Callable[..., None], frame: Frame, now_s: float) -> None:
    if not beyond_full(frame):
        below(frame, now_s)
        return
    module._asked_permille = max(-1000, min(1000, i16(frame.payload, 0)))
    module._watchdog.obeyed(now_s)
    module._limit()


@wrong_method("D8", ThermalSensor, "_obey")
def refuses_and_feeds(module: Any, below: Callable[..., None], frame: Frame, now_s: float) -> None:
    if beyond_full(frame):
        module._watchdog.obeyed(now_s)
    else:
        below(frame, now_s)


@wrong_method("D8", TactTip, "_obey")
def motor_without_a_limit(module: Any, below: Callable[..., None], frame: Frame, now_s: float) -> None:
    if len(frame.payload) == 9 and struct.unpack_from("<H", frame.payload)[0] > 3000:
        frame = Frame(frame.message_id, frame.sequence, struct.pack("<H", 3000) + frame.payload[2:])
    below(frame, now_s)


@wrong_method("D9", ThermalSensor, "_obey")
def any_length(module: Any, below: Callable[..., None], frame: Frame, now_s: float) -> None:
    below(frame._replace(payload=frame.payload[:2]), now_s)


@wrong("D10", ThermalSensor)
def any_crc_of_commands(end: Any) -> None:
    end.module.reader = AnyCrc()
    end.module.reader.believed = MessageId.HEATER_COMMAND


@wrong_method("D11", ThermalSensor, "_answer")
def identify_feeds(module: Any, below: Callable[..., None], frame: Frame) -> None:
    below(frame)
    if not module._watchdog.expired:
        module._watchdog.due_s += 0.02


@wrong_method("D11", ThermalSensor, "_obey")
def unknown_frames_feed(module: Any, below: Callable[..., None], frame: Frame, now_s: float) -> None:
    if frame.message_id == 0x7E and not module._watchdog.expired:
        module._watchdog.obeyed(now_s)
    below(frame, now_s)


@wrong_method("D12", ThermalSensor, "_obey")
def commands_delay_reports(module: Any, below: Callable[..., None], frame: Frame, now_s: float) -> None:
    below(frame, now_s)
    module._reports._due_s = now_s + 0.012


@wrong_method("D13", ThermalSensor, "_answer")
def busy_with_commands(module: Any, below: Callable[..., None], frame: Frame) -> None:
    if module.flags:
        below(frame)


@wrong("D14", ThermalSensor)
def cuts_out_late(end: Any) -> None:
    end.module._cut_out = CutOut(42.5)
    end.module._cut_out.measure(25.0)


@wrong("D14", TactTip)
def cuts_out_early(end: Any) -> None:
    cut_out = end.module._cut_out
    over(cut_out, "measure", lambda below, measured_c: below(measured_c + (0.0 if cut_out.tripped else 3.0)))


@wrong("D14", TactTip)
def cuts_out_a_report_late(end: Any) -> None:
    seen = False

    def trickle(payload: bytearray, _: int) -> None:
        nonlocal seen
        cut_out = bool(payload[FLAGS] & DeviceFlag.THERMAL_CUT_OUT)
        if cut_out and not seen:
            struct.pack_into("<h", payload, PELTIER, 300)
        seen = cut_out

    changed_reports(end.module, trickle)


@wrong("D15", TactTip)
def lets_go_while_heat_is_asked(end: Any) -> None:
    over(end.module._cut_out, "allows", lambda below, permille: below(permille) or below(min(0, permille)))


@wrong("D15", TactTip)
def lets_go_to_cool(end: Any) -> None:
    over(end.module._cut_out, "allows", lambda below, permille: below(permille) or permille < 0)


@wrong("D15", TactTip)
def never_lets_go(end: Any) -> None:
    cut_out, tripped = end.module._cut_out, False

    def allows(below: Callable[[int], bool], permille: int) -> bool:
        nonlocal tripped
        tripped = not below(permille) or tripped
        cut_out.tripped = tripped
        return not tripped

    over(cut_out, "allows", allows)


@wrong_reports("D16", TactTip)
def stops_its_motor_too(module: Any, payload: bytearray, _: int) -> None:
    if payload[FLAGS] & DeviceFlag.THERMAL_CUT_OUT:
        struct.pack_into("<H", payload, MOTOR, 0)


@wrong_method("D16", TactTip, "_answer")
def deaf_when_cut_out(module: Any, below: Callable[..., None], frame: Frame) -> None:
    if not module.flags & DeviceFlag.THERMAL_CUT_OUT:
        below(frame)


@wrong("T1", TactTip)
def no_water(end: Any) -> None:
    end.hot_side_c = 40.0


@wrong_method("T2", TactTip, "_pulse")
def short_pulses(module: Any, below: Callable[..., None], command: TactTipCommand, now_s: float) -> None:
    below(replace(command, pulse_us=command.pulse_us // 2), now_s)


@wrong_method("T2", TactTip, "_pulse")
def does_not_brake(module: Any, below: Callable[..., None], command: TactTipCommand, now_s: float) -> None:
    if command.pulse_mv:
        below(command, now_s)


@wrong_method("T3", TactTip, "_pulse")
def repeats_its_pulse(module: Any, below: Callable[..., None], command: TactTipCommand, now_s: float) -> None:
    if now_s >= module._pulse_until_s:
        module._pulse_number = -1
    below(command, now_s)


@wrong_method("T4", TactTip, "_pulse")
def finishes_its_pulse(module: Any, below: Callable[..., None], command: TactTipCommand, now_s: float) -> None:
    if command.pulse_us:
        below(command, now_s)


@wrong("T5", TactTip)
def slow_with_many(end: Any) -> None:
    """Of commands that come quickly it takes every twentieth."""
    last_s, quick = 0.0, 0

    def obey(below: Callable[..., None], frame: Frame, now_s: float) -> None:
        nonlocal last_s, quick
        quick = quick + 1 if now_s - last_s < 0.005 else 0
        last_s = now_s
        if quick < 10 or quick % 20 == 0:
            below(frame, now_s)

    over(end.module, "_obey", obey)


@wrong("T6", TactTip)
def little_water(end: Any) -> None:
    def step(below: Callable[[float], None], drive: float) -> None:
        below(drive)
        end.hot_side_c += 0.02 * (20.0 - 15.0 * drive - end.hot_side_c)

    over(end.plate, "step", step)
