"""What goes into one finger's identification, and what comes out.

These are made for each finger in each tick. They are not frozen: a frozen one takes eight times as long to make.
"""

from dataclasses import dataclass

from common.messages import ExplorationMode
from remote_site.thermal_answer import ThermalAnswer


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
    sensor_fault: str | None = None
    device_us: int | None = None
    heater_drive: float = 0.0
    """What the sensor's heater gets, as the sensor says, -1..1."""


@dataclass(frozen=True, slots=True)
class TouchEvent:
    """Something that happened once.

    `kind` is `tap` (value: approach speed, m/s), `groove` (value: amplitude, rad/s) or `material` (name). `time_s` is
    when; None where that is now.
    """

    kind: str
    value: float
    name: str = ""
    time_s: float | None = None


@dataclass(slots=True)
class FingerTouch:
    """One tick's output: what the operator site renders, and the heater's drive, -1..1.

    A conductivity of 0 says that the material is unknown. Units: N, m, N/m, 1, N s/m, 1, 1, (rad/s)/(m/s),
    (rad/s)/N, W/mK, kg/m3, J/kgK.
    """

    mode: ExplorationMode
    contact: bool
    contact_force_n: float
    surface_z_m: float
    stiffness_n_m: float
    stiffness_ln_sd: float
    damping_n_s_m: float
    slope_x: float
    slope_y: float
    k_stroke_v: float
    k_stroke_f: float
    conductivity_w_mk: float
    density_kg_m3: float
    specific_heat_j_kgk: float
    thermal: ThermalAnswer
    heater_drive: float
    speed_m_s: float
    roughness_v: float
    events: tuple[TouchEvent, ...]
    texture_fault: str | None = None
    """What is wrong with the texture sensor; None when nothing is."""
