"""Which devices have not yet reported that their outputs are off: both sites' devices against all their emulators."""

import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from common.can_line import CanAddress
from common.config import CalibrationConfig, OperatorConfig, OperatorLinkConfig, RemoteConfig, RemoteLinkConfig
from common.fingers import FINGERS
from operator_site.devices import OperatorDevices
from operator_site.gate import GatedOutput
from remote_site.devices import RemoteDevices
from remote_site.patient_gate import GatedCommand
from sim_sensors.exoskeleton import Exoskeleton
from sim_sensors.select_loop import SelectLoop
from sim_sensors.serial_server import SerialServer, serve_serial
from sim_sensors.socketcand import SocketcandBus
from sim_sensors.ssr_converter import counts_of
from sim_sensors.tacttip import TactTip, ntc_counts
from sim_sensors.telemanipulator import Telemanipulator
from sim_sensors.texture_sensor import TextureSensor
from sim_sensors.thermal_sensor import ThermalSensor

USED = ("index", "middle")


class Rig:
    """A site's devices and their emulators, turned by the test."""

    devices: Any

    def __init__(self, node: Exoskeleton | Telemanipulator, modules: dict[str, Any]) -> None:
        self.loop = SelectLoop()
        self.node = node
        self.modules = modules
        self.bus = SocketcandBus(self.loop, "127.0.0.1", 0, [node])
        self.servers: dict[str, SerialServer] = {
            name: serve_serial(module, self.loop, "tcp:127.0.0.1:0", name) for name, module in modules.items()
        }

    @property
    def can(self) -> CanAddress:
        return CanAddress(interface="socketcand", port=self.bus.port)

    def addresses(self, kind: str) -> dict[str, str]:
        return {finger: self.servers[f"{finger} {kind}"].address for finger in USED}

    def write(self, driven: bool) -> None:
        """A tick of the site, that drives everything or nothing."""
        raise NotImplementedError

    def step_node(self, now_s: float) -> None:
        raise NotImplementedError

    def turn(self, driven: bool) -> None:
        self.loop.serve(0.001)
        now_s = self.loop.now()
        self.step_node(now_s)
        self.bus.pump(now_s)
        for server in self.servers.values():
            server.pump(now_s)
        self.write(driven)

    def until(self, driven: bool, done: Callable[[], bool]) -> None:
        deadline = time.monotonic() + 10.0
        while not done():
            assert time.monotonic() < deadline, self.devices.unconfirmed(0.0)
            self.turn(driven)

    def close(self) -> None:
        self.devices.close()
        self.bus.close()
        for server in self.servers.values():
            server.close()


class OperatorRig(Rig):
    def __init__(self) -> None:
        super().__init__(Exoskeleton(), {f"{f} tacttip": TactTip(FINGERS.index(f), time.monotonic()) for f in USED})
        for module in self.modules.values():
            module.measure(*COUNTS[OperatorRig])
        config = OperatorConfig(
            fingers=USED,
            link=OperatorLinkConfig(keys=Path("keys")),
            tacttip=self.addresses("tacttip"),
            exoskeleton=self.can,
        )
        self.devices = OperatorDevices(config)

    def step_node(self, now_s: float) -> None:
        assert isinstance(self.node, Exoskeleton)
        self.node.force_n(now_s)

    def write(self, driven: bool) -> None:
        now_s = time.monotonic()
        self.devices.read(now_s)
        share = float(driven)
        output = GatedOutput([share] * 5, [5000.0 * share] * 5, [33.0] * 5, [0.2 * share] * 5, [0] * 5, None)
        self.devices.write(now_s, output, driven)


class RemoteRig(Rig):
    def __init__(self) -> None:
        start_s = time.monotonic()
        thermal = {f"{f} thermal": ThermalSensor(FINGERS.index(f), start_s) for f in USED}
        texture = {f"{f} texture": TextureSensor(FINGERS.index(f), start_s) for f in USED}
        super().__init__(Telemanipulator(), {**thermal, **texture})
        for module in thermal.values():
            module.measure(*COUNTS[RemoteRig])
        config = RemoteConfig(
            fingers=USED,
            link=RemoteLinkConfig(keys=Path("keys")),
            texture=self.addresses("texture"),
            thermal_sensors=self.addresses("thermal"),
            telemanipulator=self.can,
            calibration=CalibrationConfig(materials=Path("materials"), surfaces=Path("surfaces")),
        )
        self.devices = RemoteDevices(config)

    def step_node(self, now_s: float) -> None:
        assert isinstance(self.node, Telemanipulator)
        self.node.setpoint_m(now_s)

    def write(self, driven: bool) -> None:
        sensed = self.devices.read(time.monotonic())
        heat = [0.2 * driven] * 5
        self.devices.write(GatedCommand(True, not driven, 0.0, 0.0, [0.0] * 5, heat, [0] * 5, None), sensed)


COUNTS: dict[type[Rig], list[int]] = {
    OperatorRig: [ntc_counts(33.0), ntc_counts(20.0)],
    RemoteRig: counts_of(np.array([34.0, 24.0])).tolist(),
}
"""What the converters of a module read on a plate that is neither hot nor broken."""
NAMES = {
    OperatorRig: ("exoskeleton", "index tacttip", "middle tacttip"),
    RemoteRig: ("telemanipulator", "index thermal_sensor", "middle thermal_sensor"),
}


@pytest.fixture(params=list(NAMES))
def rig(request: pytest.FixtureRequest) -> Iterator[Rig]:
    rig: Rig = request.param()
    yield rig
    rig.close()


def named(said: dict[str, str]) -> dict[str, str]:
    """Who has not confirmed, and why."""
    return {device: why for device, why in said.items() if why}


def test_devices_that_are_not_there_have_confirmed_nothing(rig: Rig) -> None:
    assert named(rig.devices.unconfirmed(0.0)) == dict.fromkeys(NAMES[type(rig)], "not connected")


def test_all_are_named_until_each_has_reported_that_it_is_off(rig: Rig) -> None:
    everything, devices = set(NAMES[type(rig)]), rig.devices

    def all_driven() -> bool:
        said = named(devices.unconfirmed(0.0))
        return set(said) == everything and not {"no report", "not connected"} & set(said.values())

    rig.until(True, all_driven)
    stopped_s = time.monotonic()
    assert named(devices.unconfirmed(stopped_s)) == dict.fromkeys(everything, "no report")
    rig.until(False, lambda: named(devices.unconfirmed(stopped_s)) == {})
    assert named(devices.unconfirmed(time.monotonic())) == dict.fromkeys(everything, "no report")
    rig.until(True, all_driven)  # what was off once and is on again is not confirmed
    assert set(named(devices.unconfirmed(stopped_s))) == everything


def test_one_drive_that_is_stuck_is_named_alone(rig: Rig) -> None:
    stuck = NAMES[type(rig)][1]
    rig.until(True, lambda: "drive 0.2" in rig.devices.unconfirmed(0.0)[stuck])
    module = rig.modules[stuck.removesuffix("_sensor")]
    module.stuck_permille = 700
    module.measure(*COUNTS[type(rig)])
    stopped_s = time.monotonic()
    rig.until(False, lambda: set(named(rig.devices.unconfirmed(stopped_s))) == {stuck})
    assert rig.devices.unconfirmed(stopped_s)[stuck].endswith("drive 0.7")


def test_a_device_that_was_unplugged_is_named_as_not_connected(rig: Rig) -> None:
    stopped_s = time.monotonic()
    rig.until(False, lambda: named(rig.devices.unconfirmed(stopped_s)) == {})
    lost = NAMES[type(rig)][2]
    rig.servers.pop(lost.removesuffix("_sensor")).close()
    rig.until(False, lambda: named(rig.devices.unconfirmed(stopped_s)) == {lost: "not connected"})
