"""The commands of the fault table are those of the simulated devices."""

import pytest

from common.config.simulation_models import SimOperatorConfig, SimPatientSwitchConfig, SimRemoteConfig
from robustness.fault_table import DEVICE_FAULTS, FREE, PATIENT_FAULTS, PLATE_FAULTS, STROKING, Fault
from sim_sensors.operator_devices import OperatorDevices
from sim_sensors.ports.select_loop import SelectLoop
from sim_sensors.remote_devices import RemoteDevices
from teletaction.testbed.memory_wiring import MemoryWiring

FINGERS = (FREE, STROKING)


@pytest.mark.parametrize("fault", [*DEVICE_FAULTS, *PLATE_FAULTS, *PATIENT_FAULTS], ids=lambda fault: fault.key)
def test_every_fault_of_a_device_begins_and_is_mended_by_its_own_commands(fault: Fault) -> None:
    loop, wiring = SelectLoop(lambda: 0.0), MemoryWiring(lambda: 0.0)
    names = {kind: {finger: f"{kind} {finger}" for finger in FINGERS} for kind in ("texture", "thermal", "tacttip")}
    devices: RemoteDevices | OperatorDevices
    if fault.where == "sim-remote":
        switch = SimPatientSwitchConfig(port="switch")
        lines = {"texture": names["texture"], "thermal_sensors": names["thermal"], "patient_switch": switch}
        config = SimRemoteConfig(fingers=FINGERS, **lines)
        devices = RemoteDevices(config, loop, wiring)
    else:
        devices = OperatorDevices(SimOperatorConfig(fingers=FINGERS, tacttip=names["tacttip"]), loop, wiring)
    assert devices.faults.apply(fault.begin)
    assert devices.faults.apply(fault.mend) == ""
    devices.close()
