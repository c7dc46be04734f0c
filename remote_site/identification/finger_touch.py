"""Result of one finger's identification in one tick.

It is made for each finger in each tick. It is not frozen: a frozen one takes eight times as long to make.
"""

from dataclasses import dataclass

from common.wire.messages import ExplorationMode
from remote_site.thermal.thermal_result import ThermalResult


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
    """One tick's output: what the operator site renders, and the state that the heater's control needs.

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
    thermal: ThermalResult
    measuring: bool
    """Whether a touch that began, or the last reading, uses the plate: it must not be heated."""
    no_differences: int
    """Thermal touches so far that ended because plate and object were equally warm."""
    speed_m_s: float
    roughness_v: float
    events: tuple[TouchEvent, ...]
    texture_fault: str | None = None
    """What is wrong with the texture sensor; None when nothing is."""
