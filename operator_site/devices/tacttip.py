"""Drives one TactTip fingertip module: sends motor and Peltier drives, reads plate temperature and cooling."""

import math

from common.buses.drive_monitor import CommandMonitor, DriveMonitor
from common.buses.serial_driver import SerialDriver
from common.buses.serial_messages import (
    DRIVE_FULL,
    DeviceFlag,
    DeviceKind,
    MessageId,
    TactTipCommand,
    TactTipState,
)
from common.buses.wiring import SYSTEM, Wiring
from common.faults.fault import Fault, FaultCode
from common.timing.standstill import HostClock
from common.timing.timeouts import COMMAND_REFRESH_S
from operator_site.devices.hot_side import HotSide
from operator_site.devices.ntc import PlateSensor
from operator_site.vibration.motor_drive import MotorDrive

_LEAST_INTERVAL_S = 0.004
"""Minimum time between two commands, s; switching the motor on or off never waits."""
_CUT_OUT, _TIMEOUT = DeviceFlag.THERMAL_CUT_OUT.value, DeviceFlag.COMMAND_TIMEOUT.value


class TactTip(SerialDriver):
    """One module. `plate_c`, C, is NaN without a plausible reading."""

    KIND = DeviceKind.TACTTIP
    BYTES_PER_S = 100 * 19

    def __init__(self, finger: str, address: str, clock: HostClock | None = None, wiring: Wiring = SYSTEM):
        """Open the module at `address` in the background; `clock` gives the times of `read`."""
        super().__init__(finger, address, clock, wiring)
        self._finger = finger
        self.name = f"{finger} tacttip"
        self.plate_c = math.nan
        self.faults: list[Fault] = []
        """All faults as of the last report."""
        self.applied = (0, 0)
        """Last reported drives of the motor, mV, and of the Peltiers, thousandths."""
        self._sensor, self._hot_side = PlateSensor(), HotSide()
        self._motor, self._peltier = DriveMonitor(FaultCode.MOTOR_UNASKED), DriveMonitor(FaultCode.PELTIER_UNASKED)
        self.commands = CommandMonitor()
        self._motor_drive = MotorDrive()
        self._turning = False
        self._sent: tuple[int, ...] = ()
        """Values of the last command; empty before the first."""
        self._sent_s = -math.inf

    def read(self, t_s: float) -> None:
        """Take the reports since the last call at `t_s`, s; the time of a standstill is added."""
        states = self.line.poll(TactTipState)
        self.stood_still_s = self._standstill_s([state.device_time_us for state in states])
        t_s += self.stood_still_s
        for state in states:
            reading = self._sensor.step(t_s, state.plate_counts)
            self.plate_c, self.measured_s = reading.plate_c, t_s
            self.applied = (state.motor_mv, state.peltier_permille)
            self.commands.reported(t_s, not state.flags & _TIMEOUT)
            motor = self._motor.reported(t_s, state.motor_mv)
            peltier = self._peltier.reported(t_s, state.peltier_permille)
            found = [
                None if reading.fault is None else Fault(reading.fault),
                self._hot_side.step(t_s, state.hot_side_counts),
                Fault(FaultCode.MODULE_CUT_OUT) if state.flags & _CUT_OUT else None,
                motor or peltier,
            ]
            self.faults = [fault._replace(where=self._finger) for fault in found if fault is not None]

    def unconfirmed(self, since_s: float) -> str:
        """Return why its drives may still be on; empty when a report after `since_s`, s, excludes it."""
        if silence := self._no_report(since_s):
            return silence
        motor, peltier = self.applied
        return f"motor at {motor} mV, Peltier drive {peltier / DRIVE_FULL:g}" if motor or peltier else ""

    def may_send(self, t_s: float, motor_rpm: float) -> bool:
        """Return whether a command may be sent now by its rate limit; one that switches the motor never waits."""
        # Less than 0: the clock was set back.
        return not 0.0 <= t_s - self._sent_s < _LEAST_INTERVAL_S or (motor_rpm > 0.0) is not self._turning

    def drive(self, t_s: float, motor_rpm: float, peltier_drive: float) -> None:
        """Send changed drives within the rate limit: motor speed, rpm, and Peltier drive, -1..1."""
        if not self.may_send(t_s, motor_rpm):
            return
        since_s, switches = t_s - self._sent_s, (motor_rpm > 0.0) is not self._turning
        motor, peltier_permille = self._motor_drive, round(peltier_drive * DRIVE_FULL)
        motor.step(t_s, motor_rpm)
        command = (motor.hold_mv, peltier_permille, *motor.pulse)
        if command == self._sent and not switches and 0.0 <= since_s < COMMAND_REFRESH_S:
            return
        self.line.send(MessageId.TACTTIP_COMMAND, TactTipCommand(*command).encode())
        self._sent, self._sent_s, self._turning = command, t_s, motor_rpm > 0.0
        self.commands.commanded(t_s)
        self._motor.commanded(t_s, motor.hold_mv)
        pulse_mv, pulse_us, _ = motor.pulse
        if pulse_us:
            self._motor.commanded(t_s, pulse_mv)
        self._peltier.commanded(t_s, peltier_permille)
