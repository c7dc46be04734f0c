"""Base of the simulated modules that drive a plate: periodic reports, command watchdog, and temperature limit."""

import math

from common.buses.serial_messages import DRIVE_FULL, DeviceFlag, DeviceKind, Identity
from common.limits import MODULE_TIMEOUT_S
from sim_sensors.devices.serial_module import SerialModule

RATE_HZ = 100
_EARLY_S = 1e-9
"""Tolerance of a report's time, s; times are sums of steps and carry rounding errors."""


class ReportClock:
    """Clock of a periodic report; after a pause of the module, one report is due, not a burst.

    Attributes:
        due_s: time from which a report is due, s.
    """

    def __init__(self, period_s: float, start_s: float) -> None:
        self._period_s = period_s
        self._due_s = start_s
        self.due_s = start_s - _EARLY_S

    def due(self, now_s: float) -> bool:
        """Return whether a report is due at `now_s`; if so, the next one is due a period later."""
        if now_s < self.due_s:
            return False
        self._due_s = max(self._due_s, now_s - self._period_s) + self._period_s
        self.due_s = self._due_s - _EARLY_S
        return True


class CommandWatchdog:
    """Watchdog of the commands, armed from power-up: 100 ms after the last valid command the drives go to 0.

    Attributes:
        expired: whether no command is in force.
        limit_s: time at which the latest command expires, s.
        due_s: the same while a command is in force, otherwise infinite.
    """

    def __init__(self) -> None:
        self.expired = True
        self.limit_s = 0.0
        self.due_s = math.inf

    def obeyed(self, now_s: float) -> None:
        """Start the time again for a valid command at `now_s`."""
        self.expired = False
        self.limit_s = self.due_s = now_s + MODULE_TIMEOUT_S

    def expires(self, now_s: float) -> bool:
        """Return whether the command in force expires by `now_s`; each expiry returns True only once."""
        if now_s < self.due_s:
            return False
        self.expired = True
        self.due_s = math.inf
        return True


class CutOut:
    """Temperature limit inside a module: it interrupts the supply of a drive by the module's own measurement.

    It acts behind the command path, so it also protects against a stuck driver. It releases 1 K below the limit, and
    only while the drive that it interrupts does not heat.
    """

    RELEASE_K = 1.0
    PERIOD_S = 0.010
    """Time between two measurements, s."""
    RATE_LAG_S = 0.1
    FASTEST_K_S = 8.0
    """Fastest possible heating of a plate, K/s; a faster rise of the reading is a jump and is limited to this."""

    def __init__(self, limit_c: float, look_ahead_s: float = 0.0) -> None:
        """Limit a plate to `limit_c` by its predicted temperature in `look_ahead_s`, because its sensor lags."""
        self._limit_c = limit_c
        self._look_ahead_s = look_ahead_s
        self._measured_c = math.nan
        self._rate_k_s = 0.0
        self.tripped = False

    def measure(self, measured_c: float) -> None:
        """Take a measurement, C, once each PERIOD_S; NaN if there is none."""
        rate = (measured_c - self._measured_c) / self.PERIOD_S
        known = math.isfinite(rate)
        rate = max(-self.FASTEST_K_S, min(self.FASTEST_K_S, rate))
        self._rate_k_s += (rate - self._rate_k_s) * self.PERIOD_S / self.RATE_LAG_S if known else -self._rate_k_s
        self._measured_c = measured_c

    def allows(self, drive_permille: int) -> bool:
        """Return whether the commanded drive may pass; a missing measurement trips the cut-out."""
        ahead_c = self._measured_c + self._look_ahead_s * max(0.0, self._rate_k_s)
        if not ahead_c < self._limit_c:
            self.tripped = True
        elif drive_permille <= 0 and ahead_c < self._limit_c - self.RELEASE_K:
            self.tripped = False
        return not self.tripped


class PlateModule(SerialModule):
    """Base of a module with a plate on Peltier elements.

    Attributes:
        drive_permille: drive of the Peltiers, signed thousandths of full drive.
        stuck_permille: fault of the command path; this drive overrides every command and the time-out. Only the
            cut-out behind it still acts. In force from the next measurement; None: sound.
    """

    def __init__(
        self,
        kind: DeviceKind,
        finger: int,
        serial: str,
        range_c: tuple[float, float],
        cut_out: CutOut,
        powered_s: float,
    ) -> None:
        super().__init__(Identity(kind, finger, serial, 1, RATE_HZ, *range_c), powered_s)
        self.drive_permille = 0
        self.stuck_permille: int | None = None
        self._watchdog = CommandWatchdog()
        self._cut_out = cut_out
        self._reports = ReportClock(1.0 / RATE_HZ, powered_s)
        self._asked_permille = 0

    @property
    def drive(self) -> float:
        """Drive of the Peltiers, -1..1 of full drive; above 0 heats the plate."""
        return self.drive_permille / DRIVE_FULL

    @property
    def flags(self) -> int:
        """`DeviceFlag` bits of the next report."""
        timeout = DeviceFlag.COMMAND_TIMEOUT if self._watchdog.expired else 0
        return timeout | (DeviceFlag.THERMAL_CUT_OUT if self._cut_out.tripped else 0)

    def _next_s(self) -> float:
        return min(self._reports.due_s, self._watchdog.due_s)

    def _ask(self, permille: int) -> None:
        """Set the commanded drive."""
        self._asked_permille = permille
        self._limit()

    def _measure(self, plate_c: float) -> None:
        """Take the plate's temperature, C; NaN if there is none."""
        self._cut_out.measure(plate_c)
        self._limit()

    def _limit(self) -> None:
        asked = self._asked_permille if self.stuck_permille is None else self.stuck_permille
        self.drive_permille = asked if self._cut_out.allows(asked) else 0
