"""Each serial driver against its emulator, on a pseudo terminal and over TCP: one contract for all six."""

import math
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

from common.fingers import FINGERS
from common.framing import encode_frame
from common.serial_line import WrongDevice
from common.serial_messages import DeviceKind, MessageId
from common.serial_port import DeviceAbsent
from operator_site.tacttip import TactTip as TactTipDriver
from remote_site.texture_sensor import TextureSensor as TextureDriver
from remote_site.texture_sensor import texture_v
from remote_site.thermal_sensor import ThermalSensor as ThermalDriver
from sim_sensors.select_loop import SelectLoop
from sim_sensors.serial_module import SerialModule
from sim_sensors.serial_server import SerialServer, serve_serial
from sim_sensors.ssr_converter import counts_of
from sim_sensors.tacttip import TactTip, ntc_counts
from sim_sensors.texture_sensor import TextureSensor
from sim_sensors.thermal_sensor import ThermalSensor

FINGER = "middle"
NUMBER = FINGERS.index(FINGER)


class Rig:
    """One module, its line, and the emulator's loop, all turned by the test."""

    def __init__(self, module: SerialModule, address: str) -> None:
        self.loop = SelectLoop()
        self.module = module
        self.server: SerialServer = serve_serial(module, self.loop, address, "module")

    @property
    def address(self) -> str:
        return self.server.address

    def turn(self) -> None:
        """What a millisecond of the emulator's process does."""
        self.loop.serve(0.001)
        if isinstance(self.module, TextureSensor):
            self.module.add_samples(np.arange(-2048, -2048 + 10, dtype=np.int16))
        self.server.pump(self.loop.now())

    def until(self, driver_turn: Callable[[], object], done: Callable[[], object], seconds: float = 5.0) -> None:
        """Emulator and driver by turns, until it is done."""
        deadline = time.monotonic() + seconds
        while not done():
            assert time.monotonic() < deadline, "nothing came of it"
            self.turn()
            driver_turn()

    def damage(self, line_noise: bytes) -> None:
        """Bytes on the line that the module never sent."""
        self.server._send(line_noise)


class DriverContract:
    """What every serial driver promises with its module, whatever the line."""

    listen: str
    kind: DeviceKind
    report: MessageId

    def module(self, finger: int = NUMBER) -> SerialModule:
        raise NotImplementedError

    def driver(self, address: str, finger: str = FINGER) -> Any:
        raise NotImplementedError

    def turn(self, driver: Any) -> object:
        """One tick of the driver; what it read."""
        raise NotImplementedError

    @pytest.fixture
    def rig(self) -> Iterator[Rig]:
        rig = Rig(self.module(), self.listen)
        yield rig
        rig.server.close()

    @pytest.fixture
    def driver_on(self, rig: Rig) -> Iterator[Any]:
        driver = self.driver(rig.address)
        rig.until(lambda: self.turn(driver), lambda: driver.line.connected)
        yield driver
        driver.line.close()

    def until_it_reads(self, rig: Rig, driver: Any) -> Any:
        found: list[object] = []
        rig.until(lambda: found.extend(r for r in [self.turn(driver)] if r is not None), lambda: found)
        return found[-1]

    def test_it_learns_who_answers(self, rig: Rig, driver_on: Any) -> None:
        assert driver_on.line.identity == rig.module.identity
        assert driver_on.line.identity.kind is self.kind
        assert driver_on.line.problem is None

    def test_data_arrive_undamaged(self, rig: Rig, driver_on: Any) -> None:
        for _ in range(3):
            self.until_it_reads(rig, driver_on)
        assert (driver_on.line.reader.lost, driver_on.damaged) == (0, 0)
        assert driver_on.line.reader.damaged <= 1  # it may have begun to listen within a frame

    def test_another_finger_or_kind_is_refused_by_name(self, rig: Rig) -> None:
        driver = self.driver(rig.address, "thumb")
        rig.until(lambda: self.turn(driver), lambda: driver.line.problem)
        assert isinstance(driver.line.problem, WrongDevice)
        kind = self.kind.name.lower()
        for part in (rig.address, f"the middle's {kind} {rig.module.identity.serial}", f"says thumb's {kind}"):
            assert part in str(driver.line.problem)
        assert not driver.line.connected
        driver.line.close()

    def test_damaged_bytes_are_counted_and_survived(self, rig: Rig, driver_on: Any) -> None:
        self.until_it_reads(rig, driver_on)
        before = driver_on.line.reader.damaged
        for noise in (b"\xff\xff\xff\0", b"\x01\0", b"\x05abc\0", encode_frame(self.report, 0)[:-2] + b"\x7f\0"):
            rig.damage(noise)
        rig.until(lambda: self.turn(driver_on), lambda: driver_on.line.reader.damaged >= before + 4)
        self.until_it_reads(rig, driver_on)
        assert driver_on.line.connected

    def test_a_good_frame_of_bad_content_is_counted_and_survived(self, rig: Rig, driver_on: Any) -> None:
        rig.damage(encode_frame(self.report, 0, b"\x01\x02\x03"))
        rig.damage(encode_frame(0x7F, 1, b"unknown"))
        rig.until(lambda: self.turn(driver_on), lambda: driver_on.damaged == 1)
        self.until_it_reads(rig, driver_on)

    def test_damaged_commands_are_counted_by_the_module(self, rig: Rig, driver_on: Any) -> None:
        driver_on.line._port.write(b"\x09broken\0")
        rig.until(lambda: self.turn(driver_on), lambda: rig.module.reader.damaged)
        self.until_it_reads(rig, driver_on)

    def test_a_module_that_stands_still_does_not_hold_the_driver_up(self, rig: Rig, driver_on: Any) -> None:
        start = time.monotonic()
        while driver_on.line.unsent < 100:  # nobody reads: until every buffer on the way is full
            driver_on.line.send(MessageId.TACTTIP_COMMAND, bytes(100))
            assert time.monotonic() - start < 10.0
        self.until_it_reads(rig, driver_on)

    def test_it_is_heard_after_a_driver_that_died_in_the_middle_of_a_frame(self, rig: Rig) -> None:
        rig.module.feed(encode_frame(0x30, 0, b"abcd")[:4], rig.loop.now())
        driver = self.driver(rig.address)
        rig.until(lambda: self.turn(driver), lambda: driver.line.connected or driver.line.problem)
        assert driver.line.problem is None
        driver.line.close()


class TcpContract(DriverContract):
    listen = "tcp:127.0.0.1:0"

    def test_the_device_goes_away_and_comes_back(self, rig: Rig, driver_on: Any) -> None:
        address = rig.address
        rig.server.close()
        deadline = time.monotonic() + 5.0
        longest = 0.0
        while driver_on.line.connected and time.monotonic() < deadline:
            start = time.monotonic()
            self.turn(driver_on)
            longest = max(longest, time.monotonic() - start)
        assert (driver_on.line.connected, driver_on.line.identity, driver_on.line.times_lost) == (False, None, 1)
        assert longest < 0.2  # losing a device holds no loop up
        driver_on.line.send(MessageId.HEATER_COMMAND, b"\0\0")  # to nobody: nothing happens
        while driver_on.line.problem is None and time.monotonic() < deadline:
            self.turn(driver_on)
        assert isinstance(driver_on.line.problem, DeviceAbsent)
        assert address in str(driver_on.line.problem)
        rig.server = serve_serial(rig.module, rig.loop, "tcp:" + address.removeprefix("socket://"), "module")
        rig.until(lambda: self.turn(driver_on), lambda: driver_on.line.connected)
        self.until_it_reads(rig, driver_on)

    def test_the_driver_may_come_first(self, rig: Rig) -> None:
        address = rig.address
        rig.server.close()
        driver = self.driver(address)
        deadline = time.monotonic() + 5.0
        while driver.line.problem is None and time.monotonic() < deadline:
            self.turn(driver)
        rig.server = serve_serial(rig.module, rig.loop, "tcp:" + address.removeprefix("socket://"), "module")
        rig.until(lambda: self.turn(driver), lambda: driver.line.connected)
        driver.line.close()


class PtyContract(DriverContract):
    listen = "pty"

    def test_the_device_goes_away(self, rig: Rig, driver_on: Any) -> None:
        rig.server.close()
        deadline = time.monotonic() + 5.0
        while driver_on.line.connected and time.monotonic() < deadline:
            self.turn(driver_on)
        assert (driver_on.line.connected, driver_on.line.times_lost) == (False, 1)
        # A terminal's name goes with it; the next one may have another. It is looked for under the old one.
        rig.server = serve_serial(rig.module, rig.loop, "pty", "module")
        if rig.address == driver_on.line.address:
            rig.until(lambda: self.turn(driver_on), lambda: driver_on.line.connected)


class Texture(DriverContract):
    kind, report = DeviceKind.TEXTURE_SENSOR, MessageId.TEXTURE_SAMPLES

    def module(self, finger: int = NUMBER) -> SerialModule:
        return TextureSensor(finger, time.monotonic())

    def driver(self, address: str, finger: str = FINGER) -> TextureDriver:
        return TextureDriver(finger, address)

    def turn(self, driver: TextureDriver) -> object:
        return driver.read(time.monotonic())

    def test_the_signal_comes_in_volts_and_in_order(self, rig: Rig, driver_on: TextureDriver) -> None:
        volts = texture_v(self.until_it_reads(rig, driver_on))
        assert volts == pytest.approx((np.arange(10) - 2048) * 10.0 / 2048)

    def test_a_late_tick_is_given_several_chunks_that_wait(self, rig: Rig, driver_on: TextureDriver) -> None:
        """With one chunk a tick, a site that had fallen behind would stay behind its sensor."""
        one = texture_v(self.until_it_reads(rig, driver_on))
        for _ in range(3):
            rig.turn()
        chunks = driver_on.read(time.monotonic())
        assert chunks is not None
        assert texture_v(chunks) == one * 3

    def test_what_waits_too_long_is_dropped_oldest_first(self, rig: Rig, driver_on: TextureDriver) -> None:
        for _ in range(100):
            rig.turn()
        while driver_on.read(0.0) is not None:
            assert len(driver_on.waiting) < 40


class Thermal(DriverContract):
    kind, report = DeviceKind.THERMAL_SENSOR, MessageId.THERMAL_READING

    def module(self, finger: int = NUMBER) -> SerialModule:
        module = ThermalSensor(finger, time.monotonic())
        module.measure(*counts_of(np.array([34.0, 24.0])).tolist())
        return module

    def driver(self, address: str, finger: str = FINGER) -> ThermalDriver:
        return ThermalDriver(finger, address)

    def turn(self, driver: ThermalDriver) -> object:
        return driver.read(time.monotonic())

    def test_readings_come_in_c(self, rig: Rig, driver_on: ThermalDriver) -> None:
        reading = self.until_it_reads(rig, driver_on)
        assert (reading.sensor_c, reading.ambient_c) == (pytest.approx(34.0, abs=0.01), pytest.approx(24.0, abs=0.01))
        assert reading.fault == ""

    @pytest.mark.parametrize("drive", [0.25, -1.0, 1.0, 0.0])
    def test_a_heater_drive_reaches_the_module_and_runs_out(
        self, rig: Rig, driver_on: ThermalDriver, drive: float
    ) -> None:
        driver_on.heat(time.monotonic(), drive)
        rig.until(lambda: self.turn(driver_on), lambda: not rig.module.flags)  # type: ignore[attr-defined]
        assert rig.module.drive == pytest.approx(drive)  # type: ignore[attr-defined]
        rig.until(lambda: self.turn(driver_on), lambda: rig.module.flags)  # type: ignore[attr-defined]
        assert rig.module.drive == 0.0  # type: ignore[attr-defined]

    def test_that_the_heater_is_off_is_confirmed_by_the_sensor_only(self, rig: Rig, driver_on: ThermalDriver) -> None:
        def heat(drive: float) -> None:
            if driver_on.read(time.monotonic()) is not None:
                driver_on.heat(time.monotonic(), drive)

        rig.until(lambda: heat(0.25), lambda: driver_on.unconfirmed(0.0) == "heater drive 0.25")
        stopped_s = time.monotonic()
        assert driver_on.unconfirmed(stopped_s) == "no report"
        rig.until(lambda: heat(0.0), lambda: driver_on.unconfirmed(stopped_s) == "")
        rig.module.stuck_permille = 300  # type: ignore[attr-defined]
        rig.module.measure(*counts_of(np.array([34.0, 24.0])).tolist())  # type: ignore[attr-defined]
        rig.until(lambda: heat(0.0), lambda: driver_on.unconfirmed(stopped_s) == "heater drive 0.3")
        rig.server.close()
        rig.until(lambda: heat(0.0), lambda: driver_on.unconfirmed(stopped_s) == "not connected")

    @pytest.mark.parametrize(("counts", "fault"), [(0, "shorted"), (4095, "open")])
    def test_a_broken_sensor_is_said(self, rig: Rig, driver_on: ThermalDriver, counts: int, fault: str) -> None:
        rig.module.measure(counts, 1000)  # type: ignore[attr-defined]
        found: list[str] = []
        rig.until(
            lambda: found.extend(r.fault for r in [driver_on.read(time.monotonic())] if r is not None),
            lambda: found and fault in found[-1],
        )


class Fingertip(DriverContract):
    kind, report = DeviceKind.TACTTIP, MessageId.TACTTIP_STATE

    def module(self, finger: int = NUMBER) -> SerialModule:
        module = TactTip(finger, time.monotonic())
        module.measure(ntc_counts(33.0), ntc_counts(20.0))
        return module

    def driver(self, address: str, finger: str = FINGER) -> TactTipDriver:
        return TactTipDriver(finger, address)

    def turn(self, driver: TactTipDriver) -> object:
        before = driver.measured_s
        driver.read(time.monotonic())
        return driver.plate_c if driver.measured_s > before else None

    def test_the_plates_temperature_comes_in_c(self, rig: Rig, driver_on: TactTipDriver) -> None:
        assert self.until_it_reads(rig, driver_on) == pytest.approx(33.0, abs=0.03)
        assert not driver_on.cut_out

    def test_drives_reach_the_module_and_run_out(self, rig: Rig, driver_on: TactTipDriver) -> None:
        module: Any = rig.module
        driver_on.drive(time.monotonic(), 5000.0, -0.5)
        rig.until(lambda: self.turn(driver_on), lambda: module.motor_mv > 0)
        assert module.peltier_drive == -0.5
        rig.until(lambda: self.turn(driver_on), lambda: module.flags)
        assert (module.motor_mv, module.peltier_permille) == (0, 0)

    def test_that_its_drives_are_off_is_confirmed_by_the_module_only(self, rig: Rig, driver_on: TactTipDriver) -> None:
        def drive(rpm: float, peltier: float) -> None:
            driver_on.read(time.monotonic())
            driver_on.drive(time.monotonic(), rpm, peltier)

        rig.until(lambda: drive(5000.0, -0.5), lambda: "Peltier drive -0.5" in driver_on.unconfirmed(0.0))
        assert driver_on.unconfirmed(0.0).startswith("motor at ")
        assert not driver_on.unconfirmed(0.0).startswith("motor at 0 mV")
        stopped_s = time.monotonic()
        assert driver_on.unconfirmed(stopped_s) == "no report"
        rig.until(lambda: drive(0.0, 0.0), lambda: driver_on.unconfirmed(stopped_s) == "")
        rig.module.stuck_permille = -400  # type: ignore[attr-defined]
        rig.module.measure(ntc_counts(33.0), ntc_counts(20.0))  # type: ignore[attr-defined]
        stuck = "motor at 0 mV, Peltier drive -0.4"
        rig.until(lambda: drive(0.0, 0.0), lambda: driver_on.unconfirmed(stopped_s) == stuck)
        rig.server.close()
        rig.until(lambda: drive(0.0, 0.0), lambda: driver_on.unconfirmed(stopped_s) == "not connected")

    def test_the_rate_budget_is_kept_and_switching_never_waits(self, rig: Rig, driver_on: TactTipDriver) -> None:
        def sent(t_s: float, rpm: float) -> int:
            before = driver_on.line._sequence
            driver_on.drive(t_s, rpm, 0.0)
            return (driver_on.line._sequence - before) & 0xFF

        assert 200 <= sum(sent(n * 1e-3, 3000.0 + n % 100 * 40) for n in range(1000)) <= 251  # another speed every ms
        assert sum(sent(2.0 + n * 1e-3, 3000.0 * (n % 2)) for n in range(10)) == 10  # off and on and off
        assert sum(sent(2.01 + n * 1e-3, 3000.0) for n in range(100)) <= 25  # while the motor comes to its speed
        assert 4 <= sum(sent(2.11 + n * 1e-3, 3000.0) for n in range(100)) <= 6  # nothing new: every 20 ms

    def test_a_cut_out_and_a_broken_ntc_are_seen(self, rig: Rig, driver_on: TactTipDriver) -> None:
        assert driver_on.cooling_fault == ""
        rig.module.measure(4095, 0)  # type: ignore[attr-defined]
        rig.until(lambda: self.turn(driver_on), lambda: driver_on.cut_out)
        assert math.isnan(driver_on.plate_c)
        assert driver_on.sensor_fault == "open circuit"
        assert driver_on.cooling_fault == "the hot side's thermistor: short circuit"


class TestTextureTcp(Texture, TcpContract): ...


class TestTexturePty(Texture, PtyContract): ...


class TestThermalTcp(Thermal, TcpContract): ...


class TestThermalPty(Thermal, PtyContract): ...


class TestTactTipTcp(Fingertip, TcpContract): ...


class TestTactTipPty(Fingertip, PtyContract): ...


def test_a_port_where_nobody_answers_is_absent() -> None:
    loop = SelectLoop()
    server = serve_serial(_Mute(), loop, "pty", "mute")
    driver = TactTipDriver("index", server.address)
    deadline = time.monotonic() + 5.0
    while driver.line.problem is None and time.monotonic() < deadline:
        loop.serve(0.01)
        driver.read(0.0)
    assert "no device answers IDENTIFY" in str(driver.line.problem)
    driver.line.close()
    server.close()


class _Mute:
    def feed(self, data: bytes, now_s: float) -> None:
        pass

    def take_output(self, now_s: float) -> bytes:
        return b""
