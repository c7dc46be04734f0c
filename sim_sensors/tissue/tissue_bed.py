"""Soft tissue of a scene's object in a session: height of its surface and stiffness under a finger at any time.

The force that nodules, layer and natural variation add is laid out on a grid of depth and place at the start. A tick
reads between the grid's places, in some microseconds for a finger.
"""

import math

import numpy as np
from scipy.ndimage import gaussian_filter

from common.scenes.scene import SceneObject
from common.scenes.tissue import Tissue
from sim_sensors.tissue.contrast import Sphere
from sim_sensors.tissue.ground import REFERENCE_MM, SUBSTEPS, Ground, force_at

FINGER_MM = 6.0
"""Radius of a fingertip, mm."""
PITCH_MM = 1.0
"""Spacing of the grid's places, mm."""
DEEPEST_MM = 8.0
"""Greatest depth of the grid, mm."""
SHALLOWEST_M = 0.05e-3
"""Depth at which the stiffness of a first contact is taken, m."""
DRAG = 0.3
"""Shift of tissue at a nodule's depth by a stroking finger, in friction times depth of the press. A tangential load Q
moves a point at depth z by Q / (4 pi G z) (Cerruti), and the surface under it by 3 Q / (16 G a); z is about 2 a."""
STROKING_M_S = 0.002
"""Speed from which on a finger drags the tissue, m/s."""


class TissueBed:
    """Tissue of one object."""

    def __init__(self, thing: SceneObject, tissue: Tissue, rng: np.random.Generator) -> None:
        """Lay out the grid of an object with edges in y; all randomness comes from `rng`."""
        self._tissue = tissue
        self._height_m = thing.height_m
        self._middle_m = thing.middle_m
        self._slopes = tuple(math.tan(math.radians(tilt)) for tilt in tissue.tilt_deg)
        self._reference_n_m = thing.stiffness
        low_y_m, high_y_m = thing.y_range_m
        self._low_m = thing.x_m, low_y_m
        x_mm = np.arange(0.0, 1e3 * thing.length_m + PITCH_MM, PITCH_MM)
        y_mm = np.arange(0.0, 1e3 * (high_y_m - low_y_m) + PITCH_MM, PITCH_MM)
        self._columns, self._rows = len(x_mm), len(y_mm)
        ground = Ground(1.0, tissue.exponent, 1e3 * tissue.layer_m, FINGER_MM)
        spheres = [
            Sphere(1e3 * (n.x_m - thing.x_m), 1e3 * (n.y_m - low_y_m), 1e3 * n.size_m, 1e3 * n.depth_m, n.ratio)
            for n in tissue.nodules
        ]
        places = np.stack(np.meshgrid(x_mm, y_mm, indexing="ij"), axis=-1).reshape(-1, 2)
        depths, force = force_at(ground, spheres, places[:, 0], places[:, 1], DEEPEST_MM)
        _, plain = force_at(ground, [], np.zeros(1), np.zeros(1), DEEPEST_MM)
        law = np.interp(REFERENCE_MM, depths, plain[0]) * (depths[1:] / REFERENCE_MM) ** tissue.exponent
        factor = force[:, 1:] / law * np.exp(self._variation(rng))[:, None]
        factor = np.concatenate([factor[:, :1], factor], axis=1)
        self._factor = np.ascontiguousarray(factor).ravel().data

    def under(
        self, time_s: float, x_m: float, y_m: float, z_m: float, velocity_m_s: tuple[float, float]
    ) -> tuple[float, float]:
        """Return the height of the surface below a finger at a place, m, and the force per depth there, N/m.

        `velocity_m_s` is the finger's along the bench.
        """
        tissue, middle = self._tissue, self._middle_m
        breath = 2.0 * math.pi * tissue.breaths_per_min / 60.0 * time_s
        surface_m = self._height_m + tissue.breath_m * math.sin(breath)
        surface_m += self._slopes[0] * (x_m - middle[0]) + self._slopes[1] * (y_m - middle[1])
        depth_m = max(surface_m - z_m, SHALLOWEST_M)
        speed_m_s = math.hypot(*velocity_m_s)
        if speed_m_s > STROKING_M_S:
            drag_m = DRAG * tissue.friction * depth_m / speed_m_s
            x_m, y_m = x_m - drag_m * velocity_m_s[0], y_m - drag_m * velocity_m_s[1]
        law_n_m = self._reference_n_m * (1e3 * depth_m / REFERENCE_MM) ** (tissue.exponent - 1.0)
        low_x_m, low_y_m = self._low_m
        return surface_m, law_n_m * self._read(1e3 * depth_m, 1e3 * (x_m - low_x_m), 1e3 * (y_m - low_y_m))

    def _read(self, depth_mm: float, x_mm: float, y_mm: float) -> float:
        """Return the grid's factor at a depth and a place from the near corner; the edge's value beyond the edge."""
        layers = SUBSTEPS + 1
        k, c = _between(depth_mm * SUBSTEPS / DEEPEST_MM, layers)
        i, a = _between(x_mm / PITCH_MM, self._columns)
        j, b = _between(y_mm / PITCH_MM, self._rows)
        grid, near = self._factor, (i * self._rows + j) * layers + k
        far = near + self._rows * layers
        first = (1.0 - b) * grid[near] + b * grid[near + layers]
        second = (1.0 - b) * grid[far] + b * grid[far + layers]
        shallow = (1.0 - a) * first + a * second
        first = (1.0 - b) * grid[near + 1] + b * grid[near + layers + 1]
        second = (1.0 - b) * grid[far + 1] + b * grid[far + layers + 1]
        return (1.0 - c) * shallow + c * ((1.0 - a) * first + a * second)

    def _variation(self, rng: np.random.Generator) -> "np.ndarray[tuple[int], np.dtype[np.float64]]":
        """Draw the natural variation of ln(stiffness) at the grid's places, in one row."""
        tissue = self._tissue
        sigma = 1e3 * tissue.variation_m / PITCH_MM / math.sqrt(2.0)
        # A Gaussian of this width in white noise gives the correlation exp(-(r / length)^2 / 2).
        drawn = gaussian_filter(rng.standard_normal((self._columns, self._rows)), sigma, mode="reflect")
        gain = 2.0 * math.sqrt(math.pi) * sigma
        return np.asarray(tissue.variation * gain * drawn.ravel())


def _between(place: float, count: int) -> tuple[int, float]:
    """Return the node below a place on an axis of `count` nodes, and the share of the way to the next one, 0..1."""
    place = min(max(place, 0.0), count - 1.0)
    node = min(int(place), count - 2)
    return node, place - node
