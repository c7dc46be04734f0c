"""Makes presses on a ground with a stiff place, for tests of the field and of lump probabilities."""

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]
GROUND_LN = 6.4
"""ln stiffness of the ground, N/m."""


def grid_m(side_m: float = 0.06, step_m: float = 0.004) -> Floats:
    """Places of a square grid from the origin, (n, 2), m."""
    axis = np.arange(0.0, side_m + 1e-9, step_m)
    return np.stack(np.meshgrid(axis, axis), axis=-1).reshape(-1, 2)


def ln_stiffness(places_m: Floats, chance: np.random.Generator, lumps: str = "ball", sd: float = 0.03) -> Floats:
    """ln stiffness with press scatter: `ball` at 30, 30 mm, `cord` along x = 30 mm, or `none`; it tilts by 20 %."""
    x_m, y_m = places_m.T
    away_m = {"ball": np.hypot(x_m - 0.03, y_m - 0.03), "cord": np.abs(x_m - 0.03), "none": np.full(len(x_m), 1.0)}
    ground = GROUND_LN + 0.2 * (x_m - 0.03) / 0.06
    return np.asarray(ground + 0.5 * np.exp(-0.5 * (away_m[lumps] / 0.005) ** 2) + sd * chance.normal(size=len(x_m)))
