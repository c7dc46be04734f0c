"""Input of one finger's identification in one tick."""

from dataclasses import dataclass

from common.wire.messages import ThermalReason


@dataclass(slots=True)
class FingerSample:
    """One tick's input; SI, C and V. `texture_v`, `sensor_c` and `ambient_c` are None where nothing new came.

    `device_us` is the thermal sensor's own time of its reading; without it the reading was taken when it came.
    """

    t_s: float
    force_n: float
    x_m: float
    y_m: float
    z_m: float
    texture_v: list[float] | None = None
    sensor_c: float | None = None
    ambient_c: float | None = None
    sensor_fault: ThermalReason = ThermalReason.NONE
    """What makes the reading implausible."""
    device_us: int | None = None
    heater_drive: float = 0.0
    """What the sensor's heater gets, as the sensor says, -1..1."""
