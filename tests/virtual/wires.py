"""Connects drivers and emulators of one process in memory, on a virtual clock, without threads.

Three things are put in the place of the operating system's: the port behind a serial line, the bus behind a CAN
line, and the thread that opens them. Drivers, framing and emulators are the real ones.
"""

from collections.abc import Callable, Sequence
from typing import Generic, TypeVar

import pytest
import serial

import common.can_line
import common.serial_line
import sim_sensors.serial_server
import sim_sensors.sim_operator
import sim_sensors.sim_remote
from common.can_line import CanAddress
from common.serial_line import DeviceAbsent
from sim_sensors.select_loop import SelectLoop
from sim_sensors.serial_server import Device
from sim_sensors.socketcand import Node
from tests.virtual.memory_lines import MemoryBus, MemoryCan, MemoryLine, MemoryPort

T = TypeVar("T")


class ImmediateOpener(Generic[T]):
    """A BackgroundOpener without a thread: it tries when it is asked, and again every `retry_s` of virtual time."""

    def __init__(self, opener: Callable[[], T], retry_s: float, now: Callable[[], float]) -> None:
        self.problem: Exception | None = None
        self._opener = opener
        self._retry_s = retry_s
        self._now = now
        self._due_s: float | None = None

    def start(self) -> None:
        """Begin trying."""
        if self._due_s is None:
            self._due_s = self._now()

    def take(self) -> T | None:
        """What was opened, once; None while there is nothing new."""
        if self._due_s is None or self._now() < self._due_s:
            return None
        try:
            opened = self._opener()
        except (OSError, ValueError) as error:
            self.problem = error
            self._due_s = self._now() + self._retry_s
            return None
        self.problem = self._due_s = None
        return opened

    def stop(self) -> None:
        """Give up."""
        self._due_s = None


class Wires:
    """Every line and bus of a session.

    Attributes:
        lines: serial lines by address, `tacttip/index` and the like.
        buses: CAN buses by the port number that stands for them in the configuration.
    """

    def __init__(self, now: Callable[[], float], descriptor: int) -> None:
        """`descriptor`: open for writing, never full."""
        self.lines: dict[str, MemoryLine] = {}
        self.buses: dict[int, MemoryBus] = {}
        self._now = now
        self._descriptor = descriptor

    def lay(self, patch: pytest.MonkeyPatch) -> None:
        """Put these wires in the place of ptys, sockets and opening threads, until the patch is undone."""
        for module in (common.serial_line, common.can_line):
            patch.setattr(module, "BackgroundOpener", self._opener)
        patch.setattr(serial, "serial_for_url", self._open_port)
        patch.setattr(common.serial_line, "read_now", lambda port: port.read(4096))
        patch.setattr(common.serial_line, "write_now", lambda port, data: port.write(data) == len(data))
        patch.setattr(CanAddress, "open", lambda address: self._open_can(address.port))
        patch.setattr(sim_sensors.serial_server, "serve_serial", self._serve_line)
        for simulation in (sim_sensors.sim_remote, sim_sensors.sim_operator):
            patch.setattr(simulation, "SocketcandBus", self._serve_bus)

    def _opener(self, opener: Callable[[], T], retry_s: float = 0.25) -> ImmediateOpener[T]:
        return ImmediateOpener(opener, retry_s, self._now)

    def _open_port(self, address: str, **options: object) -> MemoryPort:
        return MemoryPort(self.lines[address], self._descriptor)

    def _open_can(self, port: int) -> MemoryCan:
        if not self.buses[port].plugged:
            raise DeviceAbsent("the gateway is gone")
        return MemoryCan(self.buses[port])

    def _serve_line(self, device: Device, loop: SelectLoop, address: str, what: str) -> MemoryLine:
        self.lines[address] = MemoryLine(device, loop, address)
        return self.lines[address]

    def _serve_bus(self, loop: SelectLoop, host: str, port: int, nodes: Sequence[Node]) -> MemoryBus:
        self.buses[port] = MemoryBus(loop, nodes)
        return self.buses[port]
