"""Fits the scale of roughness in um to strokes over surfaces of known roughness."""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from remote_site.texture.roughness_scale import RoughnessScale
from remote_site.texture.texture_law import ln_roughness

Array = NDArray[np.float64]
ENOUGH = 3
"""Number of surfaces from which the exponent is fitted; with fewer, roughness in um is proportional to that in V."""
APART = 0.2
"""Minimum standard deviation of ln(roughness in V) between surfaces for which the exponent is fitted."""
EXPONENTS = (0.2, 5.0)
"""Range of the exponent."""
ASSUMED_SD = 0.3
"""Standard deviation of ln(roughness in um) between surfaces if only one was calibrated."""
LEAST_SD = 0.05
"""Minimum standard deviation of ln(roughness in um)."""


class KnownRoughness(NamedTuple):
    """A stroke over a surface of known roughness: label, roughness of the sensor, V, and of the surface, um."""

    surface: str
    roughness_v: float
    roughness_um: float


def fit_scale(strokes: Sequence[KnownRoughness]) -> RoughnessScale | None:
    """Fit the scale to strokes; each surface counts once. The result is None without a stroke."""
    if not strokes:
        return None
    ln_v = np.array([ln_roughness(one.roughness_v) for one in strokes])
    ln_um = np.log([one.roughness_um for one in strokes])
    names, number = np.unique([one.surface for one in strokes], return_inverse=True)
    x, y = np.array([[part[number == own].mean() for own in range(len(names))] for part in (ln_v, ln_um)])
    fitted = len(x) >= ENOUGH and float(x.std()) > APART
    exponent = float(np.clip(np.polyfit(x, y, 1)[0], *EXPONENTS)) if fitted else 1.0
    offset = float((y - exponent * x).mean())
    left = y - offset - exponent * x
    free = len(x) - (2 if fitted else 1)
    between = math.sqrt(float(left @ left) / free) if free else ASSUMED_SD
    scatter = ln_um - y[number] - exponent * (ln_v - x[number])
    within = float(np.sqrt(np.mean(np.square(scatter))))
    return RoughnessScale(
        ln_um=offset,
        exponent=exponent,
        ln_sd=max(math.hypot(between, within), LEAST_SD),
        least_v=math.exp(float(ln_v.min())),
        most_v=math.exp(float(ln_v.max())),
    )
