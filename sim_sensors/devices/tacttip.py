"""Emulate the TactTip's module, which drives vibration motor and Peltiers and reads the NTCs of plate and hot side."""

import math

from common.buses.serial_messages import (
    BadPayload,
    DeviceKind,
    Frame,
    MessageId,
    TactTipCommand,
    TactTipState,
)
from common.buses.thermometry import COUNT_MAX, NTC_B_K, NTC_R25_OHM, NTC_SERIES_OHM, ntc_c
from common.limits import PLATE_FAULT_C
from sim_sensors.devices.plate_module import CutOut, PlateModule

RANGE_C = (8.0, 80.0)
"""Range of temperatures that the device can reach, C (Kron & Schmidt 2003, section 2)."""


def ntc_counts(temperature_c: float) -> int:
    """Return the reading of the module's 12-bit converter with its NTC at a temperature, C."""
    ohm = NTC_R25_OHM * math.exp(NTC_B_K * (1.0 / (temperature_c + 273.15) - 1.0 / 298.15))
    return round(COUNT_MAX * ohm / (ohm + NTC_SERIES_OHM))


class TactTip(PlateModule):
    """Emulated module of one operator finger.

    Attributes:
        motor_mv: voltage at the motor at the module's last update, 0..3000 mV.
        plate_counts: present reading of the plate's converter, 0..4095.
        stuck_mv: fault of the motor's driver; this voltage overrides every command; None: sound.
        motor_switched: motor switches since the last `take_motor_switches`.
    """

    def __init__(self, finger: int, powered_s: float = 0.0) -> None:
        super().__init__(DeviceKind.TACTTIP, finger, f"TT{finger:04d}", RANGE_C, CutOut(PLATE_FAULT_C), powered_s)
        self.measure(ntc_counts(25.0), ntc_counts(25.0))
        self.motor_switched: list[tuple[float, int]] = []
        self._motor_mv = self._pulse_mv = 0
        self._pulse_from_s = self._pulse_until_s = -math.inf
        self._turn_s = math.inf
        self._pulse_number = -1  # none yet
        self.motor_mv = 0
        self.stuck_mv: int | None = None

    def motor_v(self, from_s: float, to_s: float) -> float:
        """Return the mean voltage at the motor between two times, by the last command, V.

        The world may lag the arrival of commands a little; a pulse keeps its commanded time.
        """
        if self.stuck_mv is not None:
            return 1e-3 * self.stuck_mv
        if self._pulse_until_s <= from_s:
            return 1e-3 * self._motor_mv
        pulse_s = max(0.0, min(to_s, self._pulse_until_s) - max(from_s, self._pulse_from_s))
        share = pulse_s / (to_s - from_s)
        return 1e-3 * (share * self._pulse_mv + (1.0 - share) * self._motor_mv)

    def measure(self, plate_counts: int, hot_side_counts: int) -> None:
        """Take the present readings of the two converters, 0..4095."""
        self.plate_counts, self._hot_side_counts = plate_counts, hot_side_counts
        # An open or shorted NTC measures nothing; the module must not drive without a measurement.
        readable = 0 < plate_counts < COUNT_MAX
        self._measure(ntc_c(plate_counts) if readable else math.nan)

    def take_motor_switches(self) -> list[tuple[float, int]]:
        """Return times (s) and voltages (mV) at which the motor was switched on or off since the last call."""
        switched, self.motor_switched = self.motor_switched, []
        return switched

    def _obey(self, frame: Frame, now_s: float) -> None:
        if frame.message_id != MessageId.TACTTIP_COMMAND:
            raise BadPayload(f"TactTip: no command {frame.message_id:#04x}")
        command = TactTipCommand.decode(frame.payload)
        self._watchdog.obeyed(now_s)
        self._drive_motor(command.motor_mv, now_s)
        self._pulse(command, now_s)
        self._ask(command.peltier_permille)

    def _run(self, now_s: float) -> None:
        if self._watchdog.expires(now_s):
            self._drive_motor(0, self._watchdog.limit_s)
            self._pulse_until_s = min(self._pulse_until_s, self._watchdog.limit_s)
            self._ask(0)
        self._turn(now_s)
        if self._reports.due(now_s):
            measured = (self.plate_counts, self._hot_side_counts)
            applied = (self.motor_mv, self.drive_permille)
            state = TactTipState(self._time_us(now_s), *measured, self.flags, *applied)
            self._say(MessageId.TACTTIP_STATE, state.encode())

    def _next_s(self) -> float:
        return min(super()._next_s(), self._turn_s)

    def _drive_motor(self, motor_mv: int, now_s: float) -> None:
        if bool(motor_mv) != bool(self._motor_mv):
            self.motor_switched.append((now_s, motor_mv))
        self._motor_mv = motor_mv

    def _pulse(self, command: TactTipCommand, now_s: float) -> None:
        """Begin a pulse with a new number; a running pulse continues unless the command contains no pulse."""
        if not command.pulse_us:
            self._pulse_until_s = -math.inf
        elif command.pulse_number != self._pulse_number:
            self._pulse_mv, self._pulse_from_s = command.pulse_mv, now_s
            self._pulse_until_s = now_s + 1e-6 * command.pulse_us
        self._pulse_number = command.pulse_number
        self._turn(now_s)

    def _turn(self, now_s: float) -> None:
        pulsed = self._pulse_from_s <= now_s < self._pulse_until_s
        commanded_mv = self._pulse_mv if pulsed else self._motor_mv
        self.motor_mv = commanded_mv if self.stuck_mv is None else self.stuck_mv
        if now_s < self._pulse_until_s:
            self._turn_s = self._pulse_until_s if pulsed else self._pulse_from_s
        else:
            self._turn_s = math.inf
