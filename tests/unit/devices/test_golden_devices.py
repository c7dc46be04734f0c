"""The protocol document's own bytes, put to emulators and drivers as a whole."""

import time
from typing import Any

import can
import numpy as np
import pytest

from common.buses.can_address import CanAddress
from common.buses.can_frames import FrameSender
from common.buses.serial_messages import DeviceFlag, MessageId, TactTipCommand, encode_frame
from common.buses.thermometry import ntc_c
from common.faults.fault import FaultCode
from common.fingers import FINGERS
from common.limits import MODULE_TIMEOUT_S
from operator_site.devices.exoskeleton import Exoskeleton as ExoskeletonDriver
from operator_site.devices.tacttip import TactTip as TactTipDriver
from remote_site.devices.telemanipulator import Following
from remote_site.devices.telemanipulator import Telemanipulator as TelemanipulatorDriver
from remote_site.devices.texture_sensor import TextureSensor as TextureDriver
from remote_site.devices.texture_sensor import texture_v
from remote_site.devices.thermal_sensor import ThermalSensor as ThermalDriver
from sim_sensors.devices.can_node import CanNode
from sim_sensors.devices.exoskeleton import Exoskeleton
from sim_sensors.devices.tacttip import TactTip
from sim_sensors.devices.telemanipulator import Telemanipulator
from sim_sensors.devices.texture_sensor import TextureSensor
from sim_sensors.devices.thermal_sensor import ThermalSensor
from tests.unit.devices.rigs import ModuleRig
from tests.waiting import wait_until


def test_the_emulated_thermal_sensor_answers_identify_obeys_and_reports(golden: dict[str, bytes]) -> None:
    sensor = ThermalSensor(1)
    sensor.feed(golden["identify"], 0.0)
    assert sensor.take_output(0.0).startswith(golden["identity"])
    sensor.feed(golden["heater_command"], 0.0)
    assert sensor.drive_permille == -250
    sensor = ThermalSensor(1)
    sensor.measure(2210, 1610)
    sensor.feed(golden["identify"] * 200 + golden["heater_command"], 1.0)
    assert sensor.take_output(1.0).endswith(b"\0" + golden["thermal_reading"])


def test_the_emulated_tacttip_obeys_and_reports(golden: dict[str, bytes]) -> None:
    module, last_s = TactTip(1), 4294.967295
    module.feed(golden["tacttip_command"], 0.0)
    assert (module.motor_mv, module.drive_permille) == (3000, -500)
    module.take_output(0.0246)
    assert (module.motor_mv, module.drive_permille) == (1410, -500)
    module = TactTip(1)
    module.measure(0, 2275)  # shorted for a moment: its Peltiers stay off while they are asked to heat
    heating = encode_frame(MessageId.TACTTIP_COMMAND, 0, TactTipCommand(1410, 500).encode())
    module.feed(golden["identify"] * 255 + heating, last_s)
    module.measure(1700, 2275)
    assert module.take_output(last_s).endswith(b"\0" + golden["tacttip_state"])


def test_the_emulated_can_nodes_obey(golden: dict[str, bytes]) -> None:
    exoskeleton = Exoskeleton()
    exoskeleton.feed(0x110, golden["FingerForces"], 0.0)
    assert exoskeleton.force_n(0.0) == pytest.approx([0.0, 0.01, 1.25, 5.0, 10.23])
    telemanipulator = Telemanipulator()
    telemanipulator.feed(0x200, golden["HandSetpoint"], 0.0)
    telemanipulator.feed(0x201, golden["HeightSetpoint"], 0.0)
    telemanipulator.measure(0.1, 0.02, np.full(5, 0.001), np.zeros(5))
    assert telemanipulator.setpoint_m(0.0)[:2] == (0.1, 0.02)
    x_m, y_m, z_m = telemanipulator.setpoint_m(0.0)  # the document's heights come with `released`
    assert (x_m, y_m) == (0.1, 0.02)
    assert z_m == pytest.approx([0.006, 0.001, 0.001, 0.01022, 0.001])
    free = FrameSender("HeightSetpoint").encode({"released": 0.0, **dict.fromkeys(FINGERS, -2.0)})
    telemanipulator.feed(0x201, bytes(free.data), 0.0)
    x_m, y_m, z_m = telemanipulator.setpoint_m(0.0)
    assert (x_m, y_m) == pytest.approx((0.65534, -0.65536))
    assert z_m == pytest.approx([-0.002] * 5)


def frame_number(node: CanNode, number: int, frame_id: int) -> bytes:
    """Data of a node's frame, counted from 0."""
    seen: list[bytes] = []
    while len(seen) <= number:
        seen += [data for sent_id, data in node.take_turn() if sent_id == frame_id]
    return seen[number]


def test_the_emulated_can_nodes_report_their_outputs(golden: dict[str, bytes]) -> None:
    exoskeleton = Exoskeleton()
    forces = dict(zip(FINGERS, (0.25, 0.0, 2.5, 0.01, 10.23), strict=True))
    exoskeleton.feed(0x110, bytes(FrameSender("FingerForces").encode({"enabled": 1.0, **forces}).data), 0.0)
    exoskeleton.force_n(MODULE_TIMEOUT_S + 1e-6)
    assert frame_number(exoskeleton, 6, 0x102) == golden["ExoskeletonState"]
    telemanipulator = Telemanipulator()
    telemanipulator.feed(0x201, golden["HeightSetpoint"], 0.0)
    telemanipulator.setpoint_m(0.0)
    assert frame_number(telemanipulator, 12, 0x213) == golden["TelemanipulatorState"]


def test_drivers_read_the_state_frames(golden: dict[str, bytes]) -> None:
    address = CanAddress(interface="virtual", channel="golden states")
    exoskeleton, telemanipulator = ExoskeletonDriver(address), TelemanipulatorDriver(address)

    def connected() -> bool:
        exoskeleton.read(1.0)
        telemanipulator.read(1.0)
        return exoskeleton.line.connected and telemanipulator.line.connected

    wait_until(connected)
    with can.Bus(interface="virtual", channel="golden states") as bus:
        for frame_id, name in ((0x102, "ExoskeletonState"), (0x213, "TelemanipulatorState")):
            bus.send(can.Message(arbitration_id=frame_id, data=golden[name], is_extended_id=False))
        exoskeleton.read(2.0)
        telemanipulator.read(2.0)
    assert exoskeleton.pushing.force_n == pytest.approx((0.25, 0.0, 2.5, 0.01, 10.23))
    assert (exoskeleton.pushing.enabled, exoskeleton.pushing.reported_s) == (False, 2.0)
    assert telemanipulator.following == Following(released=True, hand_alive=False, heights_alive=True, reported_s=2.0)
    exoskeleton.line.close()
    telemanipulator.line.close()


class OneReport:
    """A device that says who it is, as an emulator does, and then nothing but the document's report."""

    def __init__(self, module: Any, report: bytes) -> None:
        self._module = module
        self._report = report

    def feed(self, data: bytes, now_s: float) -> None:
        self._module.feed(data, 0.0)

    def take_output(self, now_s: float) -> bytes:
        return bytes(self._module.take_output(-1.0)) + self._report


@pytest.mark.parametrize("name", ["texture_samples", "thermal_reading", "tacttip_state"])
def test_drivers_read_the_reports(golden: dict[str, bytes], name: str) -> None:
    module, driver = {
        "texture_samples": (TextureSensor(1), TextureDriver),
        "thermal_reading": (ThermalSensor(1), ThermalDriver),
        "tacttip_state": (TactTip(1), TactTipDriver),
    }[name]
    rig = ModuleRig(OneReport(module, golden[name]), "pty")
    read: Any = driver("index", rig.address)
    got: list[Any] = []

    def tick() -> None:
        found = read.read(time.monotonic())
        if name == "tacttip_state":
            found = read.plate_c if read.measured_s > 0.0 else None
        got.extend([found] if found is not None else [])

    rig.until(tick, lambda: got)
    (got,) = got
    if name == "texture_samples":
        samples = np.array([-2048, 2047, 0, 1, -1, 256, 100, -100, 1000, -1000])
        assert texture_v(got) == pytest.approx(samples * 10.0 / 2048)
    elif name == "thermal_reading":
        # 814.9 + n / 4095 (1298.5 - 814.9) Ohm, solved for T by hand
        assert (got.sensor_c, got.ambient_c, got.fault) == (
            pytest.approx(34.3, abs=0.3),
            pytest.approx(25.5, abs=0.5),
            "",
        )
        assert read.applied_permille == -250
    else:
        assert got == pytest.approx(ntc_c(1700))
        assert FaultCode.MODULE_CUT_OUT in [fault.code for fault in read.faults]
        assert read.applied == (1410, 0)
        assert DeviceFlag.THERMAL_CUT_OUT == 0x02
    read.line.close()
    rig.close()
