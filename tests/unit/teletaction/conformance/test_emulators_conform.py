"""The emulators keep every duty of docs/protocols.md."""

import pytest

from sim_sensors.devices.exoskeleton import Exoskeleton
from sim_sensors.devices.patient_switch import PatientSwitch
from sim_sensors.devices.serial_module import SerialModule
from sim_sensors.devices.tacttip import TactTip
from sim_sensors.devices.telemanipulator import Telemanipulator
from sim_sensors.devices.texture_sensor import TextureSensor
from sim_sensors.devices.thermal_sensor import ThermalSensor
from teletaction.conformance.checklist import Verdict
from tests.unit.teletaction.conformance.examining import came, examined
from tests.unit.teletaction.conformance.virtual_ends import VirtualModule, VirtualNode

NOT_PASSED = [verdict for verdict in Verdict if verdict is not Verdict.PASS]


@pytest.mark.parametrize(
    "module", [TextureSensor(1, 90.0), ThermalSensor(2, 90.0), TactTip(3, 90.0), PatientSwitch(90.0)]
)
def test_every_emulated_module_keeps_every_duty(module: SerialModule) -> None:
    results = examined(VirtualModule(module), expected_finger=module.identity.finger)
    assert results
    assert came(results, *NOT_PASSED) == {}


@pytest.mark.parametrize("node", [Exoskeleton(), Telemanipulator()])
def test_every_emulated_node_keeps_every_duty(node: Exoskeleton | Telemanipulator) -> None:
    results = examined(VirtualNode(node))
    assert results
    assert came(results, *NOT_PASSED) == {}
