"""Driver of one finger's thermal sensor: plate and ambient readings in, heater drive out."""

from dataclasses import dataclass

from common.serial_line import SerialLine
from common.serial_messages import (
    DRIVE_FULL,
    BadPayload,
    DeviceKind,
    HeaterCommand,
    MessageId,
    ThermalReading,
)
from common.thermometry import ssr_c
from remote_site.ssr_plausibility import SsrPlausibility


@dataclass(frozen=True, slots=True)
class PlateReading:
    """One reading of a thermal sensor; `fault` says what makes it implausible, empty when nothing does."""

    sensor_c: float
    ambient_c: float
    fault: str


class ThermalSensor:
    """Reads at the sensor's own 100 Hz; the heater's command expires in the sensor after 100 ms."""

    def __init__(self, finger: str, address: str):
        """Open the sensor at `address` in the background."""
        self.line = SerialLine(address, DeviceKind.THERMAL_SENSOR, finger)
        self.damaged = 0
        self._plausible = SsrPlausibility()
        self._permille = 0

    def read(self, t_s: float) -> PlateReading | None:
        """The newest reading since the last call, judged for plausibility at time `t_s`; None without one."""
        newest: ThermalReading | None = None
        for frame in self.line.poll():
            if frame.message_id != MessageId.THERMAL_READING:
                continue
            try:
                newest = ThermalReading.decode(frame.payload)
            except BadPayload:
                self.damaged += 1
        if newest is None:
            return None
        fault = self._plausible.step(t_s, newest.plate_counts, self._permille / DRIVE_FULL)
        return PlateReading(ssr_c(newest.plate_counts), ssr_c(newest.ambient_counts), fault or "")

    def heat(self, drive: float) -> None:
        """Send a heater drive, -1..1 of full power; positive heats."""
        self._permille = round(drive * DRIVE_FULL)
        self.line.send(MessageId.HEATER_COMMAND, HeaterCommand(self._permille).encode())
