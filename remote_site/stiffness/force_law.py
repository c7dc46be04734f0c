"""Force of tissue under a probe: a power law that stiffens further with depth.

    F = f0 + exp(a) u^p exp(g (u - 1)),    u = d - c

Here d is the depth, c the depth of first contact, and f0 the offset of the force sensor. Silicone follows the power
law alone (g = 0, p from 1.2 to 1.4). The force on liver grows nearly exponentially (Fung 1967), and g describes this.
With p >= 1 and g >= 0 the law is convex: each of its tangents is a lower bound of the force at every depth.

Depths are in units that the caller chooses, and forces in N. A row of parameters is `(a, ln(p - 1), ln g, c, f0)`.
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

PARAMETERS = 5
"""Number of parameters of the law."""
LEAST_DEPTH = 1e-9
"""Smallest depth below first contact, in the unit of depth; it replaces depths above the contact."""
MOST_EXPONENT = 60.0
"""Largest absolute value of an exponent of e; a wild step of a fit does not overflow."""
MOST_LN_DEPTH = 20.0
"""Largest absolute value of ln u that is stated; a force that no depth reaches does not overflow."""
NEWTON_STEPS = 30
"""Number of steps of Newton's method that finds the depth of a force."""


def force(parameters: Array, depth: Array) -> Array:
    """Return the force, (n, m), N, of n rows of parameters, (n, 5), at their depths, (n, m)."""
    _, _, elastic, _ = _parts(parameters, depth)
    return elastic + parameters[:, 4:5]


def gradient(parameters: Array, depth: Array) -> tuple[Array, Array, Array]:
    """Return force, (n, m), its derivatives by the parameters, (n, m, 5), and by depth, (n, m)."""
    u, power, elastic, stiffening = _parts(parameters, depth)
    by_depth = elastic * (power / u + stiffening)
    by_parameters = np.stack(
        [
            elastic,
            elastic * np.log(u) * (power - 1.0),
            elastic * (u - 1.0) * stiffening,
            -by_depth,
            np.ones_like(elastic),
        ],
        axis=-1,
    )
    return elastic + parameters[:, 4:5], by_parameters, by_depth


def depth_at(parameters: Array, elastic_n: float) -> tuple[Array, Array]:
    """Return depth u below contact and local exponent d ln F / d ln u, (n,) each, at a force without offset, N."""
    a, power, stiffening = parameters[:, 0], 1.0 + np.exp(parameters[:, 1]), np.exp(parameters[:, 2])
    wanted = np.log(elastic_n) - a
    # Newton's method on p v + g (e^v - 1) = wanted with v = ln u, from a start at or above the root.
    above = np.maximum(wanted, 0.0)
    start = np.minimum(above / power, np.log1p(above / stiffening))
    v = np.where(wanted < 0.0, (wanted + stiffening) / power, start)
    for _ in range(NEWTON_STEPS):
        grown = stiffening * np.exp(np.minimum(v, MOST_EXPONENT))
        v = v - (power * v + grown - stiffening - wanted) / (power + grown)
    u = np.exp(np.clip(v, -MOST_LN_DEPTH, MOST_LN_DEPTH))
    return u, power + stiffening * u


def _parts(parameters: Array, depth: Array) -> tuple[Array, Array, Array, Array]:
    """Return u, p, the force without offset, and g, in shapes that go together."""
    a, ln_power, ln_stiffening, contact, _ = (column[:, np.newaxis] for column in parameters.T)
    power, stiffening = 1.0 + np.exp(ln_power), np.exp(ln_stiffening)
    u = np.maximum(depth - contact, LEAST_DEPTH)
    ln_force = a + power * np.log(u) + stiffening * (u - 1.0)
    return u, power, np.exp(np.clip(ln_force, -MOST_EXPONENT, MOST_EXPONENT)), stiffening
