"""The simulated devices of both sites at a clock that stands still unless a test moves it."""

from collections.abc import Iterator

import pytest

from common.config.simulation_models import SimOperatorConfig, SimPatientSwitchConfig, SimRemoteConfig
from sim_sensors.operator_devices import OperatorDevices
from sim_sensors.ports.select_loop import SelectLoop
from sim_sensors.remote_devices import RemoteDevices
from tests.ports import free_port
from tests.unit.sim_sensors.stepped import START_S

INDEX_LINE = {"index": "tcp:127.0.0.1:0"}


@pytest.fixture
def loop() -> SelectLoop:
    return SelectLoop()


@pytest.fixture
def stopped() -> SelectLoop:
    """Sockets at a clock that shows the time at which devices begin."""
    return SelectLoop(lambda: START_S)


@pytest.fixture
def remote(stopped: SelectLoop) -> Iterator[RemoteDevices]:
    config = SimRemoteConfig(
        fingers=("index",),
        texture=INDEX_LINE,
        thermal_sensors=INDEX_LINE,
        patient_switch=SimPatientSwitchConfig(port="tcp:127.0.0.1:0"),
        can_port=free_port(),
    )
    devices = RemoteDevices(config, stopped)
    yield devices
    devices.close()


@pytest.fixture
def operator(stopped: SelectLoop) -> Iterator[OperatorDevices]:
    config = SimOperatorConfig(fingers=("index",), tacttip=INDEX_LINE, can_port=free_port())
    devices = OperatorDevices(config, stopped)
    yield devices
    devices.close()
