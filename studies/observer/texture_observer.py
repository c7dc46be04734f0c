"""Psychophysical observer that matches six surfaces of one set with six of another by noisy features, all at once.

Each surface has five features, in units of a JND: vibration intensity, presence of single grooves, groove spacing,
irregularity of the spacing, and stiffness. Both sides are felt with noise. The observer pairs them with the least sum
of squared differences. A shift of one whole side by a constant does not change this pairing. Only differences within a
set count, so the units of skin and motor need not agree. A feature that is constant within one set does not affect the
pairing; the observer ignores its noise.
"""

import math
from collections.abc import Sequence
from dataclasses import astuple, dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import linear_sum_assignment

Array = NDArray[np.float64]

INTENSITY_UNIT = 0.45
"""JND of ln intensity: sqrt 2 of an amplitude threshold of 32 % (Israr & Tan 2006)."""
PERIOD_UNIT = 0.35
STIFFNESS_UNIT = math.log(1.23)
"""JND of ln stiffness: a Weber fraction of 23 % (Jones & Hunter 1990)."""
UNITS = np.array([INTENSITY_UNIT, 1.0, PERIOD_UNIT, 1.0, STIFFNESS_UNIT])
NOISE_REAL, NOISE_VIRTUAL = 0.5, 1.0
"""Standard deviation of the noise of real and of virtual features, in units of UNITS."""
LAPSE = 0.03
"""Share of matchings made at random, 0..1; declared, not fitted."""


@dataclass(frozen=True, slots=True)
class Features:
    """Tactile features of one surface.

    Attributes:
        ln_intensity: logarithm of the vibration's intensity, in any unit that is the same within a set.
        pattern: 0 without single grooves, PATTERN with them.
        ln_period: logarithm of the groove spacing in mm, 0 without grooves.
        irregularity: relative spread of the groove spacing, in JNDs.
        ln_stiffness: logarithm of the stiffness in N/m.
    """

    ln_intensity: float
    pattern: float = 0.0
    ln_period: float = 0.0
    irregularity: float = 0.0
    ln_stiffness: float = 0.0


PATTERN = 3.0
"""Difference between a grooved and an ungrooved surface, in JNDs; it is noticed at once."""


def matching(
    real: Sequence[Features], virtual: Sequence[Features], seed: int, draws: int, lapse: float = LAPSE
) -> list[float]:
    """Return the share of draws, 0..1, in which each real surface is paired with the virtual one of the same index."""
    return [float(share) for share in confusion(real, virtual, seed, draws, lapse).diagonal()]


def confusion(
    real: Sequence[Features], virtual: Sequence[Features], seed: int, draws: int, lapse: float = LAPSE
) -> Array:
    """Return the shares of draws, 0..1, that pair the real surface of a row with the virtual one of a column."""
    chance, count = np.random.default_rng(seed), len(real)
    felt_real, felt_virtual = _in_units(real), _in_units(virtual)
    varying = (np.ptp(felt_real, axis=0) > 0.0) & (np.ptp(felt_virtual, axis=0) > 0.0)
    felt_real, felt_virtual = felt_real[:, varying], felt_virtual[:, varying]
    found = np.zeros((count, count))
    for _ in range(draws):
        mine = felt_real + NOISE_REAL * chance.standard_normal(felt_real.shape)
        other = felt_virtual + NOISE_VIRTUAL * chance.standard_normal(felt_virtual.shape)
        # Only the product in the squared difference depends on the pairing.
        found[linear_sum_assignment(-mine @ other.T)] += 1.0
    return np.asarray((1.0 - lapse) * found / draws + lapse / count)


def _in_units(surfaces: Sequence[Features]) -> Array:
    return np.asarray(np.array([astuple(surface) for surface in surfaces]) / UNITS)
