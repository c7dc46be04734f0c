"""Emulated devices on a clock of their own: a whole examination takes only computing time."""

from collections.abc import Callable, Iterator
from typing import Any

import can
import numpy as np

from common.buses.can_frames import packing
from common.buses.thermometry import COUNT_MAX, ssr_c
from common.fingers import FINGERS
from sim_sensors.devices.can_node import CanNode
from sim_sensors.devices.exoskeleton import Exoskeleton
from sim_sensors.devices.serial_module import SerialModule
from sim_sensors.devices.tacttip import TactTip, ntc_counts
from sim_sensors.devices.telemanipulator import Telemanipulator
from sim_sensors.devices.texture_sensor import TextureSensor
from sim_sensors.devices.thermal_sensor import ThermalSensor
from sim_sensors.ports.backlog import Backlog

STEP_S = 0.002
ROOM_C, HEATS_K_S, COOLS_PER_S = 23.0, 4.0, 0.1
SSR_C = np.array([ssr_c(counts) for counts in range(4096)])


def ssr_counts(temperature_c: float) -> int:
    return min(COUNT_MAX, int(np.searchsorted(SSR_C, [temperature_c])[0]))


class Plate:
    """A plate that a drive heats and the room cools."""

    def __init__(self) -> None:
        self.plate_c = ROOM_C

    def step(self, drive: float) -> None:
        self.plate_c += STEP_S * (HEATS_K_S * drive - COOLS_PER_S * (self.plate_c - ROOM_C))


class VirtualModule:
    """An emulated module at the end of a line that holds 4 KiB.

    Attributes:
        blocking: it stands still while nobody reads.
    """

    address = "a virtual line"

    def __init__(self, module: SerialModule) -> None:
        self.module, self.plate = module, Plate()
        self.polarity, self.hot_side_c = 1.0, 20.0
        self.blocking, self._stood_s = False, 0.0
        self.said: list[bytes] = []
        self.interrupt_at: int | None = None
        self.steps = 0
        self._now_s = 100.0
        self._line = Backlog(4096)

    def now(self) -> float:
        return self._now_s

    @property
    def _device_s(self) -> float:
        """The module's own time: it stands while the module does."""
        return self._now_s - self._stood_s

    def send(self, data: bytes) -> None:
        self.said.append(data)
        self.module.feed(data, self._device_s)

    def receive(self, seconds: float) -> Iterator[tuple[float, bytes]]:
        return self._go(seconds, reading=True)

    def look_away(self, seconds: float) -> None:
        for _ in self._go(seconds, reading=False):
            pass

    def _go(self, seconds: float, reading: bool) -> Iterator[tuple[float, bytes]]:
        pieces: list[bytes] = []

        def read(data: bytes) -> int:
            pieces.append(data)
            return len(data)

        until_s = self._now_s + seconds - 1e-9
        while self._now_s < until_s:
            self.steps += 1
            if self.steps == self.interrupt_at:
                raise KeyboardInterrupt
            self._now_s += STEP_S
            if self.blocking and not reading:
                self._stood_s += STEP_S
                continue
            self._measure()
            if output := self.module.take_output(self._device_s):
                self._line.push(output)
            if reading:
                self._line.write(read)
            yield from ((self._now_s, piece) for piece in pieces)
            pieces.clear()

    def _measure(self) -> None:
        match self.module:
            case TextureSensor():
                self.module.add_samples(np.zeros(4, np.int16))
            case TactTip():
                self.plate.step(self.polarity * self.module.drive)
                self.module.measure(ntc_counts(self.plate.plate_c), ntc_counts(self.hot_side_c))
            case ThermalSensor():
                self.plate.step(self.polarity * self.module.drive)
                self.module.measure(ssr_counts(self.plate.plate_c), ssr_counts(ROOM_C))


class Hand:
    """A hand on servos that reach what they are set to in a few steps; and an exoskeleton that lies on a table."""

    def __init__(self) -> None:
        self.x_m = self.y_m = 0.0
        self.z_m = np.full(len(FINGERS), 0.006)

    def go(self, x_m: float, y_m: float, z_m: Any) -> None:
        self.x_m += 0.2 * (x_m - self.x_m)
        self.y_m += 0.2 * (y_m - self.y_m)
        self.z_m = self.z_m + 0.2 * (z_m - self.z_m)


class VirtualNode:
    """An emulated node on a bus of its own.

    Attributes:
        spoil: changes frames on their way to the bus.
    """

    address = "a virtual bus"

    def __init__(self, node: CanNode) -> None:
        self.node, self.hand = node, Hand()
        self.spoil: Callable[[can.Message], list[can.Message]] = lambda frame: [frame]
        self.said: list[can.Message] = []
        self.interrupt_at: int | None = None
        self.steps = 0
        self._now_s = 100.0

    def now(self) -> float:
        return self._now_s

    def send(self, message: can.Message) -> None:
        self.said.append(message)
        self.node.feed(message.arbitration_id, bytes(message.data), self._now_s)

    def receive(self, seconds: float) -> Iterator[can.Message]:
        until_s = self._now_s + seconds - 1e-9
        while self._now_s < until_s:
            self.steps += 1
            if self.steps == self.interrupt_at:
                raise KeyboardInterrupt
            self._now_s += STEP_S
            self._live()
            for number, data in self.node.take_turn():
                yield from self.spoil(can.Message(self._now_s, number, is_extended_id=False, data=data))

    def waiting(self) -> Iterator[can.Message]:
        return iter(())

    def _live(self) -> None:
        hand = self.hand
        match self.node:
            case Telemanipulator():
                hand.go(*self.node.setpoint_m(self._now_s))
                self.node.measure(hand.x_m, hand.y_m, hand.z_m, np.zeros(len(FINGERS)))
            case Exoskeleton():
                self.node.force_n(self._now_s)
                self.node.measure(hand.x_m, hand.y_m, hand.z_m)


def values_of(message: can.Message, name: str) -> dict[str, float]:
    return packing(name).unpack(bytes(message.data))[0]
