"""Connect the drivers of sites with simulated devices in memory, on a virtual clock, without threads.

Drivers, framing and simulated devices are those of the product. Addresses serve only as names here.
"""

from collections.abc import Callable, Sequence
from typing import Generic, TypeVar

import can

from common.buses.can_address import CanAddress
from common.buses.serial_port import DeviceAbsent, Port
from common.buses.wiring import Opener
from sim_sensors.ports.node_bus import Node, NodeBus
from sim_sensors.ports.serial_server import Device, SerialServer
from teletaction.testbed.memory_lines import MemoryBus, MemoryCan, MemoryLine, MemoryPort

T = TypeVar("T")

RETRY_S = 0.25
"""Time from a failed attempt to open a device to the next, s."""


class ImmediateOpener(Generic[T]):
    """Opener that opens a device on `take`, and retries every RETRY_S of virtual time."""

    def __init__(self, opens: Callable[[], T], now_s: Callable[[], float]) -> None:
        """Open with `opens`."""
        self.problem: Exception | None = None
        self._opens = opens
        self._now_s = now_s
        self._due_s: float | None = None

    def start(self) -> None:
        """As `Opener.start`."""
        if self._due_s is None:
            self._due_s = self._now_s()

    def take(self) -> T | None:
        """As `Opener.take`."""
        if self._due_s is None or self._now_s() < self._due_s:
            return None
        try:
            opened = self._opens()
        except (OSError, ValueError) as error:
            self.problem = error
            self._due_s = self._now_s() + RETRY_S
            return None
        self.problem = self._due_s = None
        return opened

    def stop(self) -> None:
        """As `Opener.stop`."""
        self._due_s = None


class MemoryWiring:
    """Lines and buses of a test bed: sites open them (`Wiring`), and simulated devices serve them (`Serving`).

    Attributes:
        lines: serial lines by the address that a driver opens.
        buses: CAN buses by the port of their address.
    """

    def __init__(self, now_s: Callable[[], float]) -> None:
        """Start without lines; `now_s` is virtual time, s."""
        self.lines: dict[str, MemoryLine] = {}
        self.buses: dict[int, MemoryBus] = {}
        self.now = now_s

    @property
    def ends(self) -> list[MemoryLine | MemoryBus]:
        """The devices' ends of all lines and buses."""
        return [*self.lines.values(), *self.buses.values()]

    def line(self, device: Device, address: str, what: str) -> SerialServer:
        """As `Serving.line`. A driver opens `tcp:HOST:PORT` as `socket://HOST:PORT`, and any other name unchanged."""
        opened_as = f"socket://{address.removeprefix('tcp:')}" if address.startswith("tcp:") else address
        if opened_as in self.lines:
            raise ValueError(f"{what}: address {address!r} is taken")
        self.lines[opened_as] = MemoryLine(device, self.now, opened_as)
        return self.lines[opened_as]

    def bus(self, host: str, port: int, nodes: Sequence[Node]) -> NodeBus:
        """As `Serving.bus`."""
        if port in self.buses:
            raise ValueError(f"CAN bus: port {port} is taken")
        self.buses[port] = MemoryBus(self.now, nodes)
        return self.buses[port]

    def open_port(self, address: str) -> Port:
        """As `Wiring.open_port`."""
        if address not in self.lines:
            raise DeviceAbsent(f"{address}: no device is served there")
        port = MemoryPort(self.lines[address])
        port.write(b"\0")  # as `serial_port.open_port` does
        return port

    def open_bus(self, address: CanAddress) -> can.BusABC:
        """As `Wiring.open_bus`."""
        if address.port not in self.buses:
            raise DeviceAbsent(f"CAN {address}: no bus is served there")
        return MemoryCan(self.buses[address.port])

    def opener(self, opens: Callable[[], T], discard: Callable[[T], object]) -> Opener[T]:
        """As `Wiring.opener`; a device opens only when it is taken."""
        return ImmediateOpener(opens, self.now)
