"""Draw random phantoms with nodules, and press on them as a robot does; all from a seed.

A press lowers the probe until it meets `CONTACT_N`; depth counts from there. It then goes deeper in equal steps, until
the last one or `FORCE_LIMIT_N`. Meanwhile the surface breathes. Where the surface is tilted against the press, the
depth along its normal is smaller by cos(tilt), and friction bears a part of the load:

    force along the press = normal force * (cos(tilt) + min(friction, tan(tilt)) * sin(tilt))
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sim_sensors.tissue.contrast import Sphere
from sim_sensors.tissue.ground import Ground, force_at
from studies.nodules.ranges import (
    CONTACT_N,
    DEPTH_STEPS,
    FORCE_LIMIT_N,
    PRESS_S,
    RANGES,
    STEP_S,
    Range,
    Ranges,
)

Floats = NDArray[np.float64]

_JITTER = 0.25
"""Largest shift of a press from its place in the raster, in pitches of the raster."""
_ATTEMPTS = 200
_DEEPEST_MM = 10.0
"""Depth to which a press goes to meet the contact force, mm."""
_STREAM = 0x0D


@dataclass(frozen=True, slots=True)
class Phantom:
    """A phantom, and how it is pressed; `ranges.Ranges` describes the quantities."""

    seed: int
    ground: Ground
    spheres: tuple[Sphere, ...]
    ground_sd: float
    ground_length_mm: float
    tilt_deg: float
    breath_mm: float
    breaths_per_min: float
    friction: float
    force_noise_n: float
    place_noise_mm: float
    depth_noise_mm: float
    press_mm: float
    presses_a_side: int


@dataclass(frozen=True, slots=True)
class Presses:
    """What a detector gets: readings of all presses on one phantom.

    Attributes:
        x_mm: stated places, (presses,); the square is 0..`side_mm` along x and y.
        y_mm: likewise.
        time_s: times of the readings, (presses, DEPTH_STEPS); contact is one `STEP_S` before the first.
        depth_mm: stated depths below the first contact, (presses, DEPTH_STEPS).
        force_n: measured forces, (presses, DEPTH_STEPS); NaN after the limit of force.
        probe_mm: radius of the probe.
        side_mm: side of the square.
    """

    x_mm: Floats
    y_mm: Floats
    time_s: Floats
    depth_mm: Floats
    force_n: Floats
    probe_mm: float
    side_mm: float


def draw_phantom(seed: int, ranges: Ranges = RANGES) -> Phantom:
    """Draw a phantom; the same seed gives the same one."""
    rng = np.random.default_rng([seed, _STREAM])
    layer_mm = _between(rng, ranges.layer_mm)
    return Phantom(
        seed=seed,
        ground=Ground(
            young_kpa=_logarithmic(rng, ranges.ground_kpa),
            exponent=_between(rng, ranges.exponent),
            layer_mm=layer_mm,
            probe_mm=_between(rng, ranges.probe_mm),
        ),
        spheres=_draw_spheres(rng, ranges, layer_mm),
        ground_sd=_between(rng, ranges.ground_sd),
        ground_length_mm=_between(rng, ranges.ground_length_mm),
        tilt_deg=_between(rng, ranges.tilt_deg),
        breath_mm=_between(rng, ranges.breath_mm),
        breaths_per_min=_between(rng, ranges.breaths_per_min),
        friction=_logarithmic(rng, ranges.friction),
        force_noise_n=_logarithmic(rng, ranges.force_noise_n),
        place_noise_mm=_between(rng, ranges.place_noise_mm),
        depth_noise_mm=_between(rng, ranges.depth_noise_mm),
        press_mm=_between(rng, ranges.press_mm),
        presses_a_side=int(rng.choice(ranges.presses_a_side)),
    )


def press(phantom: Phantom, places_mm: Floats | None = None) -> Presses:
    """Press on a phantom.

    Args:
        phantom: the phantom; its seed is the source of all noise.
        places_mm: stated places of the presses, (presses, 2); the phantom's raster by default.
    """
    rng = np.random.default_rng([phantom.seed, _STREAM, 1])
    places = raster(phantom.presses_a_side, rng) if places_mm is None else places_mm
    count = len(places)
    there = places + phantom.place_noise_mm * rng.standard_normal(places.shape)
    softness = np.exp(_field(there, phantom, rng))
    depths, force = force_at(phantom.ground, phantom.spheres, there[:, 0], there[:, 1], _DEEPEST_MM)
    phase = rng.uniform(0.0, 2.0 * math.pi)
    noise = rng.standard_normal((2, count, DEPTH_STEPS))
    return readings(phantom, places, depths, force * softness[:, None], phase, noise)


def readings(
    phantom: Phantom, places_mm: Floats, depths_mm: Floats, normal_n: Floats, phase: float, noise: Floats
) -> Presses:
    """Return the readings of presses with known courses of force, one press each `PRESS_S`.

    Args:
        phantom: the phantom.
        places_mm: stated places, (presses, 2).
        depths_mm: depths of the courses, ascending from 0.
        normal_n: force along the surface's normal at these depths, (presses, depths).
        phase: phase of breathing at the start, rad.
        noise: standard normal noise of force and depth readings, (2, presses, DEPTH_STEPS).
    """
    tilt = math.radians(phantom.tilt_deg)
    along = math.cos(tilt) + min(phantom.friction, math.tan(tilt)) * math.sin(tilt)
    travel = np.concatenate([[0.0], phantom.press_mm * (np.arange(DEPTH_STEPS) + 1.0) / DEPTH_STEPS])
    time_s = PRESS_S * np.arange(len(places_mm))[:, None] + STEP_S * np.arange(DEPTH_STEPS + 1)
    rise = phantom.breath_mm * np.sin(2.0 * math.pi * phantom.breaths_per_min / 60.0 * time_s + phase)
    true_force = np.empty((len(places_mm), DEPTH_STEPS))
    for number, course in enumerate(normal_n * along):
        contact_mm = float(np.interp(CONTACT_N, course, depths_mm))
        deep = contact_mm + (travel[1:] + rise[number, 1:] - rise[number, 0]) * math.cos(tilt)
        true_force[number] = np.interp(np.maximum(deep, 0.0), depths_mm, course)
    beyond = np.maximum.accumulate(true_force > FORCE_LIMIT_N, axis=1)
    return Presses(
        places_mm[:, 0],
        places_mm[:, 1],
        time_s[:, 1:],
        travel[1:] + phantom.depth_noise_mm * noise[1],
        np.where(beyond, np.nan, true_force + phantom.force_noise_n * noise[0]),
        phantom.ground.probe_mm,
        RANGES.side_mm,
    )


def grid_mm(x_mm: NDArray[np.floating[Any]], y_mm: NDArray[np.floating[Any]]) -> Floats:
    """Return all places with one of these x and one of these y, (places, 2), mm; y changes first."""
    return np.asarray(np.stack(np.meshgrid(x_mm, y_mm, indexing="ij"), axis=-1).reshape(-1, 2), dtype=np.float64)


def distances_mm(one: Floats, other: Floats) -> Floats:
    """Return the distance of each of n places from each of m others, (n, m), mm."""
    return np.asarray(np.hypot(*(one[:, None, axis] - other[None, :, axis] for axis in (0, 1))))


def raster(a_side: int, rng: np.random.Generator) -> Floats:
    """Return places on a square raster, each shifted a little, (a_side^2, 2), mm."""
    pitch = RANGES.side_mm / a_side
    line = (np.arange(a_side) + 0.5) * pitch
    places = grid_mm(line, line)
    return np.asarray(places + pitch * _JITTER * rng.uniform(-1.0, 1.0, places.shape))


def _draw_spheres(rng: np.random.Generator, ranges: Ranges, layer_mm: float) -> tuple[Sphere, ...]:
    """Draw nodules that fit into the layer and beside each other; draw again where they do not."""
    count = int(rng.choice(len(ranges.nodules), p=ranges.nodules))
    spheres: list[Sphere] = []
    for _ in range(_ATTEMPTS):
        if len(spheres) == count:
            break
        place = rng.uniform(ranges.margin_mm, ranges.side_mm - ranges.margin_mm, 2)
        new = Sphere(
            float(place[0]),
            float(place[1]),
            _logarithmic(rng, ranges.size_mm),
            _logarithmic(rng, ranges.depth_mm),
            _logarithmic(rng, ranges.ratio),
        )
        fits = new.depth_mm + new.size_mm + ranges.beneath_mm <= layer_mm
        if fits and all(_gap_mm(new, other) >= ranges.apart_mm for other in spheres):
            spheres.append(new)
    return tuple(spheres)


def _gap_mm(a: Sphere, b: Sphere) -> float:
    return math.hypot(a.x_mm - b.x_mm, a.y_mm - b.y_mm) - 0.5 * (a.size_mm + b.size_mm)


def _field(places: Floats, phantom: Phantom, rng: np.random.Generator) -> Floats:
    """Draw the natural variation of ln(stiffness) at the places, (presses,)."""
    covariance = np.exp(-0.5 * (distances_mm(places, places) / phantom.ground_length_mm) ** 2)
    root = np.linalg.cholesky(covariance + 1e-6 * np.eye(len(places)))
    return np.asarray(phantom.ground_sd * (root @ rng.standard_normal(len(places))))


def _between(rng: np.random.Generator, limits: Range) -> float:
    return float(rng.uniform(*limits))


def _logarithmic(rng: np.random.Generator, limits: Range) -> float:
    return float(math.exp(rng.uniform(math.log(limits[0]), math.log(limits[1]))))
