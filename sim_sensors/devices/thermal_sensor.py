"""Emulate the remote thermal sensor's module, which reads plate and ambient temperature and drives the Peltier."""

from common.buses.serial_framing import Frame
from common.buses.serial_messages import (
    DRIVE_FULL,
    BadPayload,
    DeviceFlag,
    DeviceKind,
    HeaterCommand,
    Identity,
    MessageId,
    ThermalReading,
)
from common.buses.thermometry import ssr_c
from common.limits import SENSOR_PLATE_C
from sim_sensors.devices.serial_module import CommandWatchdog, CutOut, ReportClock, SerialModule

RATE_HZ = 100
LOOK_AHEAD_S = 0.4
"""Prediction time of the cut-out, s; at full drive, the plate leads its sensor by more than a kelvin."""
RANGE_C = (0.0, 60.0)


class ThermalSensor(SerialModule):
    """Emulated module of one remote finger's thermal sensor.

    Attributes:
        drive_permille: drive of the heating Peltier, signed thousandths of full drive.
        stuck_permille: fault of the command path; this drive overrides every command and the time-out. Only the
            cut-out behind it still acts. In force from the next measurement; None: sound.
        flags: `DeviceFlag` bits of the next reading.
    """

    def __init__(self, finger: int, powered_s: float = 0.0) -> None:
        super().__init__(
            Identity(DeviceKind.THERMAL_SENSOR, finger, f"TH{finger:04d}", 1, RATE_HZ, *RANGE_C), powered_s
        )
        self._watchdog = CommandWatchdog()
        self._cut_out = CutOut(SENSOR_PLATE_C, LOOK_AHEAD_S)
        self._reports = ReportClock(1.0 / RATE_HZ, powered_s)
        self._asked = 0
        self._plate_counts = 0
        self._ambient_counts = 0
        self._cut_out.measure(ssr_c(0))
        self.drive_permille = 0
        self.stuck_permille: int | None = None

    @property
    def drive(self) -> float:
        """Drive of the Peltier, -1..1 of full drive; above 0 heats the plate."""
        return self.drive_permille / DRIVE_FULL

    @property
    def flags(self) -> int:
        """Present status bits."""
        timeout = DeviceFlag.COMMAND_TIMEOUT if self._watchdog.expired else 0
        return timeout | (DeviceFlag.THERMAL_CUT_OUT if self._cut_out.tripped else 0)

    def measure(self, plate_counts: int, ambient_counts: int) -> None:
        """Take the present readings of the two converters, 0..4095."""
        self._plate_counts, self._ambient_counts = plate_counts, ambient_counts
        self._cut_out.measure(ssr_c(plate_counts))
        self._limit()

    def _obey(self, frame: Frame, now_s: float) -> None:
        if frame.message_id != MessageId.HEATER_COMMAND:
            raise BadPayload(f"thermal sensor: no command {frame.message_id:#04x}")
        self._asked = HeaterCommand.decode(frame.payload).drive_permille
        self._watchdog.obeyed(now_s)
        self._limit()

    def _run(self, now_s: float) -> None:
        if self._watchdog.expires(now_s):
            self._asked = 0
            self._limit()
        if self._reports.due(now_s):
            measured = (self._plate_counts, self._ambient_counts)
            reading = (self._time_us(now_s) & 0xFFFFFFFF, *measured, self.flags, self.drive_permille)
            self._say(MessageId.THERMAL_READING, ThermalReading.LAYOUT.pack(*reading))

    def _next_s(self) -> float:
        return min(self._reports.due_s, self._watchdog.due_s)

    def _limit(self) -> None:
        asked = self._asked if self.stuck_permille is None else self.stuck_permille
        allowed = self._cut_out.allows(asked)
        self.drive_permille = asked if allowed else 0
