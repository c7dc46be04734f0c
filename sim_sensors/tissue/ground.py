"""Force of a spherical probe on soft tissue with nodules.

The probe of radius R touches at a depth d with the radius a = sqrt(R d), as Hertz found, at most R. A further step of
depth is that of a flat punch of this radius, which is exact for a linear layer (Sneddon 1965):

    dF/dd = (d / 2 mm)^(p - 1.5) * 2 a E / ((1 - nu^2) * l(a / H) * (1 - sum of s))

l is the layer's share of a half space's compliance, s the share that a nodule takes away (`contrast`), and p the
exponent of force over depth far above the base. With p = 1.5 and no nodule, it is the law of Hertz. Tissue with p > 1.5
stiffens. Nodules add their shares, and stiffen like the tissue around them.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from sim_sensors.tissue.contrast import LARGEST_SHARE, Sphere, taken_share
from sim_sensors.tissue.finite_elements import POISSON
from sim_sensors.tissue.layer import layer_share

Floats = NDArray[np.float64]

REFERENCE_MM = 2.0
"""Depth at which Young's modulus and stiffness of stiffening tissue are stated, mm."""
SUBSTEPS = 40
"""Steps of depth in which the force is added up."""
LOOKUP_MM = 1.0
"""Spacing of the distances at which a nodule is looked up, mm."""


@dataclass(frozen=True, slots=True)
class Ground:
    """Tissue under a probe.

    Attributes:
        young_kpa: Young's modulus at a depth of 2 mm, kPa.
        exponent: exponent of force over depth, more than 1.
        layer_mm: thickness of the layer over its rigid base, mm.
        probe_mm: radius of the spherical probe, mm.
    """

    young_kpa: float
    exponent: float
    layer_mm: float
    probe_mm: float

    def radius_mm(self, depth_mm: Floats) -> Floats:
        """Return the radius of contact at a depth, mm."""
        return np.minimum(np.sqrt(self.probe_mm * depth_mm), self.probe_mm)

    def slope_n_mm(self, depth_mm: Floats) -> Floats:
        """Return the growth of force with depth on tissue without a nodule, N/mm; depths must be positive."""
        radius = self.radius_mm(depth_mm)
        share = np.array([layer_share(a, self.layer_mm, POISSON) for a in radius.ravel()]).reshape(radius.shape)
        stiffening = (depth_mm / REFERENCE_MM) ** (self.exponent - 1.5)
        return stiffening * 2e-3 * radius * self.young_kpa / ((1.0 - POISSON**2) * share)


def force_at(
    ground: Ground, spheres: Sequence[Sphere], x_mm: Floats, y_mm: Floats, deepest_mm: float
) -> tuple[Floats, Floats]:
    """Return the force of presses along the surface's normal, without noise and friction.

    Args:
        ground: the tissue.
        spheres: its nodules.
        x_mm: places of the presses, (N,).
        y_mm: likewise.
        deepest_mm: depth at which the course ends.

    Returns:
        Depths from 0 on, (SUBSTEPS + 1,), mm, and the force of each press at each of them, (N, SUBSTEPS + 1), N.
    """
    step = deepest_mm / SUBSTEPS
    middles = np.asarray((np.arange(SUBSTEPS) + 0.5) * step, dtype=np.float64)
    taken = np.zeros((len(x_mm), SUBSTEPS))
    radius = ground.radius_mm(middles)
    for sphere in spheres:
        distance = np.hypot(x_mm - sphere.x_mm, y_mm - sphere.y_mm)
        grid = np.arange(0.0, float(distance.max(initial=0.0)) + 2.0 * LOOKUP_MM, LOOKUP_MM)
        known = taken_share(sphere, ground.layer_mm, radius[None, :], grid[:, None])
        low = np.minimum((distance / LOOKUP_MM).astype(np.int64), len(grid) - 2)
        part = (distance / LOOKUP_MM - low)[:, None]
        taken += (1.0 - part) * known[low] + part * known[low + 1]
    slope = ground.slope_n_mm(middles) / (1.0 - np.minimum(taken, LARGEST_SHARE))
    depths = step * np.arange(SUBSTEPS + 1.0)
    # The slope is nearly a power of depth, which is added up exactly.
    power = ground.exponent
    steps = np.diff(depths**power) / (power * middles ** (power - 1.0))
    return depths, np.concatenate([np.zeros((len(x_mm), 1)), np.cumsum(slope * steps, axis=1)], axis=1)
