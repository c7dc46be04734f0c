"""Emulated serial modules that are put off by what they hear, by the number of the duty that they break."""

from collections.abc import Callable

from common.framing import Frame
from common.serial_messages import MessageId
from sim_sensors.texture_sensor import TextureSensor
from sim_sensors.thermal_sensor import ThermalSensor
from tests.conformance.spoiled_module import (
    BORN_S,
    FINGER,
    AnyCrc,
    WrongModules,
    over,
)
from tests.conformance.virtual_ends import VirtualModule


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


WRONG_HEARING: WrongModules = [
    ("S11", echo),
    ("S11", feels_addressed),
    ("S12", any_length_of_identify),
    ("S13", any_crc),
    ("S14", one_zero_only),
    ("S15", overrun),
    ("S16", waits_for_its_reader),
]
