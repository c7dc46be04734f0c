"""Serve the simulated devices at terminals, TCP ports and a CAN gateway, or on the lines of a test bed."""

from collections.abc import Mapping, Sequence
from typing import Protocol, TypeVar

from sim_sensors.ports.intruder import Intruder
from sim_sensors.ports.select_loop import SelectLoop
from sim_sensors.ports.serial_server import Device, SerialServer, serve_serial
from sim_sensors.ports.socketcand import Node, SocketcandBus

Finger = TypeVar("Finger", bound=str)


class Bus(Protocol):
    """A CAN bus with nodes of this process, and its possible faults; see `SocketcandBus`."""

    silent: bool
    deaf: bool
    off: bool
    intruder: Intruder | None

    @property
    def clients(self) -> int:
        """Number of connected drivers."""

    def pump(self, now_s: float) -> None:
        """Put the nodes' present frames on the bus."""

    def unplug(self) -> None:
        """Disconnect the bus from its drivers."""

    def plug(self) -> None:
        """Make the bus available again."""

    def turn_off(self) -> None:
        """Put the drivers' controller into the bus-off state."""

    def turn_on(self) -> None:
        """Restart the drivers' controller."""

    def close(self) -> None:
        """Close the bus."""


class Serving(Protocol):
    """Server of lines and buses, with the clock of the served devices."""

    def now(self) -> float:
        """Return the time, s."""

    def line(self, device: Device, address: str, what: str) -> SerialServer:
        """Serve a serial module; raises ValueError, which names `what`, where the address cannot be served."""

    def bus(self, host: str, port: int, nodes: Sequence[Node]) -> Bus:
        """Serve a CAN bus; raises ValueError where the address is taken."""


class SocketServing:
    """Server for drivers in other processes."""

    def __init__(self, loop: SelectLoop) -> None:
        """Serve in an event loop and use its clock."""
        self._loop = loop

    def now(self) -> float:
        """As `Serving.now`."""
        return self._loop.now()

    def line(self, device: Device, address: str, what: str) -> SerialServer:
        """As `Serving.line`; `pty` or `tcp:HOST:PORT`."""
        return serve_serial(device, self._loop, address, what)

    def bus(self, host: str, port: int, nodes: Sequence[Node]) -> Bus:
        """As `Serving.bus`."""
        return SocketcandBus(self._loop, host, port, nodes)


def serve_fingers(
    devices: Mapping[Finger, Device], serving: Serving, addresses: Mapping[Finger, str], kind: str
) -> dict[Finger, SerialServer]:
    """Serve one kind of module for each finger; after an error, none is served.

    Raises:
        ValueError: fingers and addresses do not match, or an address cannot be served.
    """
    if set(devices) != set(addresses):
        given = ", ".join(addresses) or "no finger"
        raise ValueError(f"{kind}: has addresses for {given}, fingers says {', '.join(devices)}")
    servers: dict[Finger, SerialServer] = {}
    try:
        for finger, device in devices.items():
            servers[finger] = serving.line(device, addresses[finger], f"{kind} {finger}")
    except ValueError:
        for server in servers.values():
            server.close()
        raise
    return servers
