"""Emulated devices at real addresses, turned by the test together with their drivers."""

from collections.abc import Callable

import numpy as np

from common.buses.can_address import CanAddress
from sim_sensors.devices.can_node import CanNode
from sim_sensors.devices.exoskeleton import Exoskeleton
from sim_sensors.devices.telemanipulator import Telemanipulator
from sim_sensors.devices.texture_sensor import TextureSensor
from sim_sensors.ports.select_loop import SelectLoop
from sim_sensors.ports.serial_server import Device, SerialServer, serve_serial
from sim_sensors.ports.socketcand import SocketcandBus
from tests.waiting import wait_until


class Rig:
    """Modules and nodes with their lines, and the loop of the process that they would live in."""

    def __init__(self, modules: dict[str, tuple[Device, str]], *nodes: CanNode) -> None:
        """Serve modules, each at an address, and nodes on one bus."""
        self.loop = SelectLoop()
        self.nodes = nodes
        self.modules = {name: module for name, (module, _) in modules.items()}
        self.servers: dict[str, SerialServer] = {
            name: serve_serial(module, self.loop, address, name) for name, (module, address) in modules.items()
        }
        self.bus = SocketcandBus(self.loop, "127.0.0.1", 0, list(nodes))
        self.can = CanAddress(interface="socketcand", port=self.bus.port)

    def turn(self) -> None:
        """A step of the emulators' process."""
        self.loop.serve(0.001)
        now_s = self.loop.now()
        for node in self.nodes:  # the physics asks it what it does
            if isinstance(node, Exoskeleton):
                node.force_n(now_s)
            elif isinstance(node, Telemanipulator):
                node.setpoint_m(now_s)
        if self.nodes:
            self.bus.pump(now_s)
        for server in self.servers.values():
            server.pump(now_s)

    def until(self, driver_turn: Callable[[], object], done: Callable[[], object], patience_s: float = 10.0) -> None:
        """Emulators and driver by turns, until it is done."""

        def reached() -> object:
            if found := done():
                return found
            self.turn()
            driver_turn()
            return False

        wait_until(reached, "nothing came of it", patience_s, every_s=0.0)

    def close(self) -> None:
        self.bus.close()
        for server in self.servers.values():
            server.close()


class ModuleRig(Rig):
    """One module; a texture sensor has ten new samples in each step."""

    def __init__(self, module: Device, address: str) -> None:
        super().__init__({"module": (module, address)})
        self.module = module

    def turn(self) -> None:
        if isinstance(self.module, TextureSensor):
            self.module.add_samples(np.arange(-2048, -2048 + 10, dtype=np.int16))
        super().turn()

    @property
    def server(self) -> SerialServer:
        return self.servers["module"]

    @property
    def address(self) -> str:
        return self.server.address


def alone(driver_turn: Callable[[], object], done: Callable[[], object]) -> None:
    """The driver by itself, while the emulators' process stands, until it is done."""

    def reached() -> object:
        if found := done():
            return found
        driver_turn()
        return False

    wait_until(reached, "nothing came of it", every_s=0.0)
