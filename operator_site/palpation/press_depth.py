"""Brings presses of different depth to one depth, because tissue is stiffer where it is pressed deeper.

With a power law, F = c d^n at depth d, the stiffness F / d grows with F^m, m = 1 - 1/n. A regression of ln stiffness on
ln F beside the field gives m: presses of different force near each other show it. The prior prefers a linear law.
"""

import math

import numpy as np
from scipy.linalg import cho_solve
from scipy.spatial.distance import cdist

from operator_site.palpation.stiffness_field import MOST_FITTED, Floats, correlation, factors

GROWTH_SD = 0.3
"""Standard deviation of m in the prior; silicone has 0.2 to 0.3, liver 0.5 to 0.7."""
MOST_GROWTH = 0.5
"""Largest m. At one depth, the force grows as the stiffness does: then a larger m would explain lumps away."""


def at_one_depth(presses: Floats) -> Floats:
    """Return place, m, ln stiffness at the median depth, and its variance of each press, (n, 4).

    Args:
        presses: place, m, ln stiffness in N/m, its variance, and force, N, of each press, (n, 5). Where a force is not
            known, which is 0, the stiffness stays that of the press.
    """
    rows, force_n = presses[:, :4].copy(), presses[:, 4]
    known = np.flatnonzero(force_n > 0.0)
    if not len(known):
        return rows
    ln_n = np.log(force_n[known])
    some = np.unique(np.linspace(0, len(known) - 1, min(len(known), MOST_FITTED)).round().astype(int))
    growth = _growth(rows[known[some]], ln_n[some])
    by_depth = growth / (1.0 - growth)
    ln_depth_m = ln_n - rows[known, 2]
    rows[known, 2] -= by_depth * (ln_depth_m - np.median(ln_depth_m))
    rows[known, 3] *= (1.0 + by_depth) ** 2
    return rows


def _growth(rows: Floats, ln_n: Floats) -> float:
    """Return the m of the largest posterior density, 0..MOST_GROWTH."""
    stiffness, force = (values - np.median(values) for values in (rows[:, 2], ln_n))
    best, found = -math.inf, 0.0
    for _, lower, ln_rest in factors(correlation(cdist(rows[:, :2], rows[:, :2])), rows[:, 3]):
        by_stiffness, by_force = cho_solve((lower, True), np.column_stack([stiffness, force])).T
        growth = (force @ by_stiffness) / (force @ by_force + GROWTH_SD**-2)
        growth = float(min(max(growth, 0.0), MOST_GROWTH))
        off = stiffness - growth * force
        density = ln_rest - 0.5 * off @ (by_stiffness - growth * by_force) - 0.5 * (growth / GROWTH_SD) ** 2
        if density > best:
            best, found = density, growth
    return found
