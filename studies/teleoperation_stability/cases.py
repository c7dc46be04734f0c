"""Parameters of hand, exoskeleton and wall, with one array entry per run."""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

DEVICE_KG, DEVICE_NS_M = 0.09, 0.5
"""Inertia, kg, and own damping, Ns/m, of the exoskeleton at one finger."""
WALL_NS_M = 1.0
"""Damping of the wall, Ns/m."""


@dataclass(frozen=True, slots=True)
class Hand:
    """Impedance of the hand that moves the exoskeleton: mass, kg, damping, Ns/m, stiffness, N/m."""

    kg: float
    ns_m: float
    n_m: float


HANDS = {"light": Hand(0.006, 2.0, 200.0), "firm": Hand(0.010, 3.0, 800.0), "arm": Hand(1.4, 7.5, 400.0)}
"""Impedance of a lightly and a firmly held finger (Hajian & Howe 1997), and of a stiff finger on a moving arm."""


class Measured(NamedTuple):
    """Measurements of the remote site at a tick: depth, m, contact force and servo force, N, (N,) each."""

    depth_m: Floats
    force_n: Floats
    servo_n: Floats


@dataclass(frozen=True, slots=True)
class Cases:
    """Runs, each an entry of the arrays (N,).

    Attributes:
        hand_kg, hand_ns_m, hand_n_m: the operator's impedance.
        wall_n_m: stiffness of the wall.
        breath_m: peak-to-peak motion of the wall.
    """

    hand_kg: Floats
    hand_ns_m: Floats
    hand_n_m: Floats
    wall_n_m: Floats
    breath_m: Floats

    def __len__(self) -> int:
        return len(self.wall_n_m)


def cases(runs: Iterable[tuple[Hand, float, float]]) -> Cases:
    """Build runs from (hand, stiffness of the wall in N/m, breath in m)."""
    rows = [(hand.kg, hand.ns_m, hand.n_m, wall_n_m, breath_m) for hand, wall_n_m, breath_m in runs]
    return Cases(*np.array(rows, dtype=float).T)
