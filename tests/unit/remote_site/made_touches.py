"""Touches made up for tests by a physics of their own: a plate on a bar of finite volumes, and its closed forms.

Nothing here comes from the estimator or from the simulated world, so that an error of either shows. Constants of the
sensor are per area and in SI units; everything is computed in C and s.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import expm
from scipy.special import wofz

from remote_site.thermal.material_table import MaterialEntry, MaterialTable

Array = NDArray[np.float64]
Force = Callable[[Array], Array]

PLATE_J_M2K = 1980.0
STEP_S = 0.001
READING_S = 0.01
FREE_S = 0.5
"""Readings before contact, s."""
AMBIENT_C = 23.0
FULL_SCALE_C, COUNTS = 100.0, 4096


def pressed(force_n: float = 1.2, ramp_s: float = 0.08) -> Force:
    """A force that rises from 0.3 N at contact to `force_n`."""
    return lambda t_s: np.where(t_s < 0.0, 0.0, 0.3 + (force_n - 0.3) * np.clip(t_s / ramp_s, 0.0, 1.0))


@dataclass(frozen=True)
class MadeSensor:
    """A thermal sensor.

    Attributes:
        leak_w_m2k: conductance from the plate into its back.
        back_share: where the back is at contact between ambient (0) and plate (1); it stays there.
        lag_s: of the read-out.
        half_force_n: force at which the contact conducts half as well as at large force.
        force_power: a light contact conducts like this power of the force.
        noise_k: white noise of a reading, before its 12 bits.
    """

    leak_w_m2k: float = 80.0
    back_share: float = 0.3
    lag_s: float = 0.3
    half_force_n: float = 0.3
    force_power: float = 1.0
    noise_k: float = 0.02


@dataclass(frozen=True)
class MadeMaterial:
    """A material as the sensor meets it: effusivity, J/(m2 K s^0.5), contact conductance at large force, W/(m2 K).

    `slab_s` is thickness^2 / diffusivity, s; the scatters are of logarithms, from piece to piece and touch to touch.
    """

    effusivity: float
    conductance_w_m2k: float
    slab_s: float = np.inf
    piece_sd: float = 0.05
    contact_sd: float = 0.08


SENSOR = MadeSensor()
MATERIALS = {
    "metal": MadeMaterial(14000.0, 2200.0),
    "stone": MadeMaterial(1900.0, 1700.0),
    "plastic": MadeMaterial(480.0, 900.0),
}


def bar(slab_s: float, cells: int = 40) -> tuple[Array, Array, float]:
    """Heat conduction over one STEP_S in a bar of unit effusivity: what remains of each cell, what a unit flux adds.

    And the way from the surface to the middle of the first cell. The depth is measured in sqrt(s), which makes
    diffusivity one; the far end is insulated.
    """
    if np.isinf(slab_s):
        width = 0.004 * 1.22 ** np.arange(cells)
    else:
        shape = 1.12 ** np.arange(cells)
        width = shape * np.sqrt(slab_s) / shape.sum()
    between = 2.0 / (width[:-1] + width[1:])
    matrix = np.zeros((cells + 1, cells + 1))  # the last column is a steady flux into the first cell
    for k in range(cells - 1):
        matrix[k, k] -= between[k] / width[k]
        matrix[k, k + 1] += between[k] / width[k]
        matrix[k + 1, k + 1] -= between[k] / width[k + 1]
        matrix[k + 1, k] += between[k] / width[k + 1]
    matrix[0, cells] = 1.0 / width[0]
    step = expm(matrix * STEP_S)
    return step[:cells, :cells], step[:cells, cells], 0.5 * float(width[0])


def plate_courses(
    effusivity: Array,
    conductance_w_m2k: Array,
    object_c: Array,
    start_c: Array,
    seconds: float,
    sensor: MadeSensor = SENSOR,
    slab_s: float = np.inf,
    force: Force | None = None,
    ambient_c: float = AMBIENT_C,
) -> Array:
    """Readings without noise of n touches, (n, k), every READING_S from the first after contact on."""
    force = force or pressed()
    remains, warms, middle = bar(slab_s)
    n, steps = len(effusivity), round(seconds / STEP_S)
    object_k = np.zeros((len(remains), n))
    plate_k, back_k = start_c - object_c, ambient_c + sensor.back_share * (start_c - ambient_c) - object_c
    read_k = plate_k.copy()
    pressing = np.maximum(force(STEP_S * (np.arange(steps) + 0.5)), 0.0)
    pressing = (pressing / sensor.half_force_n) ** sensor.force_power
    share = pressing / (1.0 + pressing)
    leak, slow = sensor.leak_w_m2k * STEP_S / PLATE_J_M2K, np.exp(-STEP_S / sensor.lag_s)
    readings = np.empty((n, steps // 10))
    for k in range(steps):
        # from the plate through the contact and half a cell: flux with plate and cell at the end of the step
        conductance = conductance_w_m2k * share[k]
        conductance = conductance / (1.0 + conductance * middle / effusivity)
        coasting = remains @ object_k
        flux = conductance * ((plate_k + leak * back_k) / (1.0 + leak) - coasting[0])
        flux /= 1.0 + conductance * (STEP_S / PLATE_J_M2K / (1.0 + leak) + warms[0] / effusivity)
        before_k = plate_k
        plate_k = (plate_k + leak * back_k - flux * STEP_S / PLATE_J_M2K) / (1.0 + leak)
        object_k = coasting + warms[:, None] * flux / effusivity
        read_k = slow * read_k + (1.0 - slow) * 0.5 * (before_k + plate_k)
        if k % 10 == 9:
            readings[:, k // 10] = read_k
    return readings + object_c[:, None]


def measured(readings_c: Array, sensor: MadeSensor, rng: np.random.Generator) -> Array:
    """Readings with noise and 12 bits."""
    step_c = FULL_SCALE_C / COUNTS
    noisy = readings_c + sensor.noise_k * rng.normal(size=readings_c.shape)
    return np.asarray(np.round(noisy / step_c) * step_c)


@dataclass(frozen=True)
class MadeTouch:
    """One touch, readings at 100 Hz; the first at or after `time_s` 0 is the first in contact."""

    name: str
    time_s: Array
    sensor_c: Array
    force_n: Array
    object_c: float
    effusivity: float
    ambient_c: float = AMBIENT_C
    reference_c: Array | None = None

    @property
    def start_c(self) -> float:
        """Mean of the last readings before contact, C."""
        return float(self.sensor_c[self.time_s < -1e-9][-5:].mean())

    def after(self) -> list[tuple[float, float, float]]:
        """Time, s, reading, C, and force, N, of all samples after contact."""
        later = self.time_s > 1e-9
        rows = zip(self.time_s[later], self.sensor_c[later], self.force_n[later], strict=True)
        return [(float(t), float(c), float(f)) for t, c, f in rows]

    def where(self, kept: NDArray[np.bool_]) -> "MadeTouch":
        """Some of its readings."""
        columns = {"time_s": self.time_s, "sensor_c": self.sensor_c, "force_n": self.force_n}
        if self.reference_c is not None:
            columns["reference_c"] = self.reference_c
        return replace(self, **{name: column[kept] for name, column in columns.items()})

    def until(self, seconds: float) -> "MadeTouch":
        """The same touch, cut off."""
        return self.where(self.time_s <= seconds + 1e-9)

    def write(self, path: Path, *, ambient: bool = True, clock_s: float = 0.0) -> Path:
        """As a trace file; its clock starts at `clock_s`."""
        columns = {"time_s": clock_s + self.time_s - self.time_s[0], "sensor_c": self.sensor_c, "force_n": self.force_n}
        if ambient:
            columns["ambient_c"] = np.full_like(self.time_s, self.ambient_c)
        if self.reference_c is not None:
            columns["reference_c"] = self.reference_c
        rows = zip(*columns.values(), strict=True)
        lines = [",".join(columns), *(",".join(f"{value:.6g}" for value in row) for row in rows)]
        path.write_text("\n".join(lines) + "\n", "utf-8")
        return path


def made_touches(
    name: str,
    count: int,
    seed: int,
    seconds: float = 7.1,
    start_c: float | Array = AMBIENT_C + 10.0,
    object_c: float | Array | None = None,
    same_piece: bool = False,
    sensor: MadeSensor = SENSOR,
    material: MadeMaterial | None = None,
    force: Force | None = None,
) -> list[MadeTouch]:
    """Touches of one material, drawn at random.

    Args:
        name: of the material.
        count: number of touches.
        seed: of the random draws.
        seconds: length in contact, s.
        start_c: plate at contact, C; one or one for each touch.
        object_c: objects, C; within 3 K of ambient where not given.
        same_piece: all touches are of one piece at one temperature: fingers of one hand.
        sensor: that measures.
        material: in place of the usual one of that name.
        force: in place of `pressed()`.
    """
    material, force = material or MATERIALS[name], force or pressed()
    rng = np.random.default_rng(seed)
    pieces, draws = (1 if same_piece else count), np.ones(count)
    effusivity = material.effusivity * np.exp(material.piece_sd * rng.normal(size=pieces)) * draws
    drawn_c = AMBIENT_C + rng.uniform(-3.0, 3.0, size=pieces)
    objects_c = (drawn_c if object_c is None else np.asarray(object_c)) * draws
    conductance = material.conductance_w_m2k * np.exp(material.contact_sd * rng.normal(size=count))
    starts_c = np.asarray(start_c) * draws
    courses = plate_courses(effusivity, conductance, objects_c, starts_c, seconds, sensor, material.slab_s, force)
    free = np.repeat(starts_c[:, None], round(FREE_S / READING_S) + 1, axis=1)
    readings = measured(np.hstack((free, courses)), sensor, rng)
    time_s = READING_S * (np.arange(readings.shape[1]) - round(FREE_S / READING_S))
    force_n = force(time_s)
    return [
        MadeTouch(name, time_s, readings[k], force_n, float(objects_c[k]), float(effusivity[k])) for k in range(count)
    ]


def free_cooling(sensor: MadeSensor = SENSOR, start_c: float = AMBIENT_C + 10.0, seed: int = 0) -> MadeTouch:
    """A plate that cools freely to its back, which is at ambient, for 20 s."""
    time_s = READING_S * np.arange(2000)
    above_k = (start_c - AMBIENT_C) * np.exp(-sensor.leak_w_m2k / PLATE_J_M2K * time_s)
    readings = measured(AMBIENT_C + above_k, sensor, np.random.default_rng(seed))
    return MadeTouch("air", time_s, readings, np.zeros(len(time_s)), AMBIENT_C, 0.0)


def true_table(materials: dict[str, MadeMaterial] = MATERIALS, sensor: MadeSensor = SENSOR) -> MaterialTable:
    """The table that a perfect calibration of `sensor` would give; what it says of Eq. 11's rates is arbitrary."""
    return MaterialTable(
        ambient_c=AMBIENT_C,
        plate_j_m2k=PLATE_J_M2K,
        leak_per_s=sensor.leak_w_m2k / PLATE_J_M2K,
        half_force_n=sensor.half_force_n,
        force_power=sensor.force_power,
        early_s=0.0,
        back_share=sensor.back_share,
        back_sd_k=0.3,
        start_sd_k=0.03,
        ln_lag=float(np.log(sensor.lag_s)),
        ln_lag_sd=0.05,
        noise_k=float(np.hypot(max(sensor.noise_k, 0.005), FULL_SCALE_C / COUNTS / np.sqrt(12.0))),
        times_s=[1.0, 2.0, 4.0],
        materials=[
            MaterialEntry(
                name=name,
                touches=20,
                ln_effusivity=float(np.log(material.effusivity / PLATE_J_M2K)),
                ln_conductance=float(np.log(material.conductance_w_m2k / PLATE_J_M2K)),
                covariance=[[material.piece_sd**2, 0.0], [0.0, material.contact_sd**2]],
                slab_s=None if np.isinf(material.slab_s) else material.slab_s,
                offset_k=0.0,
                offset_sd_k=1.75,
                ln_rate=[-0.2 * number] * 3,
                ln_rate_sd=[0.1] * 3,
                misfit=1.0,
            )
            for number, (name, material) in enumerate(materials.items())
        ],
    )


def closed_form(times_s: Array, effusivity: float, conductance: float, leak: float, lag_s: float) -> Array:
    """Reading per kelvin of object, plate at contact and back, (k, 3), from 0 at contact, on a half space.

    All constants over the plate's heat capacity, as in 1/s and 1/sqrt(s). With p = sqrt(s) every course is a ratio of
    polynomials in p; each root r contributes r wofz(-i r sqrt(t)) (inverse Laplace transform of 1 / (sqrt(s) - r)). A
    plate that is in equilibrium with its resistor makes up for what that still has of its own temperature.
    """
    resistance = np.polynomial.Polynomial([1.0, effusivity / conductance])  # (R e p + 1)
    plate = np.polynomial.Polynomial([leak, 0.0, 1.0])
    lag = np.polynomial.Polynomial([1.0, 0.0, lag_s])
    flow = np.polynomial.Polynomial([0.0, effusivity])
    whole = plate * resistance + flow
    by_plate = _inverse(times_s, resistance, whole * lag)
    # a step of the back is leak / s: a pole at p = 0 of which 1 remains permanently
    by_back = 1.0 + _inverse(times_s, leak * resistance, whole * lag, over_s=True) if leak else np.zeros_like(by_plate)
    start = np.exp(-times_s / lag_s)
    return np.column_stack((1.0 - by_plate - by_back - start, by_plate, by_back))


def _inverse(
    times_s: Array,
    above: np.polynomial.Polynomial,
    below: np.polynomial.Polynomial,
    *,
    over_s: bool = False,
) -> Array:
    """Of above / below (over s = p^2), all roots simple; without the permanent part of the pole at 0."""
    total = np.zeros(len(times_s), dtype=complex)
    for root in below.roots().astype(complex):
        part = above(root) / below.deriv()(root) / (root**2 if over_s else 1.0)
        total += part * root * wofz(-1j * root * np.sqrt(times_s))
    return np.asarray(total.real)
