"""Driver of one finger's thermal sensor: plate and ambient readings in, heater drive out."""

from common.buses.drive_monitor import CommandMonitor, DriveMonitor
from common.buses.serial_driver import SerialDriver
from common.buses.serial_messages import DRIVE_FULL, DeviceFlag, DeviceKind, HeaterCommand, MessageId, ThermalReading
from common.buses.thermometry import COUNT_MAX, ssr_c
from common.buses.wiring import SYSTEM, Wiring
from common.faults.fault import Fault, FaultCode
from common.limits import GAP_S
from common.timing.standstill import HostClock
from common.wire.messages import ThermalReason
from remote_site.devices.sensor_frame import PlateReading

_CUT_OUT, _TIMEOUT = int(DeviceFlag.THERMAL_CUT_OUT), int(DeviceFlag.COMMAND_TIMEOUT)
MAX_RATE_K_S = 40.0
"""Maximum rate of a plate, K/s; no contact changes it faster."""
LEAST_JUMP_K = 0.3
"""Minimum change between two readings that counts as a jump, K: ten times the noise of a reading."""
FROZEN_S = 1.0
"""Maximum time for which a driven plate can repeat one count, s."""
DRIVEN = 0.3
"""Minimum heater drive of a driven plate, 0..1."""


class ThermalSensor(SerialDriver):
    """Reads at the sensor's own 100 Hz; the heater's command expires in the sensor after 100 ms."""

    KIND = DeviceKind.THERMAL_SENSOR
    BYTES_PER_S = 100 * 17

    def __init__(self, finger: str, address: str, clock: HostClock | None = None, wiring: Wiring = SYSTEM):
        """Open the sensor at `address` in the background; `clock` gives the times passed to `read`."""
        super().__init__(finger, address, clock, wiring)
        self.applied_permille = 0
        """Drive of the heater in the last reading, thousandths of full drive."""
        self.cut_out = False
        """Whether the sensor's own temperature limit holds its heater off."""
        self.disobeys: Fault | None = None
        """Fault of a heater whose drive was not commanded; None without one."""
        self._obeys = DriveMonitor(FaultCode.HEATER_UNASKED)
        self.commands = CommandMonitor()
        self._check = ThermometerCheck()
        self._permille = 0

    def read(self, t_s: float) -> PlateReading | None:
        """Return the newest reading since the last call, checked for plausibility at `t_s`, s; None without one."""
        readings = self.line.poll(ThermalReading)
        self.stood_still_s = self._standstill_s([reading.device_time_us for reading in readings])
        if not readings:
            return None
        newest = readings[-1]
        t_s += self.stood_still_s
        self.measured_s, self.applied_permille = t_s, newest.heater_permille
        self.commands.reported(t_s, not newest.flags & _TIMEOUT)
        self.disobeys = self._obeys.reported(t_s, newest.heater_permille)
        fault = self._check.step(t_s, newest.plate_counts, self._permille / DRIVE_FULL)
        # A sensor without a plausible reading cuts out, too; then only this finger goes without heat.
        self.cut_out = bool(newest.flags & _CUT_OUT) and not fault
        plate_c, ambient_c = ssr_c(newest.plate_counts), ssr_c(newest.ambient_counts)
        return PlateReading(plate_c, ambient_c, fault.code, newest.device_time_us, newest.heater_permille)

    def unconfirmed(self, since_s: float) -> str:
        """Return why the heater may be on; empty if the last reading came after `since_s`, s, and shows no drive."""
        if silence := self._no_report(since_s):
            return silence
        return f"heater drive {self.applied_permille / DRIVE_FULL:g}" if self.applied_permille else ""

    def heat(self, t_s: float, drive: float) -> None:
        """Send a heater drive, -1..1 of full power; positive heats."""
        self._permille = round(drive * DRIVE_FULL)
        self._obeys.commanded(t_s, self._permille)
        self.commands.commanded(t_s)
        self.line.send(MessageId.HEATER_COMMAND, HeaterCommand(self._permille).encode())


class ThermometerCheck:
    """Detects faults of the spreading-resistance thermometer: open, short, jumping, or frozen while driven."""

    def __init__(self) -> None:
        self._counts: int | None = None
        self._t_s = 0.0
        self._since_s = 0.0

    def step(self, t_s: float, counts: int, drive: float = 0.0) -> ThermalReason:
        """Return the fault of a reading of `counts`, 0..4095, at a heater drive of -1..1; NONE if it is plausible."""
        before, before_s = self._counts, self._t_s
        self._counts, self._t_s = counts, t_s
        if before is None or counts != before or abs(drive) < DRIVEN or t_s - before_s > GAP_S:
            self._since_s = t_s
        if not counts > 0:
            return ThermalReason.SENSOR_SHORTED
        if not counts < COUNT_MAX:
            return ThermalReason.SENSOR_OPEN
        if before is not None and t_s > before_s:
            change_k = abs(ssr_c(counts) - ssr_c(before))
            if change_k > max(MAX_RATE_K_S * (t_s - before_s), LEAST_JUMP_K):
                return ThermalReason.SENSOR_JUMPS
        if t_s - self._since_s > FROZEN_S:
            return ThermalReason.SENSOR_FROZEN
        return ThermalReason.NONE
