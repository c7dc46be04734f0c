"""Computes how much a stiff inclusion in a soft layer lifts the stiffness under a probe, by its share of the energy.

A probe on an incompressible half space stores elastic energy below it with the density

    w(x) = 8 b / pi^2 * z^2 / (|x|^2 + b^2)^3,

at the depth z and the distance |x| from the middle of the contact. This is the field of a point force (Boussinesq:
radial stress alone, energy as z^2 / |x|^6), rounded at the length b. The integral of w over the half space is 1. A
sphere that presses with a contact of radius a has b = 5 a / 8, because Hertz's energy then gives the same far field.

An inclusion that holds the share s of this energy, and is r times as stiff, gives the stiffness ratio

    k / k0 = 1 / (1 - s (r - 1) / (1 + (2/5 + 3/5 s) (r - 1))).

For a small share it is Eshelby's sphere in an incompressible matrix; for a share of 1 it is r.
"""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]
ESHELBY = 0.4
"""Shear constant of Eshelby's tensor for a sphere in an incompressible matrix."""
HERTZ = 0.625
"""Length of the rounding as a share of the contact's radius."""
LEAST_CONTACT_M = 0.5e-3
"""Smallest radius of a contact, m."""
_SLICES, _RINGS, _ANGLES = 6, 3, 8


def contact_radius_m(probe_radius_m: float, indentation_m: float) -> float:
    """Return Hertz's radius of the contact of a sphere at an indentation, m; at most the radius of the probe."""
    return min(max(math.sqrt(probe_radius_m * max(indentation_m, 0.0)), LEAST_CONTACT_M), probe_radius_m)


def energy_above(layer_m: float, contact_m: float) -> float:
    """Return the share of a half space's energy that lies above a depth, 0..1."""
    b = HERTZ * contact_m
    return 2.0 / math.pi * (math.atan(layer_m / b) - b * layer_m / (b * b + layer_m * layer_m))


def energy_share(offset_m: ArrayLike, top_m: float, radius_m: float, contact_m: float, layer_m: float) -> Floats:
    """Return the share of the elastic energy inside a sphere, 0..1.

    Args:
        offset_m: horizontal distances of the probe from the middle of the sphere, (n,), m.
        top_m: depth of the sphere's upper pole, m.
        radius_m: radius of the sphere, m.
        contact_m: radius of the contact, m.
        layer_m: thickness of the soft layer on a rigid ground, m; the part of a sphere below it does not count.
    """
    points, weights = _ball()
    x, y, z = (radius_m * points).T
    z = z + top_m + radius_m
    volume = 4.0 / 3.0 * math.pi * radius_m**3
    b = HERTZ * contact_m
    off = np.asarray(offset_m, dtype=np.float64)[:, None]
    far = (x + off) ** 2 + y**2 + z**2 + b**2
    density = 8.0 * b / math.pi**2 * z**2 / far**3 * (z < layer_m)
    share = volume * (density @ weights) / energy_above(layer_m, contact_m)
    return np.asarray(np.minimum(share, 1.0))


def ln_lift(share: ArrayLike, ratio: ArrayLike) -> Floats:
    """Return ln k / k0 of inclusions with a share of the energy and a stiffness ratio; the arrays are broadcast."""
    part, more = np.asarray(share, dtype=np.float64), np.asarray(ratio, dtype=np.float64) - 1.0
    return np.asarray(-np.log1p(-part * more / (1.0 + (ESHELBY + (1.0 - ESHELBY) * part) * more)))


def _ball() -> tuple[Floats, Floats]:
    """Return points of a unit ball, (n, 3), and their weights, (n,), with the sum 1."""
    z, dz = np.polynomial.legendre.leggauss(_SLICES)
    u, du = np.polynomial.legendre.leggauss(_RINGS)
    angle = 2.0 * math.pi * (np.arange(_ANGLES) + 0.5) / _ANGLES
    height, square, turn = np.meshgrid(z, 0.5 * (u + 1.0), angle, indexing="ij")
    ring = np.sqrt((1.0 - height**2) * square)
    points = np.column_stack([(ring * np.cos(turn)).ravel(), (ring * np.sin(turn)).ravel(), height.ravel()])
    weights = (dz[:, None, None] * du[None, :, None] * (1.0 - height**2)).ravel()
    return points, np.asarray(weights / weights.sum())
