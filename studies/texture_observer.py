"""A person who matches six surfaces of one set to six of another: by noisy features, all at once.

Each surface has five features, in units of what is just told apart: how strong it vibrates, whether there are single
grooves, their distance, how irregular they are, and how stiff it is. Both sides are felt with noise, and the person
pairs them so that the sum of squared differences is least. With that sum, what shifts one whole side by the same amount
changes nothing: only what differs within a set counts, so the units of skin and of motor need not agree. A feature
that is the same throughout one of the sets says nothing about the pairs; nobody attends to its noise.
"""

import math
from collections.abc import Sequence
from dataclasses import astuple, dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

Array = NDArray[np.float64]

INTENSITY_UNIT = 0.45
"""In ln: sqrt 2 of an amplitude threshold of 32 % (Israr & Tan 2006)."""
PERIOD_UNIT = 0.35
STIFFNESS_UNIT = math.log(1.23)
"""A Weber fraction of 23 % (Jones & Hunter 1990)."""
UNITS = np.array([INTENSITY_UNIT, 1.0, PERIOD_UNIT, 1.0, STIFFNESS_UNIT])
NOISE_REAL, NOISE_VIRTUAL = 0.5, 1.0
"""Standard deviations, in units."""
LAPSE = 0.03
"""Declared, not fitted: so many matchings are made without feeling, at random."""


@dataclass(frozen=True, slots=True)
class Features:
    """What one surface feels like.

    Attributes:
        ln_intensity: logarithm of the vibration's strength, of any unit that is the same within a set.
        pattern: 0 without single grooves, PATTERN with.
        ln_period: logarithm of their distance in mm, 0 without.
        irregularity: how much that distance varies, in units of what is just told apart.
        ln_stiffness: logarithm of the stiffness in N/m.
    """

    ln_intensity: float
    pattern: float = 0.0
    ln_period: float = 0.0
    irregularity: float = 0.0
    ln_stiffness: float = 0.0


PATTERN = 3.0
"""Grooved or not is told apart at once: three units."""


def matching(
    real: Sequence[Features], virtual: Sequence[Features], seed: int, draws: int, lapse: float = LAPSE
) -> list[float]:
    """Share of draws, 0..1, in which each real surface is paired with the virtual one of the same place."""
    return [float(share) for share in confusion(real, virtual, seed, draws, lapse).diagonal()]


def confusion(
    real: Sequence[Features], virtual: Sequence[Features], seed: int, draws: int, lapse: float = LAPSE
) -> Array:
    """Shares of draws in which the real surface of a row is paired with the virtual one of a column."""
    chance, count = np.random.default_rng(seed), len(real)
    felt_real, felt_virtual = _in_units(real), _in_units(virtual)
    telling = (np.ptp(felt_real, axis=0) > 0.0) & (np.ptp(felt_virtual, axis=0) > 0.0)
    felt_real, felt_virtual = felt_real[:, telling], felt_virtual[:, telling]
    found = np.zeros((count, count))
    for _ in range(draws):
        mine = felt_real + NOISE_REAL * chance.standard_normal(felt_real.shape)
        other = felt_virtual + NOISE_VIRTUAL * chance.standard_normal(felt_virtual.shape)
        # Of the squared difference only the product depends on the pairing.
        found[linear_sum_assignment(-mine @ other.T)] += 1.0
    return np.asarray((1.0 - lapse) * found / draws + lapse / count)


def _in_units(surfaces: Sequence[Features]) -> Array:
    return np.asarray(np.array([astuple(surface) for surface in surfaces]) / UNITS)
