"""Driver of one finger's thermal sensor: plate and ambient readings in, heater drive out."""

import math

from common.buses.device_clock import DeviceClock
from common.buses.drive_monitor import DriveMonitor
from common.buses.serial_device import SerialDevice
from common.buses.serial_messages import (
    DRIVE_FULL,
    BadPayload,
    DeviceFlag,
    DeviceKind,
    HeaterCommand,
    MessageId,
    ThermalReading,
)
from common.buses.thermometry import ssr_c
from common.buses.wiring import SYSTEM, Wiring
from common.faults.fault import Fault, FaultCode
from common.recording.recorded_row import Row, Whole
from common.timing.standstill import HostClock
from remote_site.devices.thermometer_check import ThermometerCheck

_READING = int(MessageId.THERMAL_READING)
_CUT_OUT = int(DeviceFlag.THERMAL_CUT_OUT)
_BYTES_PER_S = 100 * 17
"""Of a sensor's readings on its line."""


class PlateReading(Row):
    """One reading of a thermal sensor.

    Attributes:
        sensor_c: plate, C.
        ambient_c: ambient, C.
        fault: code of the `ThermalReason` that makes it implausible; empty when nothing does.
        device_us: when it was taken, by the sensor's own clock, us modulo 2^32.
        heater_permille: what the heater got then, thousandths of full drive.
    """

    sensor_c: float
    ambient_c: float
    fault: str
    device_us: Whole
    heater_permille: Whole


class ThermalSensor:
    """Reads at the sensor's own 100 Hz; the heater's command expires in the sensor after 100 ms."""

    def __init__(self, finger: str, address: str, clock: HostClock | None = None, wiring: Wiring = SYSTEM):
        """Open the sensor at `address` in the background; `clock` is the one that `read` is given times of."""
        self.line = SerialDevice(address, DeviceKind.THERMAL_SENSOR, finger, wiring)
        self.damaged = 0
        self.measured_s = -math.inf
        """When the last reading came, s; -inf before the first."""
        self.stood_still_s = 0.0
        """For how long the host's clock stood still before the last `read`, as the sensor's own clock shows, s."""
        self.applied_permille = 0
        """What the sensor reported last that its heater gets."""
        self.cut_out = False
        """Whether the sensor's own temperature limit holds its heater off."""
        self.disobeys: Fault | None = None
        """An output of the heater that was not asked for; None when there is none."""
        self._obeys = DriveMonitor(FaultCode.HEATER_UNASKED)
        self._plausible = ThermometerCheck()
        self._permille = 0
        self._witness = DeviceClock(self.line, clock)

    def read(self, t_s: float) -> PlateReading | None:
        """The newest reading since the last call, judged for plausibility at time `t_s`; None without one.

        It is judged by a time that counts what the host's clock did not.
        """
        if self.line.silent:
            self.stood_still_s = 0.0
            return None
        newest: ThermalReading | None = None
        reported_us: list[int] = []
        for frame in self.line.poll():
            if frame.message_id != _READING:
                continue
            try:
                newest = ThermalReading.decode(frame.payload)
            except BadPayload:
                self.damaged += 1
            else:
                reported_us.append(newest.device_time_us)
        self.stood_still_s = self._witness.step(reported_us)
        if newest is None:
            return None
        t_s += self.stood_still_s
        self.measured_s, self.applied_permille = t_s, newest.heater_permille
        self.disobeys = self._obeys.reported(t_s, newest.heater_permille)
        fault = self._plausible.step(t_s, newest.plate_counts, self._permille / DRIVE_FULL)
        # A plate that cannot be measured is cut off as well; that finger goes without heat, and the others go on.
        self.cut_out = bool(newest.flags & _CUT_OUT) and not fault
        plate_c, ambient_c = ssr_c(newest.plate_counts), ssr_c(newest.ambient_counts)
        return PlateReading(plate_c, ambient_c, fault.code, newest.device_time_us, newest.heater_permille)

    @property
    def unread_s(self) -> float:
        """How long the sensor has taken for the readings that wait to be read, s."""
        return self.line.unread_bytes() / _BYTES_PER_S

    def unconfirmed(self, since_s: float) -> str:
        """Why it is not certain that the heater is off; empty when the last reading, after `since_s`, says so."""
        if not self.line.connected:
            return "not connected"
        if not self.measured_s > since_s:
            return "no report"
        return f"heater drive {self.applied_permille / DRIVE_FULL:g}" if self.applied_permille else ""

    def heat(self, t_s: float, drive: float) -> None:
        """Send a heater drive, -1..1 of full power; positive heats."""
        self._permille = round(drive * DRIVE_FULL)
        self._obeys.commanded(t_s, self._permille)
        self.line.send(MessageId.HEATER_COMMAND, HeaterCommand(self._permille).encode())
