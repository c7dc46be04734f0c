"""Emulated serial modules that send or read one thing wrong each, under the number of the duty that they break."""

import struct
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from common.buses.serial_messages import DeviceFlag, Frame, MessageId, TextureSamples
from sim_sensors.devices.patient_switch import PatientSwitch
from sim_sensors.devices.plate_module import ReportClock
from sim_sensors.devices.texture_sensor import TextureSensor
from sim_sensors.devices.thermal_sensor import ThermalSensor
from tests.unit.teletaction.conformance.spoiled_module import (
    BORN_S,
    FINGER,
    WRONG_MODULES,
    AnyCrc,
    over,
    wrong,
    wrong_method,
    wrong_reports,
)
from tests.unit.teletaction.conformance.virtual_ends import VirtualModule


@wrong_method("S1", ThermalSensor, "_answer")
def twice(module: Any, below: Callable[..., None], frame: Frame) -> None:
    below(frame)
    below(frame)


@wrong("S1", TextureSensor)
def stands_still_when_asked(end: Any) -> None:
    """Sends no report for 50 ms after an answer."""
    owed = 0

    def say(below: Callable[..., None], message_id: MessageId, payload: bytes) -> None:
        nonlocal owed
        if message_id == MessageId.IDENTITY:
            owed = 10
        elif owed:
            owed -= 1
            return
        below(message_id, payload)

    over(end.module, "_say", say)


@wrong("S1", ThermalSensor)
def slow_at_rest(end: Any) -> None:
    """Answers IDENTIFY with the sixteenth report after it, unless commands are in force."""
    module, owed = end.module, list[int]()

    def answer(below: Callable[[Frame], None], frame: Frame) -> None:
        if not module.flags & DeviceFlag.COMMAND_TIMEOUT:
            below(frame)
        elif not frame.payload:
            owed.append(16)

    def run(below: Callable[[float], None], now_s: float) -> None:
        before = module._sequence
        below(now_s)
        if owed and module._sequence != before:
            owed[0] -= 1
            if not owed[0]:
                owed.pop(0)
                module._say(MessageId.IDENTITY, module.identity.encode())

    over(module, "_answer", answer)
    over(module, "_run", run)


@wrong("S2", ThermalSensor)
def without_a_number(end: Any) -> None:
    end.module.identity = replace(end.module.identity, serial="")


@wrong("S3", ThermalSensor)
def another_finger(end: Any) -> None:
    end.module.identity = replace(end.module.identity, finger=FINGER + 1)


@wrong("S4", ThermalSensor)
def another_promise(end: Any) -> None:
    end.module.identity = replace(end.module.identity, rate_hz=50)


@wrong("S4", ThermalSensor)
def another_range(end: Any) -> None:
    end.module.identity = replace(end.module.identity, range_high=80.0)


@wrong("S5", ThermalSensor)
def damaged_reports(end: Any) -> None:
    module, count = end.module, 0

    def say(below: Callable[..., None], message_id: MessageId, payload: bytes) -> None:
        nonlocal count
        below(message_id, payload)
        count += 1
        if count % 50 == 0 and message_id == MessageId.THERMAL_READING:
            module._output = module._output[:-3] + bytes((module._output[-3] ^ 0x40,)) + module._output[-2:]

    over(module, "_say", say)


@wrong_method("S6", ThermalSensor, "_say")
def modulo_255(module: Any, below: Callable[..., None], message_id: MessageId, payload: bytes) -> None:
    below(message_id, payload)
    module._sequence %= 255


@wrong_method("S7", ThermalSensor, "_say")
def talkative(module: Any, below: Callable[..., None], message_id: int, payload: bytes) -> None:
    below(message_id, payload)
    if module._sequence % 50 == 0:
        below(0x55, b"hello")


@wrong_reports("S8", ThermalSensor)
def beyond_12_bits(module: Any, payload: bytearray, count: int) -> None:
    if count % 100 == 0:
        struct.pack_into("<H", payload, 6, 5000)


@wrong_reports("S8", ThermalSensor)
def too_long_reports(module: Any, payload: bytearray, count: int) -> None:
    if count % 100 == 0:
        payload += b"\0"


@wrong("S9", ThermalSensor)
def at_90_hz(end: Any) -> None:
    end.module._reports = ReportClock(1.0 / 90.0, end.module._powered_s)


@wrong_method("S10", ThermalSensor, "_time_us")
def milliseconds(module: Any, below: Callable[[float], int], now_s: float) -> int:
    return below(now_s) // 1000


@wrong_method("S10", ThermalSensor, "_time_us")
def fast_clock(module: Any, below: Callable[[float], int], now_s: float) -> int:
    return round(1.1 * below(now_s))


@wrong_reports("S10", ThermalSensor)
def clock_goes_back(module: Any, payload: bytearray, count: int) -> None:
    if count % 40 == 0:
        struct.pack_into("<I", payload, 0, struct.unpack_from("<I", payload, 0)[0] - 15_000)


@wrong("X1", TextureSensor)
def eight_and_twelve(end: Any) -> None:
    module, turns = end.module, 0

    def run(below: Callable[[float], None], now_s: float) -> None:
        nonlocal turns
        while len(module._counts) >= 2 * (length := 12 if turns % 2 else 8):
            chunk, module._counts = module._counts[: 2 * length], module._counts[2 * length :]
            module._say(MessageId.TEXTURE_SAMPLES, TextureSamples(module._sent * 500, chunk).encode())
            module._sent += length
            turns += 1

    over(module, "_run", run)


@wrong_reports("X2", TextureSensor)
def shaky_clock(module: Any, payload: bytearray, count: int) -> None:
    if count % 7 == 0:
        struct.pack_into("<I", payload, 0, struct.unpack_from("<I", payload, 0)[0] + 300)


@wrong_method("S11", ThermalSensor, "_obey")
def echo(module: Any, below: Callable[..., None], frame: Frame, now_s: float) -> None:
    if frame.message_id == 0x7E:
        module._say(0x7E, frame.payload)
    below(frame, now_s)


@wrong_method("S11", ThermalSensor, "_obey")
def feels_addressed(module: Any, below: Callable[..., None], frame: Frame, now_s: float) -> None:
    """Before its first command it takes that of a TactTip for one of its own."""
    if frame.message_id == MessageId.TACTTIP_COMMAND and not module._watchdog.limit_s:
        module._watchdog.obeyed(now_s)
    below(frame, now_s)


@wrong_method("S12", ThermalSensor, "_answer")
def any_length_of_identify(module: Any, below: Callable[..., None], frame: Frame) -> None:
    below(Frame(frame.message_id, frame.sequence, b""))


@wrong("S13", TextureSensor)
def any_crc(end: Any) -> None:
    end.module.reader = AnyCrc()


@wrong_method("S14", ThermalSensor, "feed")
def one_zero_only(module: Any, below: Callable[..., None], data: bytes, now_s: float) -> None:
    if b"\0\0" not in data:
        below(data, now_s)


@wrong("S15", ThermalSensor)
def overrun(end: Any) -> None:
    """More than a kilobyte without a zero byte, and it hears nothing for a second."""
    deaf_until_s = 0.0

    def feed(below: Callable[..., None], data: bytes, now_s: float) -> None:
        nonlocal deaf_until_s
        if len(data) > 1024:
            deaf_until_s = now_s + 1.0
        if now_s > deaf_until_s:
            below(data, now_s)

    over(end.module, "feed", feed)


@wrong("S16", ThermalSensor)
def waits_for_its_reader(end: Any) -> None:
    end.blocking = True


def pressed() -> VirtualModule:
    switch = PatientSwitch(BORN_S)
    switch.pressed = True
    return VirtualModule(switch)


WRONG_MODULES.append(("P1", pressed))


def slider_is_not_at_0() -> VirtualModule:
    switch = PatientSwitch(BORN_S)
    switch.pain = 0.3
    return VirtualModule(switch)


WRONG_MODULES.append(("P2", slider_is_not_at_0))
