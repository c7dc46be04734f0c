"""Computes how much a stiff inclusion lifts the stiffness under a probe, by its share of the elastic energy.

A flat punch of radius a on an incompressible half space deforms it by the strain -z grad grad phi, with the potential

    phi(rho, z) = 2 / pi * Im asinh((z + i a) / rho)

at the distance rho from its axis and the depth z (Sneddon 1946). The density of the elastic energy is

    w(rho, z) = z^2 |grad grad phi|^2 / (4 a),

with an integral of 1 over the half space. An inclusion that holds the share s of this energy, and is r times as stiff,
gives the stiffness ratio

    k / k0 = 1 / (1 - s (r - 1) / (1 + (2/5 + 3/5 s) (r - 1))).

For a small share it is a Born approximation with Eshelby's sphere in an incompressible matrix; for all of it, it is r.
A sphere of radius R touches at the depth d with the radius sqrt(R d), and its further way is that of a flat punch.
"""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

Floats = NDArray[np.float64]
ESHELBY = 0.4
"""Shear constant of Eshelby's tensor for a sphere in an incompressible matrix."""
LEAST_CONTACT_M = 0.5e-3
"""Smallest radius of a contact, m."""
_SLICES, _RINGS, _ANGLES = 6, 3, 12


def contact_radius_m(probe_radius_m: float, indentation_m: float) -> float:
    """Return Hertz's radius of the contact of a sphere at an indentation, m; at most the radius of the probe."""
    return min(max(math.sqrt(probe_radius_m * max(indentation_m, 0.0)), LEAST_CONTACT_M), probe_radius_m)


def energy_density(away_m: ArrayLike, depth_m: ArrayLike, contact_m: float) -> Floats:
    """Return the share of a flat punch's energy per volume, 1/m3; the arrays are broadcast.

    Args:
        away_m: distances from the axis of the punch, m.
        depth_m: depths below the surface, m, above 0.
        contact_m: radius of the punch, m.
    """
    rho = np.maximum(np.asarray(away_m, dtype=np.float64), 1e-4 * contact_m)
    z = np.asarray(depth_m, dtype=np.float64)
    zeta = z + 1j * contact_m
    root = np.sqrt(rho**2 + zeta**2)
    along = np.imag(-zeta / root**3)
    across = np.imag(-rho / root**3)
    around = np.imag(-zeta / root) / rho**2
    square = (along + around) ** 2 + around**2 + along**2 + 2.0 * across**2
    return np.asarray((2.0 / math.pi * z) ** 2 * square / (4.0 * contact_m))


def energy_share(offset_m: ArrayLike, top_m: float, radius_m: float, contact_m: float) -> Floats:
    """Return the share of the elastic energy inside a sphere, 0..1.

    Args:
        offset_m: horizontal distances of the probe from the middle of the sphere, (n,), m.
        top_m: depth of the sphere's upper pole, m.
        radius_m: radius of the sphere, m.
        contact_m: radius of the contact, m.
    """
    points, weights = _ball()
    x, y, z = (radius_m * points).T
    away_m = np.hypot(x + np.asarray(offset_m, dtype=np.float64)[:, None], y)
    volume = 4.0 / 3.0 * math.pi * radius_m**3
    share = volume * (energy_density(away_m, z + top_m + radius_m, contact_m) @ weights)
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
    weights = np.broadcast_to(dz[:, None, None] * du[None, :, None] * (1.0 - height**2), height.shape).ravel()
    return points, np.asarray(weights / weights.sum())
