"""Ways to make one thing wrong in an emulated module, and to enter it under the duty that it breaks."""

import struct
from collections.abc import Callable
from functools import partial, wraps
from typing import Any

from cobs import cobs

from common.buses.serial_messages import Frame, FrameReader, MessageId
from sim_sensors.devices.serial_module import SerialModule
from tests.unit.teletaction.conformance.virtual_ends import VirtualModule

WRONG_MODULES: list[tuple[str, Callable[[], VirtualModule]]] = []
"""Number of a duty, and a module that breaks it."""
Entered = Callable[[Callable[..., None]], Callable[[], VirtualModule]]
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


def wrong(number: str, kind: type[SerialModule]) -> Entered:
    """Enter a module that breaks a duty; the function makes it wrong, given a sound one at the end of a line."""

    def enter(spoil: Callable[..., None]) -> Callable[[], VirtualModule]:
        @wraps(spoil)
        def made() -> VirtualModule:
            end = VirtualModule(kind(FINGER, BORN_S))  # type: ignore[call-arg, arg-type]
            spoil(end)
            return end

        WRONG_MODULES.append((number, made))
        return made

    return enter


def wrong_method(number: str, kind: type[SerialModule], name: str) -> Entered:
    """The function stands over one method: it is given the module, the method, and then what that is given."""

    def enter(do: Callable[..., Any]) -> Callable[[], VirtualModule]:
        return wrong(number, kind)(wraps(do)(lambda end: over(end.module, name, partial(do, end.module))))

    return enter


def wrong_reports(number: str, kind: type[SerialModule]) -> Entered:
    """The function changes reports: it is given the module, a report's payload, and the report's number."""

    def enter(change: Callable[..., None]) -> Callable[[], VirtualModule]:
        return wrong(number, kind)(wraps(change)(lambda end: changed_reports(end.module, partial(change, end.module))))

    return enter


def i16(payload: bytes, at: int) -> int:
    return int(struct.unpack_from("<h", payload, at)[0])


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
