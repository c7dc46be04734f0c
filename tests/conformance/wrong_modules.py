"""Emulated serial modules with one thing wrong each, by the number of the duty that they break."""

import struct
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from cobs import cobs

from common.framing import Frame, FrameReader
from common.serial_messages import DeviceFlag, MessageId, TextureSamples
from sim_sensors.serial_module import CutOut, ReportClock, SerialModule
from sim_sensors.tacttip import TactTip
from sim_sensors.texture_sensor import TextureSensor
from sim_sensors.thermal_sensor import ThermalSensor
from tests.conformance.virtual_ends import VirtualModule

BORN_S = 90.0
FINGER = 2
FLAGS, HEATER, MOTOR, PELTIER = 8, 9, 9, 11
"""Where these stand in the reports."""


def over(device: Any, name: str, do: Callable[..., Any]) -> None:
    """Put a method over one of a device; it is given the one below it, and then what that is given."""
    below = getattr(device, name)
    setattr(device, name, lambda *given: do(below, *given))


def changed_reports(module: SerialModule, change: Callable[[bytearray, int], None]) -> None:
    """Change the payload of every report, which comes with its number."""
    count = 0

    def say(below: Callable[..., None], message_id: MessageId, payload: bytes) -> None:
        nonlocal count
        if message_id != MessageId.IDENTITY:
            count += 1
            new = bytearray(payload)
            change(new, count)
            payload = bytes(new)
        below(message_id, payload)

    over(module, "_say", say)


def i16(payload: bytearray, at: int) -> int:
    return int(struct.unpack_from("<h", payload, at)[0])


# --- every module


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
            module._output[-3] ^= 0x40

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


def echo() -> VirtualModule:
    module = ThermalSensor(FINGER, BORN_S)

    def obey(below: Callable[..., None], frame: Frame, now_s: float) -> None:
        if frame.message_id == 0x7E:
            module._say(0x7E, frame.payload)  # type: ignore[arg-type]
        below(frame, now_s)

    over(module, "_obey", obey)
    return VirtualModule(module)


def feels_addressed() -> VirtualModule:
    """Before its first command it takes that of a TactTip for one of its own."""
    module = ThermalSensor(FINGER, BORN_S)

    def obey(below: Callable[..., None], frame: Frame, now_s: float) -> None:
        if frame.message_id == MessageId.TACTTIP_COMMAND and not module._watchdog.limit_s:
            module._watchdog.obeyed(now_s)
        below(frame, now_s)

    over(module, "_obey", obey)
    return VirtualModule(module)


def any_length_of_identify() -> VirtualModule:
    module = ThermalSensor(FINGER, BORN_S)
    over(module, "_answer", lambda below, frame: below(Frame(frame.message_id, frame.sequence, b"")))
    return VirtualModule(module)


class AnyCrc(FrameReader):
    """Believes every message, or those of one id, whatever their CRC."""

    believed: int | None = None

    def feed(self, chunk: bytes) -> list[Frame]:
        good = super().feed(chunk)
        if good:
            return good
        found = []
        for piece in filter(None, chunk.split(b"\0")):
            try:
                body = bytes(cobs.decode(piece))
            except cobs.DecodeError:
                continue
            if 4 <= len(body) <= 250 and self.believed in (None, body[0]):
                found.append(Frame(body[0], body[1], body[2:-2]))
        return found


def any_crc() -> VirtualModule:
    module = TextureSensor(FINGER, BORN_S)
    module.reader = AnyCrc()
    return VirtualModule(module)


def one_zero_only() -> VirtualModule:
    module = ThermalSensor(FINGER, BORN_S)
    over(module, "feed", lambda below, data, now_s: None if b"\0\0" in data else below(data, now_s))
    return VirtualModule(module)


def overrun() -> VirtualModule:
    """More than a kilobyte without a zero byte, and it hears nothing for a second."""
    module = ThermalSensor(FINGER, BORN_S)
    deaf_until_s = 0.0

    def feed(below: Callable[..., None], data: bytes, now_s: float) -> None:
        nonlocal deaf_until_s
        if len(data) > 1024:
            deaf_until_s = now_s + 1.0
        if now_s > deaf_until_s:
            below(data, now_s)

    over(module, "feed", feed)
    return VirtualModule(module)


def waits_for_its_reader() -> VirtualModule:
    return VirtualModule(ThermalSensor(FINGER, BORN_S), blocking=True)


# --- texture sensor


def eight_and_twelve() -> VirtualModule:
    module = TextureSensor(FINGER, BORN_S)
    turns = 0

    def run(below: Callable[[float], None], now_s: float) -> None:
        nonlocal turns
        while len(module._counts) >= 2 * (length := 12 if turns % 2 else 8):
            chunk = bytes(module._counts[: 2 * length])
            del module._counts[: 2 * length]
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


# --- drives


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
        module._watchdog.limit_s = now_s + 0.18

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
        below(replace(frame, payload=frame.payload[:2]), now_s)

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
            module._watchdog.limit_s += 0.02

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


# --- TactTip


def no_water() -> VirtualModule:
    end = VirtualModule(TactTip(FINGER, BORN_S))
    end.hot_side_c = 40.0
    return end


def short_pulses() -> VirtualModule:
    module = TactTip(FINGER, BORN_S)
    over(module, "_pulse", lambda below, command, now_s: below(replace(command, pulse_us=command.pulse_us // 2), now_s))
    return VirtualModule(module)


def does_not_brake() -> VirtualModule:
    module = TactTip(FINGER, BORN_S)
    over(module, "_pulse", lambda below, command, now_s: below(command, now_s) if command.pulse_mv else None)
    return VirtualModule(module)


def repeats_its_pulse() -> VirtualModule:
    module = TactTip(FINGER, BORN_S)

    def pulse(below: Callable[..., None], command: Any, now_s: float) -> None:
        if now_s >= module._pulse_until_s:
            module._pulse_number = -1
        below(command, now_s)

    over(module, "_pulse", pulse)
    return VirtualModule(module)


def finishes_its_pulse() -> VirtualModule:
    module = TactTip(FINGER, BORN_S)
    over(module, "_pulse", lambda below, command, now_s: below(command, now_s) if command.pulse_us else None)
    return VirtualModule(module)


def slow_with_many() -> VirtualModule:
    """Of commands that come quickly it takes every twentieth."""
    module = TactTip(FINGER, BORN_S)
    last_s, quick = 0.0, 0

    def obey(below: Callable[..., None], frame: Frame, now_s: float) -> None:
        nonlocal last_s, quick
        quick = quick + 1 if now_s - last_s < 0.005 else 0
        last_s = now_s
        if quick < 10 or quick % 20 == 0:
            below(frame, now_s)

    over(module, "_obey", obey)
    return VirtualModule(module)


def little_water() -> VirtualModule:
    end = VirtualModule(TactTip(FINGER, BORN_S))

    def step(below: Callable[[float], None], drive: float) -> None:
        below(drive)
        end.hot_side_c += 0.02 * (20.0 - 15.0 * drive - end.hot_side_c)

    over(end.plate, "step", step)
    return end


WRONG_MODULES: list[tuple[str, Callable[[], VirtualModule]]] = [
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
    ("S11", echo),
    ("S11", feels_addressed),
    ("S12", any_length_of_identify),
    ("S13", any_crc),
    ("S14", one_zero_only),
    ("S15", overrun),
    ("S16", waits_for_its_reader),
    ("X1", eight_and_twelve),
    ("X2", shaky_clock),
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
    ("D14", cuts_out_late),
    ("D14", cuts_out_early),
    ("D14", cuts_out_a_report_late),
    ("D15", lets_go_while_heat_is_asked),
    ("D15", lets_go_to_cool),
    ("D15", never_lets_go),
    ("D16", stops_its_motor_too),
    ("D16", deaf_when_cut_out),
    ("T1", no_water),
    ("T2", short_pulses),
    ("T2", does_not_brake),
    ("T3", repeats_its_pulse),
    ("T4", finishes_its_pulse),
    ("T5", slow_with_many),
    ("T6", little_water),
]
