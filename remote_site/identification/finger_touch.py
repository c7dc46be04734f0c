"""Result of one finger's identification in one tick.

Each tick makes one for each finger. It is not frozen, because a frozen dataclass takes eight times as long to make.
"""

from dataclasses import dataclass

from common.wire.messages import ExplorationMode
from remote_site.thermal.thermal_result import ThermalResult


@dataclass(frozen=True, slots=True)
class TouchEvent:
    """A single event.

    `kind` is `tap` (value: approach speed, m/s), `groove` (value: amplitude, rad/s) or `material` (value: probability,
    name: the material). `time_s` is the time of the event, s; None means now.
    """

    kind: str
    value: float
    name: str = ""
    time_s: float | None = None


@dataclass(slots=True)
class FingerTouch:
    """Output of one tick: the values that the operator site renders, and the state that heater control needs.

    A conductivity of 0 means that the material is unknown. Units, in order from the contact force: N, m, N/m, 1,
    N s/m, 1, 1, (rad/s)/(m/s), (rad/s)/N, W/mK, kg/m3, J/kgK.
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
    """Whether a touch that began, or the last reading, uses the plate; the plate must not be heated then."""
    no_differences: int
    """Number of thermal touches that ended because plate and object had equal temperatures."""
    speed_m_s: float
    roughness_v: float
    events: tuple[TouchEvent, ...]
    texture_fault: str | None = None
    """Fault of the texture sensor; None without a fault."""
