"""Both sites name the devices that have not yet reported outputs that are off; against all emulators."""

import re
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from common.config.link_models import OperatorLinkConfig, RemoteLinkConfig
from common.config.site_models import CalibrationConfig, OperatorConfig, RemoteConfig
from common.fingers import FINGERS
from operator_site.devices.devices import OperatorDevices
from operator_site.safety.gated_output import GatedOutput, Outputs
from remote_site.devices.devices import RemoteDevices
from remote_site.safety.setpoints import GatedCommand
from sim_sensors.devices.exoskeleton import Exoskeleton
from sim_sensors.devices.tacttip import TactTip, ntc_counts
from sim_sensors.devices.telemanipulator import Telemanipulator
from sim_sensors.devices.texture_sensor import TextureSensor
from sim_sensors.devices.thermal_sensor import ThermalSensor
from sim_sensors.physics.ssr_converter import counts_of
from tests.unit.devices.rigs import Rig

USED = ("index", "middle")


class SiteRig(Rig):
    """A site's devices and their emulators."""

    devices: Any
    counts: tuple[int, ...]
    """What the converters of a module read on a plate that is neither hot nor broken."""
    names: tuple[str, str, str]
    driven: str
    """What a module is said to do while it is driven, and while it is not and its drive is stuck."""
    stuck: str

    def __init__(self, node: Exoskeleton | Telemanipulator, modules: dict[str, Any]) -> None:
        super().__init__({name: (module, "tcp:127.0.0.1:0") for name, module in modules.items()}, node)
        for module in modules.values():
            if not isinstance(module, TextureSensor):
                module.measure(*self.counts)

    def addresses(self, kind: str) -> dict[str, str]:
        return {finger: self.servers[f"{finger} {kind}"].address for finger in USED}

    def write(self, driven: bool) -> None:
        """A tick of the site, that drives everything or nothing."""
        raise NotImplementedError

    def runs_until(self, driven: bool, done: Callable[[], object]) -> None:
        self.until(lambda: self.write(driven), done)

    def unconfirmed(self, since_s: float) -> dict[str, str]:
        """Who has not confirmed, and why."""
        return {device: why for device, why in self.devices.unconfirmed(since_s).items() if why}

    def close(self) -> None:
        self.devices.close()
        super().close()


class OperatorRig(SiteRig):
    counts = (ntc_counts(33.0), ntc_counts(20.0))
    names = ("exoskeleton", "index tacttip", "middle tacttip")
    driven, stuck = r"motor at [1-9]\d* mV, Peltier drive 0\.2", "motor at 0 mV, Peltier drive 0.7"

    def __init__(self) -> None:
        super().__init__(Exoskeleton(), {f"{f} tacttip": TactTip(FINGERS.index(f), time.monotonic()) for f in USED})
        config = OperatorConfig(
            fingers=USED,
            link=OperatorLinkConfig(keys=Path("keys")),
            tacttip=self.addresses("tacttip"),
            exoskeleton=self.can,
        )
        self.devices = OperatorDevices(config)

    def write(self, driven: bool) -> None:
        now_s = time.monotonic()
        self.devices.read(now_s)
        share = float(driven)
        output = GatedOutput(Outputs([share] * 5, [5000.0 * share] * 5, [33.0] * 5, [0.2 * share] * 5, [0] * 5))
        self.devices.write(now_s, output, driven)


class RemoteRig(SiteRig):
    counts = tuple(counts_of(np.array([34.0, 24.0])).tolist())
    names = ("telemanipulator", "index thermal_sensor", "middle thermal_sensor")
    driven, stuck = r"heater drive 0\.2", "heater drive 0.7"

    def __init__(self) -> None:
        start_s = time.monotonic()
        thermal = {f"{f} thermal_sensor": ThermalSensor(FINGERS.index(f), start_s) for f in USED}
        texture = {f"{f} texture": TextureSensor(FINGERS.index(f), start_s) for f in USED}
        super().__init__(Telemanipulator(), {**thermal, **texture})
        config = RemoteConfig(
            fingers=USED,
            link=RemoteLinkConfig(keys=Path("keys")),
            texture=self.addresses("texture"),
            thermal_sensors=self.addresses("thermal_sensor"),
            telemanipulator=self.can,
            calibration=CalibrationConfig(materials=Path("materials"), surfaces=Path("surfaces")),
        )
        self.devices = RemoteDevices(config)

    def write(self, driven: bool) -> None:
        sensed = self.devices.read(time.monotonic())
        heat = [0.2 * driven] * 5
        self.devices.write(GatedCommand(True, not driven, 0.0, 0.0, [0.0] * 5, heat, [0] * 5, None), sensed)


@pytest.fixture(params=[OperatorRig, RemoteRig])
def rig(request: pytest.FixtureRequest) -> Iterator[SiteRig]:
    rig: SiteRig = request.param()
    yield rig
    rig.close()


def test_absent_devices_have_confirmed_nothing(rig: SiteRig) -> None:
    assert rig.unconfirmed(0.0) == dict.fromkeys(rig.names, "not connected")


def test_every_device_is_named_until_it_reports_that_it_is_off(rig: SiteRig) -> None:
    everything = set(rig.names)

    def all_driven() -> bool:
        said = rig.unconfirmed(0.0)
        return set(said) == everything and not {"no report", "not connected"} & set(said.values())

    rig.runs_until(True, all_driven)
    stopped_s = time.monotonic()
    assert rig.unconfirmed(stopped_s) == dict.fromkeys(everything, "no report")
    rig.runs_until(False, lambda: rig.unconfirmed(stopped_s) == {})
    assert rig.unconfirmed(time.monotonic()) == dict.fromkeys(everything, "no report")
    rig.runs_until(True, all_driven)  # what was off once and is on again is not confirmed
    assert set(rig.unconfirmed(stopped_s)) == everything


def test_only_the_stuck_drive_and_the_unplugged_device_are_named(rig: SiteRig) -> None:
    _, stuck, lost = rig.names
    rig.runs_until(False, lambda: rig.unconfirmed(0.0) == {})
    rig.runs_until(True, lambda: re.fullmatch(rig.driven, rig.devices.unconfirmed(0.0)[stuck]))
    stopped_s = time.monotonic()
    module: Any = rig.modules[stuck]
    module.stuck_permille = 700
    module.measure(*rig.counts)
    rig.runs_until(False, lambda: rig.unconfirmed(stopped_s) == {stuck: rig.stuck})
    module.stuck_permille = None
    module.measure(*rig.counts)
    rig.runs_until(False, lambda: rig.unconfirmed(stopped_s) == {})
    rig.servers[lost].unplug()
    rig.runs_until(False, lambda: rig.unconfirmed(stopped_s) == {lost: "not connected"})
