"""Serve the simulated devices at terminals, TCP ports and a CAN gateway, or on the lines of a test bed."""

import json
from collections.abc import Mapping, Sequence
from contextlib import ExitStack, closing
from typing import Protocol, TypeVar

from sim_sensors.ports.node_bus import Node, NodeBus
from sim_sensors.ports.select_loop import SelectLoop
from sim_sensors.ports.serial_server import Device, SerialServer, serve_serial
from sim_sensors.ports.socketcand import SocketcandBus

Finger = TypeVar("Finger", bound=str)


class Serving(Protocol):
    """Server of lines and buses, with the clock of the served devices."""

    def now(self) -> float:
        """Return the time, s."""

    def line(self, device: Device, address: str, what: str) -> SerialServer:
        """Serve a serial module; raises ValueError, which names `what`, where the address cannot be served."""

    def bus(self, host: str, port: int, nodes: Sequence[Node]) -> NodeBus:
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

    def bus(self, host: str, port: int, nodes: Sequence[Node]) -> NodeBus:
        """As `Serving.bus`."""
        return SocketcandBus(self._loop, host, port, nodes)


def announce(addresses: Mapping[str, str]) -> None:
    """Print the address of each device, as a line of JSON: a pseudo terminal gets its name only when it is opened."""
    for device, address in addresses.items():
        print(json.dumps({"device": device, "address": address}), flush=True)


def serve_fingers(
    devices: Mapping[Finger, Device], serving: Serving, addresses: Mapping[Finger, str], kind: str, opened: ExitStack
) -> dict[Finger, SerialServer]:
    """Serve one kind of module for each finger; `opened` closes the servers.

    Raises:
        ValueError: fingers and addresses do not match, or an address cannot be served.
    """
    if set(devices) != set(addresses):
        given = ", ".join(addresses) or "no finger"
        raise ValueError(f"{kind}: has addresses for {given}, fingers says {', '.join(devices)}")
    return {
        finger: opened.enter_context(closing(serving.line(device, addresses[finger], f"{kind} {finger}")))
        for finger, device in devices.items()
    }
