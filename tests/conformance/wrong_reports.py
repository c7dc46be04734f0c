"""Emulated serial modules that say one thing wrong each, by the number of the duty that they break."""

import struct
from collections.abc import Callable
from dataclasses import replace

from common.framing import Frame
from common.serial_messages import DeviceFlag, MessageId, TextureSamples
from sim_sensors.serial_module import ReportClock
from sim_sensors.texture_sensor import TextureSensor
from sim_sensors.thermal_sensor import ThermalSensor
from tests.conformance.spoiled_module import (
    BORN_S,
    FINGER,
    WrongModules,
    changed_reports,
    over,
)
from tests.conformance.virtual_ends import VirtualModule


def twice() -> VirtualModule:
    module = ThermalSensor(FINGER, BORN_S)

    def answer(below: Callable[[Frame], None], frame: Frame) -> None:
        below(frame)
        below(frame)

    over(module, "_answer", answer)
    return VirtualModule(module)


def slow_at_rest() -> VirtualModule:
    """Answers IDENTIFY with the sixteenth report after it, unless commands are in force."""
    module = ThermalSensor(FINGER, BORN_S)
    owed: list[int] = []

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
    return VirtualModule(module)


def without_a_number() -> VirtualModule:
    module = ThermalSensor(FINGER, BORN_S)
    module.identity = replace(module.identity, serial="")
    return VirtualModule(module)


def another_finger() -> VirtualModule:
    return VirtualModule(ThermalSensor(FINGER + 1, BORN_S))


def another_promise() -> VirtualModule:
    module = ThermalSensor(FINGER, BORN_S)
    module.identity = replace(module.identity, rate_hz=50)
    return VirtualModule(module)


def another_range() -> VirtualModule:
    module = ThermalSensor(FINGER, BORN_S)
    module.identity = replace(module.identity, range_high=80.0)
    return VirtualModule(module)


def damaged_reports() -> VirtualModule:
    module = ThermalSensor(FINGER, BORN_S)
    count = 0

    def say(below: Callable[..., None], message_id: MessageId, payload: bytes) -> None:
        nonlocal count
        below(message_id, payload)
        count += 1
        if count % 50 == 0 and message_id == MessageId.THERMAL_READING:
            module._output = module._output[:-3] + bytes((module._output[-3] ^ 0x40,)) + module._output[-2:]

    over(module, "_say", say)
    return VirtualModule(module)


def modulo_255() -> VirtualModule:
    module = ThermalSensor(FINGER, BORN_S)

    def say(below: Callable[..., None], message_id: MessageId, payload: bytes) -> None:
        below(message_id, payload)
        module._sequence %= 255

    over(module, "_say", say)
    return VirtualModule(module)


def talkative() -> VirtualModule:
    module = ThermalSensor(FINGER, BORN_S)

    def say(below: Callable[..., None], message_id: int, payload: bytes) -> None:
        below(message_id, payload)
        if module._sequence % 50 == 0:
            below(0x55, b"hello")

    over(module, "_say", say)
    return VirtualModule(module)


def beyond_12_bits() -> VirtualModule:
    module = ThermalSensor(FINGER, BORN_S)

    def ambient(payload: bytearray, count: int) -> None:
        if count % 100 == 0:
            struct.pack_into("<H", payload, 6, 5000)

    changed_reports(module, ambient)
    return VirtualModule(module)


def too_long_reports() -> VirtualModule:
    module = ThermalSensor(FINGER, BORN_S)

    def longer(payload: bytearray, count: int) -> None:
        if count % 100 == 0:
            payload += b"\0"

    changed_reports(module, longer)
    return VirtualModule(module)


def at_90_hz() -> VirtualModule:
    module = ThermalSensor(FINGER, BORN_S)
    module._reports = ReportClock(1.0 / 90.0, BORN_S)
    return VirtualModule(module)


def milliseconds() -> VirtualModule:
    module = ThermalSensor(FINGER, BORN_S)
    over(module, "_time_us", lambda below, now_s: below(now_s) // 1000)
    return VirtualModule(module)


def fast_clock() -> VirtualModule:
    module = ThermalSensor(FINGER, BORN_S)
    over(module, "_time_us", lambda below, now_s: round(1.1 * below(now_s)))
    return VirtualModule(module)


def clock_goes_back() -> VirtualModule:
    module = ThermalSensor(FINGER, BORN_S)

    def back(payload: bytearray, count: int) -> None:
        if count % 40 == 0:
            struct.pack_into("<I", payload, 0, struct.unpack_from("<I", payload, 0)[0] - 15_000)

    changed_reports(module, back)
    return VirtualModule(module)


def eight_and_twelve() -> VirtualModule:
    module = TextureSensor(FINGER, BORN_S)
    turns = 0

    def run(below: Callable[[float], None], now_s: float) -> None:
        nonlocal turns
        while len(module._counts) >= 2 * (length := 12 if turns % 2 else 8):
            chunk, module._counts = module._counts[: 2 * length], module._counts[2 * length :]
            module._say(MessageId.TEXTURE_SAMPLES, TextureSamples(module._sent * 500, chunk).encode())
            module._sent += length
            turns += 1

    over(module, "_run", run)
    return VirtualModule(module)


def shaky_clock() -> VirtualModule:
    module = TextureSensor(FINGER, BORN_S)

    def late(payload: bytearray, count: int) -> None:
        if count % 7 == 0:
            struct.pack_into("<I", payload, 0, struct.unpack_from("<I", payload, 0)[0] + 300)

    changed_reports(module, late)
    return VirtualModule(module)


WRONG_REPORTS: WrongModules = [
    ("S1", twice),
    ("S1", slow_at_rest),
    ("S2", without_a_number),
    ("S3", another_finger),
    ("S4", another_promise),
    ("S4", another_range),
    ("S5", damaged_reports),
    ("S6", modulo_255),
    ("S7", talkative),
    ("S8", beyond_12_bits),
    ("S8", too_long_reports),
    ("S9", at_90_hz),
    ("S10", milliseconds),
    ("S10", fast_clock),
    ("S10", clock_goes_back),
    ("X1", eight_and_twelve),
    ("X2", shaky_clock),
]
