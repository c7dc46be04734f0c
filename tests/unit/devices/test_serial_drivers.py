"""Each serial driver against its emulator, on a pseudo terminal and over TCP: one contract, and pulled cables."""

import math
import os
import socket
import struct
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from serial.urlhandler import protocol_socket

from common.buses.serial_device import WrongDevice, open_line
from common.buses.serial_messages import DeviceKind, MessageId, encode_frame
from common.buses.serial_port import DeviceAbsent
from common.faults.fault import Fault, FaultCode
from common.fingers import FINGERS
from common.wire.messages import ThermalReason
from operator_site.devices.tacttip import TactTip as TactTipDriver
from remote_site.devices.texture_sensor import TextureSensor as TextureDriver
from remote_site.devices.texture_sensor import texture_v
from remote_site.devices.thermal_sensor import ThermalSensor as ThermalDriver
from sim_sensors.devices.tacttip import TactTip, ntc_counts
from sim_sensors.devices.texture_sensor import TextureSensor
from sim_sensors.devices.thermal_sensor import ThermalSensor
from sim_sensors.physics.ssr_converter import counts_of
from tests.unit.devices.rigs import ModuleRig, alone

FINGER = "middle"
NUMBER = FINGERS.index(FINGER)
LINES = ("tcp:127.0.0.1:0", "pty")


class DriverContract:
    """What every serial driver promises with its module, whatever the line."""

    kind: DeviceKind
    report: MessageId

    def module(self) -> Any:
        raise NotImplementedError

    def driver(self, address: str, finger: str = FINGER) -> Any:
        raise NotImplementedError

    def turn(self, driver: Any) -> object:
        """One tick of the driver; what it read."""
        raise NotImplementedError

    @pytest.fixture(params=LINES)
    def rig(self, request: pytest.FixtureRequest) -> Iterator[ModuleRig]:
        rig = ModuleRig(self.module(), request.param)
        yield rig
        rig.close()

    @pytest.fixture
    def driver_on(self, rig: ModuleRig) -> Iterator[Any]:
        driver = self.driver(rig.address)
        rig.until(lambda: self.turn(driver), lambda: driver.line.connected)
        yield driver
        driver.line.close()

    def until_it_reads(self, rig: ModuleRig, driver: Any) -> Any:
        found: list[object] = []
        rig.until(lambda: found.extend(r for r in [self.turn(driver)] if r is not None), lambda: found)
        return found[-1]

    def test_a_driver_identifies_its_module_and_data_arrive_undamaged(self, rig: ModuleRig, driver_on: Any) -> None:
        assert driver_on.line.identity == rig.module.identity
        assert driver_on.line.identity.kind is self.kind
        assert driver_on.line.problem is None
        for _ in range(3):
            self.until_it_reads(rig, driver_on)
        assert (driver_on.line.reader.lost, driver_on.line.reader.malformed) == (0, 0)
        assert driver_on.line.reader.damaged <= 1  # it may have begun to listen within a frame

    def test_another_finger_or_kind_is_refused_by_name(self, rig: ModuleRig) -> None:
        driver = self.driver(rig.address, "thumb")
        rig.until(lambda: self.turn(driver), lambda: driver.line.problem)
        assert isinstance(driver.line.problem, WrongDevice)
        kind = self.kind.name.lower()
        for part in (rig.address, f"the middle's {kind} {rig.module.identity.serial}", f"says thumb's {kind}"):
            assert part in str(driver.line.problem)
        assert not driver.line.connected
        driver.line.close()

    def test_damaged_bytes_and_bad_content_are_counted_and_survived(self, rig: ModuleRig, driver_on: Any) -> None:
        self.until_it_reads(rig, driver_on)
        before = driver_on.line.reader.damaged
        for noise in (b"\xff\xff\xff\0", b"\x01\0", b"\x05abc\0", encode_frame(self.report, 0)[:-2] + b"\x7f\0"):
            rig.server.send(noise)
        rig.until(lambda: self.turn(driver_on), lambda: driver_on.line.reader.damaged >= before + 4)
        self.until_it_reads(rig, driver_on)
        rig.server.send(encode_frame(self.report, 0, b"\x01\x02\x03"))
        rig.server.send(encode_frame(0x7F, 1, b"unknown"))
        rig.until(lambda: self.turn(driver_on), lambda: driver_on.line.figures()["malformed"] == 1)
        assert "repeated" in driver_on.line.figures()
        self.until_it_reads(rig, driver_on)
        assert driver_on.line.connected

    def test_damaged_commands_are_counted_by_the_module(self, rig: ModuleRig, driver_on: Any) -> None:
        rig.module.feed(b"\x09broken\0", rig.loop.now())
        rig.until(lambda: self.turn(driver_on), lambda: rig.module.reader.damaged)
        self.until_it_reads(rig, driver_on)

    def test_a_stalled_module_does_not_block_the_driver(self, rig: ModuleRig, driver_on: Any) -> None:
        line = driver_on.line
        # Nobody reads, until every buffer on the way is full.
        alone(lambda: line.send(MessageId.TACTTIP_COMMAND, bytes(100)), lambda: line.unsent >= 100)
        self.until_it_reads(rig, driver_on)

    def test_a_module_is_heard_after_a_driver_died_in_the_middle_of_a_frame(self, rig: ModuleRig) -> None:
        rig.module.feed(encode_frame(0x30, 0, b"abcd")[:4], rig.loop.now())
        driver = self.driver(rig.address)
        rig.until(lambda: self.turn(driver), lambda: driver.line.connected or driver.line.problem)
        assert driver.line.problem is None
        driver.line.close()

    def test_the_device_goes_away_and_comes_back(self, rig: ModuleRig, driver_on: Any) -> None:
        line = driver_on.line

        def timed_turn() -> None:
            start_s = time.monotonic()
            self.turn(driver_on)
            assert time.monotonic() - start_s < 0.2  # losing a device holds no loop up

        rig.server.unplug()
        alone(timed_turn, lambda: not line.connected)
        assert (line.identity, line.times_lost) == (None, 1)
        line.send(MessageId.HEATER_COMMAND, b"\0\0")  # to nobody: nothing happens
        alone(lambda: self.turn(driver_on), lambda: line.problem is not None)
        assert isinstance(line.problem, DeviceAbsent)
        assert rig.address in str(line.problem)
        rig.server.plug()
        rig.until(lambda: self.turn(driver_on), lambda: line.connected)
        self.until_it_reads(rig, driver_on)

    def test_the_driver_may_start_first(self, rig: ModuleRig) -> None:
        rig.server.unplug()
        driver = self.driver(rig.address)
        alone(lambda: self.turn(driver), lambda: driver.line.problem is not None)
        rig.server.plug()
        rig.until(lambda: self.turn(driver), lambda: driver.line.connected)
        driver.line.close()


class TestTexture(DriverContract):
    kind, report = DeviceKind.TEXTURE_SENSOR, MessageId.TEXTURE_SAMPLES

    def module(self) -> Any:
        return TextureSensor(NUMBER, time.monotonic())

    def driver(self, address: str, finger: str = FINGER) -> TextureDriver:
        return TextureDriver(finger, address)

    def turn(self, driver: TextureDriver) -> object:
        return driver.read(time.monotonic())

    def test_the_signal_comes_in_volts_and_in_order(self, rig: ModuleRig, driver_on: TextureDriver) -> None:
        volts = texture_v(self.until_it_reads(rig, driver_on))
        assert volts == pytest.approx((np.arange(10) - 2048) * 10.0 / 2048)

    def test_a_late_tick_is_given_several_chunks_that_wait(self, rig: ModuleRig, driver_on: TextureDriver) -> None:
        """With one chunk a tick, a site that had fallen behind would stay behind its sensor."""
        one = texture_v(self.until_it_reads(rig, driver_on))
        for _ in range(3):
            rig.turn()
        rig.loop.serve(0.02)  # a terminal passes them on by and by
        chunks = driver_on.read(time.monotonic())
        assert chunks is not None
        assert texture_v(chunks) == one * 3

    def test_waiting_samples_are_dropped_oldest_first(self, rig: ModuleRig, driver_on: TextureDriver) -> None:
        for _ in range(100):
            rig.turn()
        while driver_on.read(0.0) is not None:
            assert len(driver_on.waiting) < 40


class TestThermal(DriverContract):
    kind, report = DeviceKind.THERMAL_SENSOR, MessageId.THERMAL_READING

    def module(self) -> Any:
        module = ThermalSensor(NUMBER, time.monotonic())
        module.measure(*counts_of(np.array([34.0, 24.0])).tolist())
        return module

    def driver(self, address: str, finger: str = FINGER) -> ThermalDriver:
        return ThermalDriver(finger, address)

    def turn(self, driver: ThermalDriver) -> object:
        return driver.read(time.monotonic())

    def test_readings_come_in_c(self, rig: ModuleRig, driver_on: ThermalDriver) -> None:
        reading = self.until_it_reads(rig, driver_on)
        assert (reading.sensor_c, reading.ambient_c) == (pytest.approx(34.0, abs=0.01), pytest.approx(24.0, abs=0.01))
        assert reading.fault == ""

    @pytest.mark.parametrize("drive", [0.25, -1.0, 1.0, 0.0])
    def test_a_heater_drive_reaches_the_module_and_runs_out(
        self, rig: ModuleRig, driver_on: ThermalDriver, drive: float
    ) -> None:
        driver_on.heat(time.monotonic(), drive)
        rig.until(lambda: self.turn(driver_on), lambda: not rig.module.flags)
        assert rig.module.drive == pytest.approx(drive)
        rig.until(lambda: self.turn(driver_on), lambda: rig.module.flags)
        assert rig.module.drive == 0.0

    @pytest.mark.parametrize(
        ("counts", "fault"), [(0, ThermalReason.SENSOR_SHORTED), (4095, ThermalReason.SENSOR_OPEN)]
    )
    def test_a_broken_sensor_is_reported(
        self, rig: ModuleRig, driver_on: ThermalDriver, counts: int, fault: ThermalReason
    ) -> None:
        rig.module.measure(counts, 1000)
        found: list[str] = []
        rig.until(
            lambda: found.extend(r.fault for r in [driver_on.read(time.monotonic())] if r is not None),
            lambda: found and found[-1] == fault.code,
        )


class TestTactTip(DriverContract):
    kind, report = DeviceKind.TACTTIP, MessageId.TACTTIP_STATE

    def module(self) -> Any:
        module = TactTip(NUMBER, time.monotonic())
        module.measure(ntc_counts(33.0), ntc_counts(20.0))
        return module

    def driver(self, address: str, finger: str = FINGER) -> TactTipDriver:
        return TactTipDriver(finger, address)

    def turn(self, driver: TactTipDriver) -> object:
        before = driver.measured_s
        driver.read(time.monotonic())
        return driver.plate_c if driver.measured_s > before else None

    def test_the_plates_temperature_comes_in_c(self, rig: ModuleRig, driver_on: TactTipDriver) -> None:
        assert self.until_it_reads(rig, driver_on) == pytest.approx(33.0, abs=0.03)
        assert driver_on.faults == []

    def test_drives_reach_the_module_and_run_out(self, rig: ModuleRig, driver_on: TactTipDriver) -> None:
        module: Any = rig.module
        driver_on.drive(time.monotonic(), 5000.0, -0.5)
        rig.until(lambda: self.turn(driver_on), lambda: module.motor_mv > 0)
        assert module.drive == -0.5
        rig.until(lambda: self.turn(driver_on), lambda: module.flags)
        assert (module.motor_mv, module.drive_permille) == (0, 0)

    def test_the_rate_budget_is_kept_and_switching_never_waits(
        self, driver_on: TactTipDriver, monkeypatch: pytest.MonkeyPatch
    ) -> None:
        commands: list[bytes] = []
        monkeypatch.setattr(type(driver_on.line), "send", lambda _line, _id, payload: commands.append(payload))

        def sent(t_s: float, rpm: float) -> int:
            commands.clear()
            driver_on.drive(t_s, rpm, 0.0)
            return len(commands)

        assert 200 <= sum(sent(n * 1e-3, 3000.0 + n % 100 * 40) for n in range(1000)) <= 251  # another speed every ms
        assert sum(sent(2.0 + n * 1e-3, 3000.0 * (n % 2)) for n in range(10)) == 10  # off and on and off
        assert sum(sent(2.01 + n * 1e-3, 3000.0) for n in range(100)) <= 25  # while the motor comes to its speed
        assert 4 <= sum(sent(2.11 + n * 1e-3, 3000.0) for n in range(100)) <= 6  # nothing new: every 20 ms

    def test_a_cut_out_and_a_broken_ntc_are_seen(self, rig: ModuleRig, driver_on: TactTipDriver) -> None:
        faults = {
            Fault(FaultCode.PLATE_THERMISTOR_OPEN, FINGER),
            Fault(FaultCode.HOT_SIDE_THERMISTOR_SHORT, FINGER),
            Fault(FaultCode.MODULE_CUT_OUT, FINGER),
        }
        rig.module.measure(4095, 0)
        rig.until(lambda: self.turn(driver_on), lambda: {*driver_on.faults} == faults)
        assert math.isnan(driver_on.plate_c)


class Mute:
    def feed(self, data: bytes, now_s: float) -> None:
        pass

    def take_output(self, now_s: float) -> bytes:
        return b""


def test_a_silent_port_is_absent() -> None:
    rig = ModuleRig(Mute(), "pty")
    driver = TactTipDriver("index", rig.address)
    rig.until(lambda: driver.read(0.0), lambda: driver.line.problem)
    assert "no device answers IDENTIFY" in str(driver.line.problem)
    driver.line.close()
    rig.close()


def open_files() -> int:
    return len(os.listdir("/proc/self/fd"))


@pytest.mark.session
@pytest.mark.skipif(not Path("/proc/self/fd").exists(), reason="this system does not list open files")
@pytest.mark.parametrize("address", LINES)
def test_a_cable_pulled_many_times_leaves_nothing_open(address: str) -> None:
    rig = ModuleRig(TactTip(1, time.monotonic()), address)
    driver = TactTipDriver("index", rig.address)
    line = driver.line

    def tick() -> None:
        driver.read(time.monotonic())

    rig.until(tick, lambda: line.connected)
    before = open_files()
    for times in range(1, 6):
        rig.server.unplug()
        rig.until(tick, lambda: not line.connected)
        assert line.times_lost == times
        rig.server.plug()
        rig.until(tick, lambda: line.connected)
    rig.until(tick, lambda: open_files() <= before)  # what was lost is closed beside the loop
    line.close()
    rig.close()


def test_a_connection_that_is_reset_while_it_is_opened_is_closed(monkeypatch: pytest.MonkeyPatch) -> None:
    opened = []

    def reset(port: protocol_socket.Serial) -> None:
        client, _ = listener.accept()
        client.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        client.close()
        opened.append(port._socket)

    # The library does this once it is connected, and before it clears what has come.
    monkeypatch.setattr(protocol_socket.Serial, "_update_dtr_state", reset)
    with socket.create_server(("127.0.0.1", 0)) as listener, pytest.raises(DeviceAbsent, match="reset"):
        open_line(f"socket://127.0.0.1:{listener.getsockname()[1]}")
    assert [connection.fileno() for connection in opened] == [-1]
