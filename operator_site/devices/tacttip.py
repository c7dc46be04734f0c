"""Driver of one TactTip fingertip module: motor and Peltier drives out, plate temperature and cooling in."""

import math

from common.buses.device_clock import DeviceClock
from common.buses.drive_monitor import DriveMonitor
from common.buses.serial_device import SerialDevice
from common.buses.serial_messages import (
    DRIVE_FULL,
    BadPayload,
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
"""Rate budget of a module: 250 commands a second; switching the motor on or off never waits."""
_BYTES_PER_S = 100 * 19
"""Of a module's reports on its line."""
_NEVER = -math.inf
_CUT_OUT, _STATE = DeviceFlag.THERMAL_CUT_OUT.value, MessageId.TACTTIP_STATE.value


class TactTip:
    """One module. `plate_c` is NaN where there is no believable reading."""

    def __init__(self, finger: str, address: str, clock: HostClock | None = None, wiring: Wiring = SYSTEM):
        """Open the module at `address` in the background; `clock` is the one that `read` is given times of."""
        self.line = SerialDevice(address, DeviceKind.TACTTIP, finger, wiring)
        self._finger = finger
        self.name = f"{finger} tacttip"
        self.damaged = 0
        self.plate_c = math.nan
        self.measured_s = _NEVER
        """When the last reading came, s; -inf before the first."""
        self.sensor_fault: FaultCode | None = None
        self.cooling_fault: Fault | None = None
        """What is wrong with the hot side or its thermistor; None when nothing."""
        self.stood_still_s = 0.0
        """For how long the host's clock stood still before the last `read`, as the module's own clock shows, s."""
        self.cut_out = False
        self.disobeys: Fault | None = None
        """An output that was not asked for; None when there is none."""
        self.faults: list[Fault] = []
        """What the last report says of these; empty when all is well."""
        self.applied = (0, 0)
        """What the module reported last that motor (mV) and Peltiers (thousandths) get."""
        self._sensor, self._hot_side = PlateSensor(), HotSide()
        self._motor, self._peltier = DriveMonitor(FaultCode.MOTOR_UNASKED), DriveMonitor(FaultCode.PELTIER_UNASKED)
        self._motor_drive = MotorDrive()
        self._turning = False
        self._witness = DeviceClock(self.line, clock)
        self._sent = TactTipCommand(0, 0)
        self._sent_s = _NEVER

    def read(self, t_s: float) -> None:
        """Take what came since the last call; it is judged by a time that counts what the host's clock did not."""
        self.stood_still_s = 0.0
        if self.line.silent:
            return
        states = self._states()
        if not states:
            return
        self.stood_still_s = self._witness.step([state.device_time_us for state in states])
        t_s += self.stood_still_s
        for state in states:
            reading = self._sensor.step(t_s, state.plate_counts)
            self.plate_c, self.sensor_fault = reading.plate_c, reading.fault
            self.cooling_fault = self._hot_side.step(t_s, state.hot_side_counts)
            self.cut_out = bool(state.flags & _CUT_OUT)
            self.applied = (state.motor_mv, state.peltier_permille)
            motor = self._motor.reported(t_s, state.motor_mv)
            peltier = self._peltier.reported(t_s, state.peltier_permille)
            self.disobeys = motor or peltier
            self.measured_s = t_s
        self.faults = self._faults()

    def _faults(self) -> list[Fault]:
        found = [
            None if self.sensor_fault is None else Fault(self.sensor_fault),
            self.cooling_fault,
            Fault(FaultCode.MODULE_CUT_OUT) if self.cut_out else None,
            self.disobeys,
        ]
        return [fault._replace(where=self._finger) for fault in found if fault is not None]

    def _states(self) -> list[TactTipState]:
        found: list[TactTipState] = []
        for frame in self.line.poll():
            if frame.message_id != _STATE:
                continue
            try:
                found.append(TactTipState.decode(frame.payload))
            except BadPayload:
                self.damaged += 1
        return found

    @property
    def unread_s(self) -> float:
        """How long the module has taken for the reports that wait to be read, s."""
        return self.line.unread_bytes() / _BYTES_PER_S

    def unconfirmed(self, since_s: float) -> str:
        """Why it is not certain that its drives are off; empty when the last report, after `since_s`, says so."""
        if not self.line.connected:
            return "not connected"
        if not self.measured_s > since_s:
            return "no report"
        motor, peltier = self.applied
        return f"motor at {motor} mV, Peltier drive {peltier / DRIVE_FULL:g}" if motor or peltier else ""

    def may_send(self, t_s: float, motor_rpm: float) -> bool:
        """Whether the module's rate budget leaves room for a command now; one that switches the motor never waits."""
        # Less than 0: the clock was set back.
        return not 0.0 <= t_s - self._sent_s < _LEAST_INTERVAL_S or (motor_rpm > 0.0) is not self._turning

    def drive(self, t_s: float, motor_rpm: float, peltier_drive: float) -> None:
        """Send drives within the module's rate budget, where they are news: motor speed in rpm, Peltier -1..1."""
        if not self.may_send(t_s, motor_rpm):
            return
        since_s, switches = t_s - self._sent_s, (motor_rpm > 0.0) is not self._turning
        command = self._motor_drive.step(t_s, motor_rpm)
        command.peltier_permille = round(peltier_drive * DRIVE_FULL)
        if command == self._sent and not switches and 0.0 <= since_s < COMMAND_REFRESH_S:
            return
        self.line.send(MessageId.TACTTIP_COMMAND, command.encode())
        self._sent, self._sent_s, self._turning = command, t_s, motor_rpm > 0.0
        self._motor.commanded(t_s, command.motor_mv)
        if command.pulse_us:
            self._motor.commanded(t_s, command.pulse_mv)
        self._peltier.commanded(t_s, command.peltier_permille)
