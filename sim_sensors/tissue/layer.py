"""Compliance of an elastic layer without a nodule under a flat punch, by an integral over spatial frequencies.

The layer is bonded to a rigid base. A pressure p(k) sinks the surface by 2 (1 - nu^2) L(k H) p(k) / (E k), with

    L(w) = (2 q sinh 2w - 4 w) / (2 q cosh 2w + 1 + q^2 + 4 w^2),   q = 3 - 4 nu

(Johnson, Contact Mechanics, 1985, chapter 5). The mean displacement under the pressure of a flat punch of radius a is

    C = (1 - nu^2) / (pi E) * integral of L(k H) (sin(k a) / (k a))^2 dk from 0 to infinity,

which is (1 - nu^2) / (2 a E) on a half space.
"""

import math

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

DEEP = 20.0
"""Frequency times thickness beyond which the base is not felt: L differs from 1 by less than 1e-14."""
_STEPS = 4000


def layer_share(radius: float, layer: float, poisson: float) -> float:
    """Return the compliance of a layer under a flat punch, as a share of that of a half space, 0..1.

    It is within 1 % of the solution of Hayes et al. 1972 up to `radius` / `layer` = 0.6.

    Args:
        radius: radius of the punch, in any unit.
        layer: thickness of the layer, in the same unit.
        poisson: Poisson's ratio.
    """
    w = (np.arange(_STEPS) + 0.5) * DEEP / _STEPS
    q = 3.0 - 4.0 * poisson
    # The missing part 1 - L, without the large hyperbolic functions.
    small = np.exp(-2.0 * w)
    top = 1.0 + q * q + 4.0 * w * w + 4.0 * w + 2.0 * q * small
    bottom = q / small + q * small + 1.0 + q * q + 4.0 * w * w
    missing = top / bottom
    ka = w * radius / layer
    part = float(np.sum(missing * (np.sin(ka) / ka) ** 2)) * DEEP / _STEPS * radius / layer
    return 1.0 - 2.0 / math.pi * part


def half_space_compliance(radius: float, poisson: float) -> float:
    """Return the displacement per force of a flat punch on a half space with Young's modulus 1."""
    return (1.0 - poisson * poisson) / (2.0 * radius)
