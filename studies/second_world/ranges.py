"""Parameters of the second world: a range for each, with its source, fixed before any estimator was judged on it.

Sources: [1] data sheets of small Peltier modules (8 to 15 mm, 7 to 31 couples): 4 to 20 mW/K between the faces, ZT of
bismuth telluride 0.6 to 0.8 at 300 K; [2] handbook constants of copper, aluminium and alumina; [3] natural convection
at small bodies, 5 to 15 W/(m2 K) with radiation; [4] data sheets of silicon and platinum thermometers in moulded
packages: lag 0.1 to 0.5 s in contact, self-heating 0.01 to 0.15 K, 12 bits over the range; [5] gas gap and spots of
nominally flat contacts at some 10 kPa, 400 to 4000 W/(m2 K); [6] hydration of skin under an occlusive contact,
seconds; [7] data sheets of ambient sensors, +-0.3 to +-0.5 K. What has no source is a choice, marked [c].
"""

import math
from dataclasses import dataclass

import numpy as np

from common.scenes.materials import Material


@dataclass(frozen=True, slots=True)
class Sensor:
    """One kind of sensor; the fingers of a hand differ from it by `unit_spread`.

    Attributes:
        radius_m: radius of the contact plate, m.
        plate_m: its thickness, m.
        plate_w_mk: its conductivity, W/(m K).
        plate_j_m3k: its volumetric heat capacity, J/(m3 K).
        pellet_j_k: heat capacity of the Peltier's pellets, J/K.
        pellet_w_k: conductance from the plate through them to the back, W/K, with open terminals.
        seebeck_share: additional conductance by the current that the driver lets flow, as a share of `pellet_w_k`.
        back_j_k: heat capacity of the back with its sink, J/K.
        back_w_k: conductance from the back to the surroundings, W/K.
        case_j_k: heat capacity of the case, J/K.
        case_w_k: conductance from the plate to the case, W/K.
        cable_j_k: heat capacity of the near end of the cable, J/K.
        cable_w_k: conductance from the plate to the cable, W/K.
        outer_w_k: conductance from the case, and from the cable, to the surroundings, W/K.
        lag_s: two lags of the thermometer, s.
        stem: share by which the thermometer reads towards ambient.
        self_heating_k: reading above the plate by the measuring current, K.
        drift_k_s: drift of the reading during a touch, K/s (standard deviation from touch to touch).
        noise_k: white noise of a reading, K.
        slow_noise_k: noise with a correlation time of 0.3 s, K.
        step_k: step of the converter, K.
        ambient_offset_k: constant error of the ambient sensor, K.
        off_s: time from contact until the heater is off, s.
        remaining_w: heat flow that remains just after switching off, W; it decays within 0.1 s.
        force_delay_s: delay of the force sensor, s.
        gap_m: thickness of the gas gap in the middle of a contact with a smooth object, m.
        spots_w_m2k: conductance of contact spots with a good conductor at 1 N, W/(m2 K).
        spots_power: exponent of the force in it.
        dome_m: height of the plate's middle above its edge, m.
        unit_spread: standard deviation of ln(lag, leak, contact) between units.
        touch_spread: standard deviation of ln(contact) from touch to touch.
    """

    radius_m: float
    plate_m: float
    plate_w_mk: float
    plate_j_m3k: float
    pellet_j_k: float
    pellet_w_k: float
    seebeck_share: float
    back_j_k: float
    back_w_k: float
    case_j_k: float
    case_w_k: float
    cable_j_k: float
    cable_w_k: float
    outer_w_k: float
    lag_s: tuple[float, float]
    stem: float
    self_heating_k: float
    drift_k_s: float
    noise_k: float
    slow_noise_k: float
    step_k: float
    ambient_offset_k: float
    off_s: float
    remaining_w: float
    force_delay_s: float
    gap_m: float
    spots_w_m2k: float
    spots_power: float
    dome_m: float
    unit_spread: float
    touch_spread: float


@dataclass(frozen=True, slots=True)
class Piece:
    """One touched piece.

    Attributes:
        conductivity_w_mk: conductivity, W/(m K).
        heat_j_m3k: volumetric heat capacity, J/(m3 K).
        thickness_m: thickness, m.
        radius_m: radius of the piece around the contact, m.
        curvature_per_m: curvature of its surface, 1/m.
        rough_m: roughness, rms, m; it widens the gas gap.
        moisture: share by which the conductance grows while moisture gathers.
        moist_s: time in which it gathers, s.
        above_k: temperature above ambient before contact, K.
    """

    conductivity_w_mk: float
    heat_j_m3k: float
    thickness_m: float
    radius_m: float
    curvature_per_m: float
    rough_m: float
    moisture: float
    moist_s: float
    above_k: float


PLATES = ((390.0, 3.45e6), (230.0, 2.43e6), (27.0, 3.43e6))
"""Conductivity, W/(m K), and volumetric heat capacity, J/(m3 K), of copper, aluminium and alumina [2]."""
AIR_W_M2K = 9.0
"""Loss of free surfaces to the surroundings, W/(m2 K) [3]."""
GAS_W_MK = 0.026
"""Conductivity of air, W/(m K)."""
MOIST = ("skin_dermis", "soft_tissue", "fat", "gelatin_10pct", "leather")
"""Materials that give off moisture."""


def draw_sensor(seed: int) -> Sensor:
    """Draw a kind of sensor."""
    rng = np.random.default_rng([seed, 0xB])

    def between(low: float, high: float) -> float:
        return float(math.exp(rng.uniform(math.log(low), math.log(high))))

    plate_w_mk, plate_j_m3k = PLATES[rng.integers(len(PLATES))]
    return Sensor(
        radius_m=between(5e-3, 8e-3),  # [1]
        plate_m=between(0.4e-3, 1.0e-3),  # [1]
        plate_w_mk=plate_w_mk,
        plate_j_m3k=plate_j_m3k,
        pellet_j_k=between(0.03, 0.15),  # [1] [2]
        pellet_w_k=between(4e-3, 14e-3),  # [1]
        seebeck_share=float(rng.choice([0.0, rng.uniform(0.1, 0.7)])),  # [1], open or closed terminals
        back_j_k=between(1.0, 6.0),  # [c]
        back_w_k=between(0.01, 0.06),  # [3] [c]
        case_j_k=between(0.5, 3.0),  # [c]
        case_w_k=between(1e-3, 6e-3),  # [c]
        cable_j_k=between(0.1, 0.6),  # [c]
        cable_w_k=between(0.3e-3, 2e-3),  # [2], two to four strands
        outer_w_k=between(3e-3, 15e-3),  # [3]
        lag_s=(between(0.10, 0.40), between(0.02, 0.12)),  # [4]
        stem=float(rng.uniform(0.0, 0.02)),  # [4]
        self_heating_k=between(0.01, 0.15),  # [4]
        drift_k_s=between(0.2e-3, 2e-3),  # [c]
        noise_k=between(0.005, 0.020),  # [4]
        slow_noise_k=between(0.002, 0.008),  # [c]
        step_k=between(0.010, 0.025),  # [4]
        ambient_offset_k=float(rng.normal(0.0, 0.2)),  # [7]
        off_s=float(rng.uniform(0.0, 0.02)),  # [c], two ticks
        remaining_w=float(rng.normal(0.0, 0.02)),  # [c]
        force_delay_s=float(rng.uniform(0.0, 0.01)),  # [c]
        gap_m=between(10e-6, 40e-6),  # [5]
        spots_w_m2k=between(200.0, 1500.0),  # [5]
        spots_power=float(rng.uniform(0.5, 0.95)),  # [5]
        dome_m=between(5e-6, 60e-6),  # [c]
        unit_spread=0.06,  # [c]
        touch_spread=between(0.08, 0.2),  # [c], as first world
    )


def draw_piece(kind: Material, rng: np.random.Generator, above_k: tuple[float, float]) -> Piece:
    """Draw a piece of a material at a temperature above ambient within a range, K.

    Conductivity and heat capacity scatter each by itself, so that their ratio is not that of the table.
    """
    moist = kind.name in MOIST
    return Piece(
        conductivity_w_mk=kind.conductivity_w_mk * math.exp(1.3 * kind.spread * rng.standard_normal()),
        heat_j_m3k=kind.density_kg_m3 * kind.specific_heat_j_kgk * math.exp(0.7 * kind.spread * rng.standard_normal()),
        thickness_m=float(rng.uniform(0.010, 0.030)),  # [c]
        radius_m=float(rng.uniform(0.020, 0.040)),  # [c]
        curvature_per_m=float(rng.choice([0.0, rng.uniform(0.0, 8.0)])),  # [c], flat or radii from 125 mm
        rough_m=float(math.exp(rng.normal(math.log(2e-6), 0.5))),  # [5]
        moisture=float(rng.uniform(0.05, 0.4)) if moist else 0.0,  # [6]
        moist_s=float(rng.uniform(0.5, 4.0)),  # [6]
        above_k=float(rng.uniform(*above_k)),
    )
