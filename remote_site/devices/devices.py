"""Reads and writes all devices of the remote site. Only the gate's output is written."""

import math

from common.buses.ready_lines import ReadyLines
from common.buses.wiring import SYSTEM, Wiring
from common.config.site_models import RemoteConfig
from common.faults.fault import TELEMANIPULATOR, Fault, FaultCode
from common.fingers import FINGERS
from common.limits import GAP_S
from common.timing.standstill import HostClock
from common.timing.tick_age import TickAge
from remote_site.devices.patient_switch import PatientSwitch
from remote_site.devices.sensor_frame import HandPlace, PlateReading, SensorFrame
from remote_site.devices.telemanipulator import Telemanipulator
from remote_site.devices.texture_sensor import TextureSensor
from remote_site.devices.thermal_sensor import ThermalSensor
from remote_site.safety.patient_stop import SwitchReading
from remote_site.safety.setpoints import GatedCommand

_NEVER = -math.inf


class RemoteDevices:
    """Opens every device in the background; reading and writing never block."""

    def __init__(self, config: RemoteConfig, clock: HostClock | None = None, wiring: Wiring = SYSTEM):
        """Open the devices through `wiring`; `clock` gives the times of `read`."""
        clock = HostClock() if clock is None else clock
        self.telemanipulator = Telemanipulator(config.telemanipulator, config.fingers, clock, wiring)
        self.texture = {
            FINGERS.index(f): TextureSensor(f, address, clock, wiring) for f, address in config.texture.items()
        }
        self.thermal = {
            FINGERS.index(f): ThermalSensor(f, address, clock, wiring) for f, address in config.thermal_sensors.items()
        }
        self.sensor_c, self.ambient_c = [math.nan] * len(FINGERS), [math.nan] * len(FINGERS)
        self.sensor_s = [_NEVER] * len(FINGERS)
        """Last reading of each sensor plate and of the air at it, C, NaN where implausible, and its arrival time, s."""
        switch = config.patient_switch
        self.patient_switch = None if switch is None else PatientSwitch(switch.port, wiring)
        sensors: list[TextureSensor | ThermalSensor | PatientSwitch] = [*self.texture.values(), *self.thermal.values()]
        if self.patient_switch is not None:
            sensors.append(self.patient_switch)
        self._sensors = sensors
        self._lines = [sensor.line for sensor in sensors]
        self._ready = ReadyLines([self.telemanipulator.line, *self._lines])
        self.tick = TickAge(clock, self._unread_s)

    def _unread_s(self) -> float:
        """Return the time that devices took to send the unread data, s."""
        if not self._ready.look() and self.telemanipulator.line.drained:
            return 0.0
        return max(device.unread_s for device in (self.telemanipulator, *self._sensors))

    def missing(self) -> str:
        """Return which device is missing and why; empty when none is."""
        if not self.telemanipulator.line.connected:
            return f"telemanipulator: {self.telemanipulator.line.problem or 'opening'}"
        for line in self._lines:
            if not line.connected:
                return f"{line.name}: {line.problem or 'opening'}"
        began_s = self.tick.began_s
        for sensor in self._sensors:
            if not began_s - sensor.measured_s <= GAP_S:
                return f"{sensor.line.name}: the line is open, but no reports come"
        if not began_s - self.telemanipulator.measured.oldest_s <= GAP_S:
            return f"telemanipulator: CAN {self.telemanipulator.line.address} is open, but no measurements come"
        if self.telemanipulator.commands.deaf:
            return "telemanipulator: it reports, but receives no set-points"
        for sensor in self.thermal.values():
            if sensor.commands.deaf:
                return f"{sensor.line.name}: it reports, but receives no commands"
        return ""

    def problems(self) -> list[Exception]:
        """Return the reasons why devices are not open, of those that have failed at least once."""
        lines = [self.telemanipulator.line.problem, *(line.problem for line in self._lines)]
        return [problem for problem in lines if problem is not None]

    def read(self, t_s: float, hand: HandPlace | None = None) -> SensorFrame:
        """Read all devices while the fingers follow `hand`.

        `tick` counts a standstill of the host that their reports show; the frame's time is after it.
        """
        self.tick.begin(t_s)
        self._ready.look()
        texture: list[bytes | None] = [None] * len(FINGERS)
        plates: list[PlateReading | None] = [None] * len(FINGERS)
        stood_still_s = 0.0
        for finger, texture_sensor in self.texture.items():
            if texture_sensor.waiting or texture_sensor.line.readable is not False:
                texture[finger] = texture_sensor.read(t_s)
                stood_still_s = max(stood_still_s, texture_sensor.stood_still_s)
        for finger, thermal_sensor in self.thermal.items():
            if thermal_sensor.line.readable is not False:
                plate = plates[finger] = thermal_sensor.read(t_s)
                stood_still_s = max(stood_still_s, thermal_sensor.stood_still_s)
                if plate is not None:
                    self.sensor_c[finger] = math.nan if plate.fault else plate.sensor_c
                    self.ambient_c[finger] = math.nan if plate.fault else plate.ambient_c
                    self.sensor_s[finger] = thermal_sensor.measured_s
        measured = self.telemanipulator.read(t_s, stood_still=stood_still_s > 0.0)
        self.tick.stood_still(max(stood_still_s, self.telemanipulator.stood_still_s))
        t_s = self.tick.began_s
        if self.patient_switch is not None:
            self.patient_switch.read(t_s)
        # An old force counts as none: no contact is known, and none is rendered.
        known = t_s - measured.oldest_s <= GAP_S
        force_n = measured.force_n if known else (0.0,) * len(FINGERS)
        return SensorFrame(t_s, measured.x_m, measured.y_m, measured.z_m, force_n, tuple(texture), tuple(plates), hand)

    def write(self, command: GatedCommand, sensed: SensorFrame) -> None:
        """Send set-points each tick, and heater drives at each sensor's own rate.

        Nothing is sent if the tick that read the devices is too old.
        """
        if command.ready and self.tick.in_time():
            self.telemanipulator.move(sensed.time_s, command.x_m, command.y_m, command.z_m, released=command.released)
        for finger, sensor in self.thermal.items():
            if sensed.plates[finger] is not None and self.tick.in_time():
                sensor.heat(sensed.time_s, command.heater_drive[finger])

    @property
    def follows(self) -> bool:
        """Whether the telemanipulator reports that set-points reach it; else it has stopped by itself."""
        following = self.telemanipulator.following
        reached = following.hand_alive and following.heights_alive
        return reached and self.tick.began_s - following.reported_s <= GAP_S

    def switch_reading(self, t_s: float) -> SwitchReading | None:
        """Return what is known of the patient's stop switch at `t_s`, s; None at a site without one."""
        return None if self.patient_switch is None else self.patient_switch.reading(t_s)

    def pain_reading(self, t_s: float) -> float | None:
        """Return the patient's pain answer at `t_s`, s, 0..10; NaN while it is too old, None without a slider."""
        return None if self.patient_switch is None else self.patient_switch.pain_reading(t_s)

    @property
    def patient_presses(self) -> bool:
        """Whether the patient presses the stop switch now."""
        return self.patient_switch is not None and self.patient_switch.pressed

    def unconfirmed(self, since_s: float) -> dict[str, str]:
        """Return why each device's outputs may not be off since `since_s`, s; empty where its report says so."""
        found = {"telemanipulator": self.telemanipulator.unconfirmed(since_s)}
        for sensor in self.thermal.values():
            found[sensor.line.name] = sensor.unconfirmed(since_s)
        return found

    def faults(self) -> list[Fault]:
        """Return the faults of all devices."""
        found = [fault._replace(device=TELEMANIPULATOR) for fault in self.telemanipulator.faults(self.tick.began_s)]
        for finger, sensor in self.thermal.items():
            if not (sensor.cut_out or sensor.disobeys) or self.tick.began_s - sensor.measured_s > GAP_S:
                continue
            if sensor.cut_out:
                found.append(Fault(FaultCode.SENSOR_CUT_OUT, FINGERS[finger]))
            if sensor.disobeys:
                found.append(sensor.disobeys._replace(where=FINGERS[finger]))
        return found

    def figures(self) -> dict[str, object]:
        """Return the figures of each device for the status file."""
        found: dict[str, object] = {line.name: line.figures() for line in self._lines}
        return {"telemanipulator": self.telemanipulator.line.figures(), **found}

    def close(self) -> None:
        """Close every device; its own time-out turns its outputs off."""
        self.telemanipulator.line.close()
        for line in self._lines:
            line.close()
