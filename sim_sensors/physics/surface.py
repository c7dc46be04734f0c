"""Draw height profiles of surfaces, as followed by the ball-shaped tip of the texture sensor.

A surface is a Gaussian process of a given rms height and correlation length. It may have V grooves across the
stroke. The tip rolls over the surface: its path is the dilation of the profile by a ball. Dilation smooths peaks and
lets the tip sink into a groove only as far as it fits.
Constants: docs/decisions/0002-simulated-world.md.
"""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import gaussian_filter1d, grey_dilation

from common.fingers import FINGERS
from common.scenes.surfaces import Grooves, surface_kind

GRID_M = 10e-6
"""Spacing of the profile's samples, m."""
TIP_RADIUS_M = 0.3e-3
GROOVE_WIDTH_M = 0.4e-3
GROOVE_DEPTH_M = 0.25e-3


@dataclass(frozen=True, slots=True)
class Relief:
    """One surface's relief: rms height and correlation length, m; `grooves` is None for a surface without grooves."""

    rms_m: float
    correlation_m: float
    grooves: Grooves | None = None

    @property
    def contact_fraction(self) -> float:
        """Share of the area that touches a flat plate, 0..1; grooves reduce it."""
        if self.grooves is None:
            return 1.0
        return 1.0 - GROOVE_WIDTH_M / (0.5 * sum(self.grooves.apart_m))


ROUGHNESS_M = {
    "aluminium": (0.5e-6, 0.2e-3),
    "ceramic_tile": (0.5e-6, 0.2e-3),
    "pine": (3e-6, 0.4e-3),
    "plain_pvc": (1e-6, 0.2e-3),
    "closely_grooved_pvc": (1e-6, 0.2e-3),
    "arbitrarily_grooved_pvc": (1e-6, 0.2e-3),
    "widely_grooved_pvc": (1e-6, 0.2e-3),
    "sandpaper": (30e-6, 0.08e-3),
    "foam": (8e-6, 0.8e-3),
    "skin": (4e-6, 0.5e-3),
    "lesion": (35e-6, 0.25e-3),
    "nodule": (4e-6, 0.5e-3),
}
"""Rms height and correlation length of every surface in `common.scenes.surfaces`, m."""


@dataclass(frozen=True, slots=True)
class SurfaceProfile:
    """The tip's path over one surface.

    `height_m` and `slope` have shape (fingers, samples), spacing GRID_M from the near edge; every finger has its own
    track. `grooves_m` are the distances of the groove centres from the near edge, ascending, m.
    """

    height_m: NDArray[np.float32]
    slope: NDArray[np.float32]
    grooves_m: tuple[float, ...]


def relief_of(name: str) -> Relief:
    """Return the relief of a surface; raises ValueError, which lists the known ones, where it is unknown."""
    grooves = surface_kind(name).grooves
    return Relief(*ROUGHNESS_M[name], grooves)


def make_profile(
    relief: Relief, length_m: float, rng: np.random.Generator, groove_depth_m: float = GROOVE_DEPTH_M
) -> SurfaceProfile:
    """Draw one realisation of a surface of `length_m` metres for all five fingers."""
    samples = math.ceil(length_m / GRID_M) + 1
    grooves = [] if relief.grooves is None else relief.grooves.draw(length_m, rng)
    height = draw_roughness(relief, samples, rng) + groove_heights(grooves, samples, groove_depth_m)
    path = roll_tip(height)
    path -= np.median(path, axis=1, keepdims=True)  # rolling over a rough surface lifts the tip; only changes matter
    slope = np.gradient(path, GRID_M, axis=1)
    return SurfaceProfile(path.astype(np.float32), slope.astype(np.float32), tuple(grooves))


def draw_roughness(relief: Relief, samples: int, rng: np.random.Generator) -> NDArray[np.float64]:
    """Draw Gaussian heights with autocorrelation exp(-(dx/l)^2): white noise through a Gaussian of width l/2."""
    sigma = relief.correlation_m / (2.0 * GRID_M)
    white = rng.standard_normal((len(FINGERS), samples))
    smooth: NDArray[np.float64] = gaussian_filter1d(white, sigma, axis=1, mode="reflect")
    gain = math.sqrt(2.0 * math.sqrt(math.pi) * sigma)  # restores unit variance after the filter
    return smooth * (gain * relief.rms_m)


def groove_heights(centres: list[float], samples: int, depth_m: float) -> NDArray[np.float64]:
    """Return V notches, with height 0 outside and -`depth_m` at their centres."""
    x = np.arange(samples) * GRID_M
    notch = np.zeros(samples)
    for centre in centres:
        rise = np.abs(x - centre) / (0.5 * GROOVE_WIDTH_M)
        np.minimum(notch, depth_m * (np.minimum(rise, 1.0) - 1.0), out=notch)
    return notch


def roll_tip(height: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the path of the lowest point of a ball of TIP_RADIUS_M that rests on the profile."""
    half = round(TIP_RADIUS_M / GRID_M)
    u = np.arange(-half, half + 1) * GRID_M
    ball = np.sqrt(np.maximum(TIP_RADIUS_M**2 - u**2, 0.0)) - TIP_RADIUS_M
    path: NDArray[np.float64] = grey_dilation(
        height, footprint=np.ones((1, ball.size), dtype=bool), structure=ball[None, :], mode="nearest"
    )
    return path
