"""Look up the share of a ground's compliance that a nodule takes away, from the table of finite elements.

The table has four ratios of lengths and the stiffness ratio as axes. Splines run between its nodes, over the logarithms
of cover, layer beneath and punch radius, and over (E - 1) / (E + 1.5), in which a sphere in an incompressible body
acts nearly linearly (after Eshelby 1957).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import RegularGridInterpolator

Floats = NDArray[np.float64]

TABLE = Path(__file__).parent / "contrast.npz"
LARGEST_SHARE = 0.95
"""Largest share of the compliance that nodules together take away."""


@dataclass(frozen=True, slots=True)
class Sphere:
    """A nodule: place of its axis, diameter, tissue over its top, all mm, and its stiffness ratio, 1 or more."""

    x_mm: float
    y_mm: float
    size_mm: float
    depth_mm: float
    ratio: float


def taken_share(sphere: Sphere, layer_mm: float, radius_mm: Floats, distance_mm: Floats) -> Floats:
    """Return the share of the compliance under a punch that a nodule takes away, 0..1.

    Lengths beyond the table count as its last ones.

    Args:
        sphere: the nodule.
        layer_mm: thickness of the layer that holds it.
        radius_mm: radii of the contact; any shape.
        distance_mm: distances of the contact from the nodule's axis; a shape that fits `radius_mm`.
    """
    axes, spline = _spline()
    size = sphere.size_mm
    cover, beneath, radius = sphere.depth_mm / size, (layer_mm - sphere.depth_mm - size) / size, radius_mm / size
    spread = distance_mm / (0.5 * size * (1.0 + cover + radius))
    wanted = [np.log(np.maximum(cover, 1e-3)), np.log(max(beneath, 1e-3)), np.log(np.maximum(radius, 1e-3))]
    wanted += [_strength(np.asarray(sphere.ratio)), spread]
    held = [np.clip(value, axis[0], axis[-1]) for value, axis in zip(wanted, axes, strict=True)]
    found = spline(np.stack(np.broadcast_arrays(*held), axis=-1))
    return np.asarray(np.clip(found, 0.0, LARGEST_SHARE))


def _strength(ratio: Floats) -> Floats:
    return (ratio - 1.0) / (ratio + 1.5)


@cache
def _spline() -> tuple[Sequence[Floats], RegularGridInterpolator]:
    """Return the axes of the table and the spline over it."""
    with np.load(TABLE) as table:
        logarithmic = [np.log(table[name].astype(float)) for name in ("cover", "beneath", "radius")]
        axes = [*logarithmic, _strength(table["ratio"].astype(float)), table["spread"].astype(float)]
        return axes, RegularGridInterpolator(axes, table["share"].astype(float), method="cubic")
