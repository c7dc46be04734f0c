"""Simulates touches in the second world: one or more fingers of one kind of sensor on one piece."""

import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.signal import lfilter

from common.scenes.materials import material
from remote_site.thermal.touch_start import find_touch
from remote_site.traces.trace_files import ThermalTrace
from studies.second_world.axisymmetric import SensorOnPiece, alone, build
from studies.second_world.heat_network import Stepper
from studies.second_world.ranges import GAS_W_MK, Piece, Sensor, draw_piece, draw_sensor
from studies.thermal_identification.situations import NEAR_K, Hand

Array = NDArray[np.float64]
AMBIENT_C = 23.0
READING_S = 0.01
STEP_S = 0.005
LEAD_S = 0.8
"""Time from the start of a trace to the first force, s."""
WARM_S = (2.0, 12.0)
"""Range of the time for which the heater has held the plate before the trace begins, s."""
HEATER_W_K = 4.0
"""Gain of the heater's controller, W/K."""
BACK_SHARE = -0.5
"""Heat into the Peltier's back per heat into the plate."""
RAMP_S = (0.06, 0.25)
"""Range of the time in which the force rises, s."""
FORCE_N = (1.05, 1.35)
FORCE_NOISE_N = 0.01
SWAY = 0.04
"""Largest slow change of the force, as a share."""
SOFT_M = 20e-6
"""Height above the first contact at which half of the spots touch at 1 N, m."""
TOUCHED_N = 0.05
"""Force at which half of the contact's conductance is there, N."""
REMAINING_S = 0.03
"""Time in which the heat flow that remains after switching off decays, s."""
SLOW_S = 0.3
"""Correlation time of the slow noise, s."""


@dataclass(frozen=True, slots=True)
class Unit:
    """One finger's sensor: its lag, leak and contact as multiples of those of its kind."""

    lag: float
    leak: float
    contact: float


@dataclass(frozen=True, slots=True)
class Kind:
    """One kind of sensor, and the units of a hand's five fingers."""

    sensor: Sensor
    units: tuple[Unit, ...]

    @classmethod
    def draw(cls, seed: int) -> "Kind":
        """Draw a kind of sensor with five units."""
        sensor = draw_sensor(seed)
        rng = np.random.default_rng([seed, 0x5])
        units = np.exp(sensor.unit_spread * rng.standard_normal((5, 3)))
        return cls(sensor, tuple(Unit(*map(float, row)) for row in units))


@dataclass(frozen=True, slots=True)
class Objects:
    """Touched objects.

    Attributes:
        name: name in the tables.
        above_k: range of their temperatures above ambient, K.
        thickness_m: thickness, m; None as in calibration.
    """

    name: str
    above_k: tuple[float, float] = NEAR_K
    thickness_m: float | None = None


USUAL = Objects("within 3 K")


def simulate_touches(
    kind: Kind,
    name: str,
    seed: int,
    numbers: Iterable[int],
    preheats_k: Sequence[float] = (10.0,),
    seconds: float = 10.05,
    objects: Objects = USUAL,
) -> Iterator[Hand]:
    """Yield touches of new pieces of a material.

    Args:
        kind: the sensors.
        name: material.
        seed: seed of pieces, contacts, forces and noise.
        numbers: numbers of the pieces; a piece depends only on the seed and its number.
        preheats_k: plate above ambient of each finger, K.
        seconds: time in contact, s.
        objects: temperature and thickness of the pieces.
    """
    made_of = material(name)
    for number in numbers:
        rng = np.random.default_rng([seed, number, *made_of.name.encode()])
        piece = draw_piece(made_of, rng, objects.above_k)
        if objects.thickness_m is not None:
            piece = replace(piece, thickness_m=objects.thickness_m)
        fingers = [
            find_touch(_touch(kind.sensor, unit, piece, preheat_k, seconds, rng, f"{name} {number}"))
            for unit, preheat_k in zip(kind.units, preheats_k, strict=False)
        ]
        yield Hand(name, AMBIENT_C + piece.above_k, tuple(each for each in fingers if each is not None))


def _touch(
    sensor: Sensor, unit: Unit, piece: Piece, preheat_k: float, seconds: float, rng: np.random.Generator, name: str
) -> ThermalTrace:
    """Return the trace of one finger."""
    held = _held(sensor, unit, preheat_k, float(rng.uniform(*WARM_S)))
    force_n = _force(seconds, rng)
    thing = build(sensor, unit.leak, piece)
    touch_factor = unit.contact * math.exp(sensor.touch_spread * rng.standard_normal())
    plate_k = _in_contact(sensor, piece, thing, held, force_n, touch_factor)
    lead = round(LEAD_S / STEP_S)
    return _trace(
        sensor,
        unit,
        np.concatenate((held.plate_k[-lead:], plate_k)),
        np.concatenate((np.zeros(lead), force_n)),
        rng,
        name,
    )


@dataclass(frozen=True, slots=True)
class _Held:
    """A sensor whose plate the heater has held.

    Attributes:
        plate_k: mean temperature of the plate in each step, K above ambient.
        nodes_k: temperatures of all nodes at the end, K above ambient.
        power_w: heat into the plate at the end, W.
    """

    plate_k: Array
    nodes_k: Array
    power_w: float


def _held(sensor: Sensor, unit: Unit, preheat_k: float, seconds: float) -> _Held:
    network, plate, back = alone(sensor, unit.leak)
    stepper = Stepper(network, (), STEP_S)
    rings = list(plate)
    share = np.array(network.capacity_j_k)[rings] / sum(network.capacity_j_k[ring] for ring in rings)
    above_k = np.zeros(len(network.capacity_j_k))
    above_k[rings] = preheat_k
    stepper.settle(above_k)
    heat_w, nothing, power_w, sum_k_s = np.zeros(len(above_k)), np.zeros(0), 0.0, 0.0
    course = []
    for _ in range(round((seconds + LEAD_S) / STEP_S)):
        mean_k = float(np.dot(above_k[rings], share))
        course.append(mean_k)
        sum_k_s += (preheat_k - mean_k) * STEP_S
        power_w = HEATER_W_K * (preheat_k - mean_k) + HEATER_W_K * sum_k_s if preheat_k else 0.0
        heat_w[rings] = power_w * share
        heat_w[back] = BACK_SHARE * power_w
        above_k = stepper.step(nothing, heat_w)
    return _Held(np.array(course), above_k, power_w)


def _force(seconds: float, rng: np.random.Generator) -> Array:
    """Return the true force in each step from the first touch on, N."""
    time_s = np.arange(round(seconds / STEP_S)) * STEP_S
    ramp = np.clip(time_s / rng.uniform(*RAMP_S), 0.0, 1.0)
    sway = 1.0 + SWAY * rng.uniform() * np.sin(2.0 * math.pi * (rng.uniform(0.3, 2.0) * time_s + rng.uniform()))
    force_n: Array = rng.uniform(*FORCE_N) * ramp**2 * (3.0 - 2.0 * ramp) * sway
    return force_n


def _in_contact(
    sensor: Sensor, piece: Piece, thing: SensorOnPiece, held: _Held, force_n: Array, factor: float
) -> Array:
    """Return the mean temperature of the plate in each step of a contact, K above ambient."""
    stepper = Stepper(thing.network, list(zip(thing.plate, thing.surface, strict=True)), STEP_S)
    start_k = np.full(len(thing.network.capacity_j_k), piece.above_k)
    start_k[: thing.sensor_nodes] = held.nodes_k
    stepper.settle(start_k)
    share = thing.ring_m2 / thing.ring_m2.sum()
    excess_m = sensor.dome_m * (thing.middle_m / sensor.radius_m) ** 2 + 0.5 * piece.curvature_per_m * thing.middle_m**2
    gas_w_m2k = GAS_W_MK / (sensor.gap_m + 2.0 * piece.rough_m + excess_m)
    conducts = piece.conductivity_w_mk / (piece.conductivity_w_mk + 1.0)
    spots_w_m2k = sensor.spots_w_m2k * conducts / (1.0 + (excess_m / SOFT_M) ** 2)
    rings, heat_w = list(thing.plate), np.zeros(len(start_k))
    course = []
    for step, now_n in enumerate(force_n):
        since_s = step * STEP_S
        power_w = sensor.remaining_w * math.exp(-since_s / REMAINING_S) if since_s >= sensor.off_s else held.power_w
        heat_w[rings] = power_w * share
        heat_w[thing.back] = BACK_SHARE * power_w
        moist = 1.0 + piece.moisture * (1.0 - math.exp(-since_s / piece.moist_s))
        touched = now_n / (now_n + TOUCHED_N)
        contact_w_m2k = factor * moist * touched * (gas_w_m2k + spots_w_m2k * now_n**sensor.spots_power)
        to_middle_w_m2k = contact_w_m2k / (1.0 + contact_w_m2k / thing.half_cell_w_m2k)
        course.append(float(np.dot(stepper.step(to_middle_w_m2k * thing.ring_m2, heat_w)[rings], share)))
    return np.array(course)


def _trace(
    sensor: Sensor, unit: Unit, plate_k: Array, force_n: Array, rng: np.random.Generator, name: str
) -> ThermalTrace:
    """Return what the sensors read of a plate's temperature, K above ambient, and of a force, N."""
    every = round(READING_S / STEP_S)
    read_k = plate_k
    for lag_s in sensor.lag_s:
        read_k = _lagged(read_k, lag_s * unit.lag)
    read_k = read_k[::every]
    time_s = np.asarray(np.arange(len(read_k)) * READING_S, dtype=np.float64)
    read_c = AMBIENT_C + (1.0 - sensor.stem) * read_k + sensor.self_heating_k
    read_c += sensor.drift_k_s * rng.standard_normal() * time_s
    read_c += _slow_noise(len(read_k), sensor.slow_noise_k, rng) + sensor.noise_k * rng.standard_normal(len(read_k))
    shown_c = sensor.step_k * np.round(read_c / sensor.step_k)
    late = round(sensor.force_delay_s / STEP_S)
    shown_n = np.concatenate((np.zeros(late), force_n))[: len(force_n) : every]
    ambient_c = AMBIENT_C + sensor.ambient_offset_k + _slow_noise(len(read_k), 0.02, rng)
    return ThermalTrace(
        time_s, shown_c, shown_n + FORCE_NOISE_N * rng.standard_normal(len(shown_n)), ambient_c, name=name
    )


def _lagged(values: Array, lag_s: float) -> Array:
    keep = math.exp(-STEP_S / lag_s)
    found: Array = lfilter([1.0 - keep], [1.0, -keep], values, zi=[keep * values[0]])[0]
    return found


def _slow_noise(count: int, sd_k: float, rng: np.random.Generator) -> Array:
    """Return noise with the correlation time SLOW_S."""
    keep = math.exp(-READING_S / SLOW_S)
    steps = rng.standard_normal(count + 1)
    steps *= np.append(sd_k, np.full(count, sd_k * math.sqrt(1.0 - keep * keep)))
    found: Array = lfilter([1.0], [1.0, -keep], steps)[:-1]
    return found
