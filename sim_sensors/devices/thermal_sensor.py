"""Emulate the remote thermal sensor's module, which reads plate and ambient temperature and drives the Peltier."""

from common.buses.serial_messages import BadPayload, DeviceKind, Frame, HeaterCommand, MessageId, ThermalReading
from common.buses.thermometry import ssr_c
from common.limits import SENSOR_PLATE_C
from sim_sensors.devices.plate_module import CutOut, PlateModule

LOOK_AHEAD_S = 0.4
"""Prediction time of the cut-out, s; at full drive, the plate leads its sensor by more than a kelvin."""
RANGE_C = (0.0, 60.0)


class ThermalSensor(PlateModule):
    """Emulated module of one remote finger's thermal sensor.

    Attributes:
        plate_counts: present reading of the plate's converter, 0..4095.
    """

    def __init__(self, finger: int, powered_s: float = 0.0) -> None:
        cut_out = CutOut(SENSOR_PLATE_C, LOOK_AHEAD_S)
        super().__init__(DeviceKind.THERMAL_SENSOR, finger, f"TH{finger:04d}", RANGE_C, cut_out, powered_s)
        self.measure(0, 0)

    def measure(self, plate_counts: int, ambient_counts: int) -> None:
        """Take the present readings of the two converters, 0..4095."""
        self.plate_counts, self._ambient_counts = plate_counts, ambient_counts
        self._measure(ssr_c(plate_counts))

    def _obey(self, frame: Frame, now_s: float) -> None:
        if frame.message_id != MessageId.HEATER_COMMAND:
            raise BadPayload(f"thermal sensor: no command {frame.message_id:#04x}")
        permille = HeaterCommand.decode(frame.payload).drive_permille
        self._watchdog.obeyed(now_s)
        self._ask(permille)

    def _run(self, now_s: float) -> None:
        if self._watchdog.expires(now_s):
            self._ask(0)
        if self._reports.due(now_s):
            measured = (self.plate_counts, self._ambient_counts)
            reading = (self._time_us(now_s) & 0xFFFFFFFF, *measured, self.flags, self.drive_permille)
            self._say(MessageId.THERMAL_READING, ThermalReading.LAYOUT.pack(*reading))
