"""Simulates the simulators' fingertip, with its 40 cells of skin, on other things than a TactTip.

Layers, room and blood are those of `sim_sensors.physics.finger_plate`. All conduction is linear, so a step is exact in
time.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm

from sim_sensors.physics.finger_plate import (
    AIR_W_M2K,
    ARTERY_C,
    BLOOD_J_M3K,
    DEEP_C,
    EPIDERMIS_CELLS,
    ROOM_C,
    finger_column,
)

Array = NDArray[np.float64]

STEP_S = 0.010


@dataclass(frozen=True, slots=True)
class SimulatedFinger:
    """Skin per area, outermost cell first: heat_j_m2k dT/dt = balance_w_m2k T + known_w_m2.

    Attributes:
        half_m2k_w: thermal resistance from the surface to the first cell's centre.
        share_of_epidermis: weight of each cell in the mean over the epidermis; the weights add up to 1.
    """

    balance_w_m2k: Array
    known_w_m2: Array
    heat_j_m2k: Array
    half_m2k_w: float
    share_of_epidermis: Array

    @classmethod
    def with_deep_tissue_at(cls, deep_c: float = DEEP_C) -> "SimulatedFinger":
        """Return a finger with this deep temperature, C; blood exceeds it by the simulators' difference."""
        size, conductivity, capacity, perfusion = finger_column()
        half = size / (2.0 * conductivity)
        balance = chain(1.0 / (half[:-1] + half[1:]))
        blood, deep = size * perfusion * BLOOD_J_M3K, 1.0 / half[-1]
        balance -= np.diag(blood)
        balance[-1, -1] -= deep
        known = blood * (deep_c + ARTERY_C - DEEP_C)
        known[-1] += deep * deep_c
        outer = np.where(np.arange(len(size)) < EPIDERMIS_CELLS, size, 0.0)
        return cls(balance, known, size * capacity, float(half[0]), outer / outer.sum())

    def felt_c(self, skin_c: Array) -> float:
        """Return the mean temperature of the epidermis, C, where warmth and cold are sensed."""
        return float(self.share_of_epidermis @ skin_c)

    def in_air_c(self) -> Array:
        """Return the steady temperatures of the cells in the air of the room, C."""
        return self.at_rest_c(1.0 / AIR_W_M2K, ROOM_C)

    def at_rest_c(self, resistance_m2k_w: float, outside_c: float) -> Array:
        """Return the steady temperatures of the cells, C, with an outside temperature behind a thermal resistance."""
        link = 1.0 / (resistance_m2k_w + self.half_m2k_w)
        balance, known = self.balance_w_m2k.copy(), self.known_w_m2.copy()
        balance[0, 0] -= link
        known[0] += link * outside_c
        return np.asarray(np.linalg.solve(balance, -known))


def chain(links_w_m2k: Array) -> Array:
    """Return the balance matrix of a row of cells with these conductances between neighbours, W/m2K."""
    return np.asarray(
        np.diag(links_w_m2k, 1)
        + np.diag(links_w_m2k, -1)
        - np.diag(np.append(links_w_m2k, 0.0) + np.insert(links_w_m2k, 0, 0.0))
    )


def exact_step(balance_w_m2k: Array, heat_j_m2k: Array, inputs_w_m2: Array) -> tuple[Array, Array]:
    """Return a and b of the exact step T' = a T + b u over STEP_S, for heat dT/dt = balance T + inputs u."""
    cells, count = inputs_w_m2.shape
    rates = np.zeros((cells + count, cells + count))
    rates[:cells, :cells], rates[:cells, cells:] = balance_w_m2k, inputs_w_m2
    rates[:cells] /= heat_j_m2k[:, None]
    both = expm(rates * STEP_S)
    return both[:cells, :cells], both[:cells, cells:]
