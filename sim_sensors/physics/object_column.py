"""Prepare heat conduction in the object below a plate: a column of finite volumes, solved in implicit stages."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq

CELLS = 48
HALF_SPACE_S = 60.0
"""Time within which the end of a truncated half space has no effect at the surface, s."""
FINEST_S = 0.010
"""Diffusion time that sets the first cell, s; the cell is a fifth of the distance that heat diffuses in this time."""


@dataclass(frozen=True, slots=True)
class ObjectColumn:
    """A column of `cell_m.size` cells, surface first.

    One implicit stage of `stage_s` from temperatures r with heat flux q (W/m2) into the surface cell ends at
    `inverse @ r + response * q`. `half_cell_m2k_w` is the resistance from the surface to the first cell's centre.
    """

    cell_m: NDArray[np.float64]
    heat_j_m3k: float
    inverse: NDArray[np.float64]
    response: NDArray[np.float64]
    half_cell_m2k_w: float


def object_column(
    conductivity_w_mk: float,
    heat_j_m3k: float,
    thickness_m: float | None,
    stage_s: float,
    cells: int = CELLS,
) -> ObjectColumn:
    """Cut an object into cells that grow geometrically with depth; its far side is insulated.

    Args:
        conductivity_w_mk: conductivity k, W/mK.
        heat_j_m3k: volumetric heat capacity rho c, J/m3K.
        thickness_m: thickness, or None for a half space.
        stage_s: length of an implicit stage, s.
        cells: number of cells.
    """
    diffusivity = conductivity_w_mk / heat_j_m3k
    depth = 8.0 * math.sqrt(diffusivity * HALF_SPACE_S) if thickness_m is None else thickness_m
    first = 0.2 * math.sqrt(diffusivity * FINEST_S) * 48.0 / cells
    size = _growing_cells(first, depth, cells)
    conductance = conductivity_w_mk / (0.5 * (size[:-1] + size[1:]))
    capacity = heat_j_m3k * size
    system = np.diag(capacity / stage_s)
    inner = np.arange(cells - 1)
    system[inner, inner] += conductance
    system[inner + 1, inner + 1] += conductance
    system[inner, inner + 1] -= conductance
    system[inner + 1, inner] -= conductance
    solved = np.asarray(np.linalg.inv(system), dtype=np.float64)
    return ObjectColumn(
        size,
        heat_j_m3k,
        solved * (capacity / stage_s),
        solved[:, 0].copy(),
        0.5 * float(size[0]) / conductivity_w_mk,
    )


def _growing_cells(first_m: float, depth_m: float, cells: int) -> NDArray[np.float64]:
    """Return cell sizes in a geometric series from about `first_m` that fill `depth_m` exactly, m."""
    if first_m * cells >= depth_m:
        return np.full(cells, depth_m / cells)
    powers = np.arange(cells)
    ratio = brentq(lambda growth: first_m * float(np.sum(growth**powers)) - depth_m, 1.0, 3.0)
    size: NDArray[np.float64] = first_m * ratio**powers
    return size
