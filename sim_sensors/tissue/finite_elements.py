"""Solve the softening of a punch by a sphere of other stiffness in an elastic layer, by finite elements.

The sphere lies below the origin of a layer that is bonded to a rigid base. Body and mesh are axisymmetric about the
sphere's axis, the punch stands anywhere. Its load is therefore a Fourier series in the angle, and each harmonic is a
problem in the plane (r, z), as in Zienkiewicz & Taylor, chapter on semi-analytical elements:

    u_r = u cos(n t),  u_t = v sin(n t),  u_z = w cos(n t)

Elements are quadrilaterals with eight nodes and 2 x 2 points of integration, which do not lock at a Poisson's ratio
near 0.5. A flat punch has the pressure 1 / (2 pi a sqrt(a^2 - s^2)); its compliance is the mean displacement, weighted
with that pressure. An error of the pressure enters in the second order only.

Lengths are in diameters of the sphere, and Young's modulus of the layer is 1.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csc_array, csr_array
from scipy.sparse.linalg import splu

Floats = NDArray[np.float64]

POISSON = 0.49
"""Poisson's ratio of layer and sphere; tissue hardly changes its volume."""
GROWTH = 1.3
"""Factor from one element to the next away from the sphere."""
HARMONICS = 8
"""Terms of the Fourier series. Only the smooth ones reach the sphere."""
_SHARES = 6
"""Samples along each side of a quarter of an element, for the share of it that is inside the sphere."""
_GAUSS = np.array([-1.0, 1.0]) / math.sqrt(3.0)
_CORNERS = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]], dtype=np.float64)
_SIDES = np.array([[0, -1], [1, 0], [0, 1], [-1, 0]], dtype=np.float64)


@dataclass(frozen=True, slots=True)
class Body:
    """A sphere in a layer, in diameters of the sphere: its cover, and the layer beneath it."""

    cover: float
    beneath: float

    @property
    def layer(self) -> float:
        """Thickness of the layer, diameters."""
        return self.cover + 1.0 + self.beneath


@dataclass(frozen=True, slots=True)
class Mesh:
    """Rectangles of eight nodes in the plane (r, z), with z downwards from the surface.

    Attributes:
        r_lines: lines of the corners along r, ascending from 0.
        z_lines: lines of the corners along z, from 0 at the surface to the base.
    """

    r_lines: Floats
    z_lines: Floats

    @classmethod
    def around(cls, body: Body, fineness: float = 1.0) -> "Mesh":
        """Lay lines that are dense at the sphere and above it; `fineness` 2 halves all elements there."""
        inner = 0.045 / fineness
        least = min(inner, body.cover / (3.0 * fineness))
        growth = GROWTH ** (1.0 / fineness)
        sphere = np.linspace(0.0, 1.0, math.ceil(1.0 / inner) + 1)
        above = _graded(body.cover, least, growth)
        below = _graded(body.beneath, inner, growth)
        half = np.linspace(0.0, 0.5, math.ceil(0.5 / inner) + 1)
        outer = _graded(3.0 * body.layer + 3.0, inner, growth)
        z_lines = np.concatenate([body.cover - above[::-1], body.cover + sphere[1:], body.cover + 1.0 + below[1:]])
        z_lines[0] = 0.0
        return cls(np.concatenate([half, 0.5 + outer[1:]]), z_lines)

    @property
    def nodes(self) -> tuple[NDArray[np.int64], Floats]:
        """Return the eight nodes of each element, (elements, 8), and the place of each node, (nodes, 2)."""
        columns, rows = len(self.r_lines) - 1, len(self.z_lines) - 1
        number = np.full((2 * columns + 1, 2 * rows + 1), -1, dtype=np.int64)
        used = np.ones(number.shape, dtype=bool)
        used[1::2, 1::2] = False
        number[used] = np.arange(used.sum())
        r, z = _with_middles(self.r_lines), _with_middles(self.z_lines)
        i, j = (2 * each.ravel() for each in np.meshgrid(np.arange(columns), np.arange(rows), indexing="ij"))
        steps = [(0, 0), (2, 0), (2, 2), (0, 2), (1, 0), (2, 1), (1, 2), (0, 1)]
        elements = np.stack([number[i + di, j + dj] for di, dj in steps], axis=1)
        places = np.stack(np.meshgrid(r, z, indexing="ij"), axis=-1)[used]
        return elements, places


def punch_compliance(
    body: Body,
    ratios: Sequence[float],
    punches: Sequence[tuple[float, float]],
    *,
    fineness: float = 1.0,
    harmonics: int = HARMONICS,
) -> Floats:
    """Return the compliances of punches, displacement per force with E = 1, for each stiffness ratio.

    Only differences between ratios are accurate for punches away from the axis, where the mesh is coarse.

    Args:
        body: the sphere and its layer.
        ratios: Young's modulus of the sphere over that of the layer.
        punches: radius and distance from the axis of each punch, diameters.
        fineness: factor on the density of the mesh.
        harmonics: terms of the Fourier series.

    Returns:
        (ratios, punches)
    """
    mesh = Mesh.around(body, fineness)
    elements, places = mesh.nodes
    surface = np.flatnonzero(places[:, 1] == 0.0)
    surface = surface[np.argsort(places[surface, 0])]
    fixed_base = places[:, 1] >= body.layer - 1e-9
    axis = places[:, 0] == 0.0
    found = np.zeros((len(ratios), len(punches)))
    for n in range(harmonics):
        loads = np.stack([_load(places[surface, 0], a, x, n) for a, x in punches], axis=1)
        right = np.zeros((3 * len(places), len(punches)))
        right[3 * surface + 2] = loads
        soft, hard = _stiffness(elements, places, body, n)
        fixed = np.repeat(fixed_base, 3)
        fixed[0::3] |= axis & (n != 1)
        fixed[1::3] |= (axis & (n != 1)) | (n == 0)
        fixed[2::3] |= axis & (n != 0)
        free = np.flatnonzero(~fixed)
        for index, ratio in enumerate(ratios):
            stiffness = (soft + ratio * hard)[free][:, free]
            moved = splu(csc_array(stiffness), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0).solve(right[free])
            found[index] += np.sum(right[free] * moved, axis=0)
    return found


def _stiffness(elements: NDArray[np.int64], places: Floats, body: Body, n: int) -> tuple[csr_array, csr_array]:
    """Return the stiffness of all parts outside the sphere, and of those inside it, both with E = 1."""
    elastic = _elastic()
    corner = places[elements]
    around = 2.0 * math.pi if n == 0 else math.pi
    parts = np.zeros((2, len(elements), 24, 24))
    for along_r in _GAUSS:
        for along_z in _GAUSS:
            shape, by_xi = _shape(along_r, along_z)
            half = 0.5 * (corner[:, 2] - corner[:, 0])
            r = corner[:, :, 0] @ shape
            strain = _strain(shape, by_xi[:, 0] / half[:, :1], by_xi[:, 1] / half[:, 1:], r, n)
            weight = around * r * half[:, 0] * half[:, 1]
            inside = _share_inside(corner[:, 0], half, math.copysign(1.0, along_r), math.copysign(1.0, along_z), body)
            energy = np.einsum("eki,kl,elj->eij", strain, elastic, strain, optimize=True) * weight[:, None, None]
            parts += np.stack([1.0 - inside, inside])[:, :, None, None] * energy
    place = (3 * elements[:, :, None] + np.arange(3)).reshape(len(elements), 24)
    row, column = np.repeat(place, 24, axis=1).ravel(), np.tile(place, (1, 24)).ravel()
    size = 3 * len(places)
    soft, hard = (csr_array((part.ravel(), (row, column)), shape=(size, size)) for part in parts)
    return soft, hard


def _share_inside(low: Floats, half: Floats, sign_r: float, sign_z: float, body: Body) -> Floats:
    """Return the share of one quarter of each element that is inside the sphere, 0..1."""
    steps = (np.arange(_SHARES) + 0.5) / _SHARES
    r = low[:, :1] + half[:, :1] * (1.0 + sign_r * steps)
    z = low[:, 1:] + half[:, 1:] * (1.0 + sign_z * steps) - body.cover - 0.5
    inside = np.hypot(r[:, :, None], z[:, None, :]) < 0.5
    return np.asarray(inside.mean(axis=(1, 2)))


def _strain(shape: Floats, by_r: Floats, by_z: Floats, r: Floats, n: int) -> Floats:
    """Return the strains (rr, tt, zz, rz, rt, zt) of unit displacements, (elements, 6, 24)."""
    strain = np.zeros((len(r), 6, 8, 3))
    over_r = shape / r[:, None]
    strain[:, 0, :, 0] = by_r
    strain[:, 1, :, 0] = over_r
    strain[:, 1, :, 1] = n * over_r
    strain[:, 2, :, 2] = by_z
    strain[:, 3, :, 0] = by_z
    strain[:, 3, :, 2] = by_r
    strain[:, 4, :, 0] = -n * over_r
    strain[:, 4, :, 1] = by_r - over_r
    strain[:, 5, :, 1] = by_z
    strain[:, 5, :, 2] = -n * over_r
    return strain.reshape(len(r), 6, 24)


def _elastic() -> Floats:
    """Return the elastic matrix of an isotropic body with E = 1, (6, 6)."""
    lame = POISSON / ((1.0 + POISSON) * (1.0 - 2.0 * POISSON))
    shear = 0.5 / (1.0 + POISSON)
    elastic = np.diag([2.0 * shear] * 3 + [shear] * 3)
    elastic[:3, :3] += lame
    return elastic


def _shape(xi: float, eta: float) -> tuple[Floats, Floats]:
    """Return the shape functions of the eight nodes, (8,), and their derivatives along both axes, (8, 2)."""
    a, b = _CORNERS[:, 0], _CORNERS[:, 1]
    corner = 0.25 * (1 + a * xi) * (1 + b * eta) * (a * xi + b * eta - 1)
    corner_xi = 0.25 * a * (1 + b * eta) * (2 * a * xi + b * eta)
    corner_eta = 0.25 * b * (1 + a * xi) * (2 * b * eta + a * xi)
    c, d = _SIDES[:, 0], _SIDES[:, 1]
    along = c == 0
    side = np.where(along, 0.5 * (1 - xi**2) * (1 + d * eta), 0.5 * (1 + c * xi) * (1 - eta**2))
    side_xi = np.where(along, -xi * (1 + d * eta), 0.5 * c * (1 - eta**2))
    side_eta = np.where(along, 0.5 * d * (1 - xi**2), -eta * (1 + c * xi))
    return (
        np.concatenate([corner, side]),
        np.stack([np.concatenate([corner_xi, side_xi]), np.concatenate([corner_eta, side_eta])], axis=1),
    )


def _load(r_nodes: Floats, radius: float, distance: float, n: int) -> Floats:
    """Return the n-th harmonic of a punch's unit force on the nodes of the surface, ascending in r."""
    u, weight = np.polynomial.legendre.leggauss(16)
    s = radius * np.sqrt(1.0 - (0.5 * (u + 1.0)) ** 2)
    turn = 2.0 * math.pi * (np.arange(48) + 0.5) / 48.0
    x = distance + s[:, None] * np.cos(turn)
    y = s[:, None] * np.sin(turn)
    share = (0.5 * weight[:, None] * np.ones(48) / 48.0 * np.cos(n * np.arctan2(y, x))).ravel()
    r = np.hypot(x, y).ravel()
    lines = r_nodes[::2]
    element = np.clip(np.searchsorted(lines, r, side="right") - 1, 0, len(lines) - 2)
    xi = 2.0 * (r - lines[element]) / (lines[element + 1] - lines[element]) - 1.0
    load = np.zeros(len(r_nodes))
    np.add.at(load, 2 * element, share * 0.5 * xi * (xi - 1.0))
    np.add.at(load, 2 * element + 1, share * (1.0 - xi**2))
    np.add.at(load, 2 * element + 2, share * 0.5 * xi * (xi + 1.0))
    return load


def _graded(length: float, first: float, growth: float) -> Floats:
    """Return lines from 0 to `length` whose steps grow from about `first`."""
    count = max(1, math.ceil(math.log1p(length / first * (growth - 1.0)) / math.log(growth)))
    steps = growth ** np.arange(count)
    return np.concatenate([[0.0], np.cumsum(steps) * length / steps.sum()])


def _with_middles(lines: Floats) -> Floats:
    every = np.empty(2 * len(lines) - 1)
    every[::2], every[1::2] = lines, 0.5 * (lines[1:] + lines[:-1])
    return every
