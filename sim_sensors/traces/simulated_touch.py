"""Simulate many single thermal touches at once with the physics of the simulated world.

Each touch is a separate session: sensor, specimen, object temperature, contact and force are drawn for it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypedDict, Unpack
from zlib import crc32

import numpy as np
from numpy.typing import NDArray

from common.limits import CONTACT_FORCE_N, SENSOR_PLATE_C
from common.scenes.materials import material
from common.scenes.surfaces import surface_kind
from sim_sensors.physics.bench import Specimen
from sim_sensors.physics.fingertip import Fingertip, pressing_depth_m
from sim_sensors.physics.object_column import ObjectColumn, object_column
from sim_sensors.physics.remote_world import FORCE_NOISE_N, HOVER_M
from sim_sensors.physics.ssr_converter import celsius_of
from sim_sensors.physics.surface import Relief, relief_of
from sim_sensors.physics.thermal_touch import (
    STAGE_S,
    STEP_S,
    TOUCH_SPREAD,
    SensorSpread,
    ThermalTouch,
    draw_touch_factor,
    force_share,
    full_conductance_w_m2k,
)
from sim_sensors.physics.true_mode import CONTACT_N

Array = NDArray[np.float64]

AIR = "air"
"""Name in place of a material for a free cool-down: the heater switches off at the time of the other touches."""
LEAD_S = 1.0
"""Approximate time from the start of a trace to contact, s."""
LOWER_S = 0.35
LOWER_AHEAD_S = 0.25
TICK_S = 0.002
BLOCK_M = 0.020
"""Default thickness of the touched block, m."""
WARM_S = (0.0, 10.0)
"""Range of the sensor's time at its target before the trace starts, s, drawn for each touch. It extends from the pause
between two touches of a session to a long wait."""
REACH_S_K = 0.2
"""Heater's time for each kelvin of pre-heating, s/K."""
FORCE_SPREAD = (0.9, 1.1)
CHANGE_S = 0.05
"""Duration of a change of force or of a lift, s."""
PREHEAT_PER_K = 2.0

_POLISHED = ("aluminium", "copper", "brass", "iron", "carbon_steel", "stainless_304")
_GLAZED = ("ceramic_tile", "alumina", "glass", "marble", "granite")
_BODY = ("skin_dermis", "soft_tissue", "fat", "gelatin_10pct")
_SURFACE_OF = (
    dict.fromkeys(_POLISHED, "aluminium")
    | dict.fromkeys(_GLAZED, "ceramic_tile")
    | dict.fromkeys(("pine", "oak", "cork"), "pine")
    | dict.fromkeys(_BODY, "skin")
    | {"pu_foam": "foam"}
)
"""Surface of a block by its material; any other material is as smooth as plain PVC."""


@dataclass(frozen=True, slots=True)
class ThermalTrace:
    """One touch at 100 Hz with its true values.

    `contact_s` is the time at which the true force first reaches 0.30 N; in air, the heater switches off then.
    `conductance_w_m2k` is the contact conductance at the resting force. In air it is 0, and `object_c` is None.
    """

    time_s: Array
    sensor_c: Array
    force_n: Array
    ambient_c: Array
    object_c: float | None
    contact_s: float
    conductance_w_m2k: float


@dataclass(frozen=True, slots=True)
class _Touched:
    """Everything drawn for one touch except the sensor."""

    column: ObjectColumn
    object_c: float
    full_w_m2k: float
    force_n: float

    @classmethod
    def draw(
        cls,
        name: str,
        relief: Relief,
        fingers: int,
        *,
        object_c: tuple[float, float],
        force_n: float,
        thickness_m: float | None,
        contact_spread: float,
        block: bool,
        rng: np.random.Generator,
    ) -> "list[_Touched]":
        """Draw one object under `fingers` fingers: common piece and temperature, separate contacts and forces."""
        specimen = Specimen.draw(material(name), rng, block=block)
        full = full_conductance_w_m2k(specimen.conductivity_w_mk, relief.rms_m)
        column = object_column(specimen.conductivity_w_mk, specimen.heat_j_m3k, thickness_m, STAGE_S)
        one_c = rng.uniform(*object_c)
        return [
            cls(column, one_c, full * draw_touch_factor(rng, contact_spread), force_n * rng.uniform(*FORCE_SPREAD))
            for _ in range(fingers)
        ]


class TouchOptions(TypedDict, total=False):
    """Options of simulated touches; `simulate_hand` has their defaults.

    Attributes:
        touches: number of independent touches.
        seconds: time in contact, s.
        force_n: nominal resting force, N; each touch draws 0.9..1.1 of it.
        ambient_c: room temperature, C.
        offset_c: range of the object's temperature relative to ambient, K.
        thickness_m: thickness of the block; None: half space.
        contact_spread: one standard deviation of ln(contact conductance) from touch to touch.
        block: whether all touches meet the known block of the material instead of a new piece each.
        later: time after contact, s, and factor by which the force then changes; a factor of 0 lifts the finger.
    """

    touches: int
    seconds: float
    force_n: float
    ambient_c: float
    offset_c: tuple[float, float]
    thickness_m: float | None
    contact_spread: float
    block: bool
    later: tuple[float, float] | None


def simulate_thermal(
    material_name: str, seed: int, *, preheat_k: float = 10.0, **options: Unpack[TouchOptions]
) -> list[ThermalTrace]:
    """Touch a block with a sensor pre-heated to ambient + `preheat_k` (never above its limit).

    Args:
        material_name: a material or alias, or `air`.
        seed: source of all randomness, combined with the material; two materials never share their draws.
        preheat_k: sensor's start above ambient, K.
        options: see `TouchOptions`.

    Raises:
        ValueError: unknown material, or a number out of range.
    """
    hands = simulate_hand(material_name, seed, (preheat_k,), **options)
    return [trace for hand in hands for trace in hand]


def simulate_hand(
    material_name: str,
    seed: int,
    preheats_k: Sequence[float],
    *,
    touches: int = 1,
    seconds: float = 8.1,
    force_n: float = 1.2,
    ambient_c: float = 23.0,
    offset_c: tuple[float, float] = (-3.0, 3.0),
    thickness_m: float | None = BLOCK_M,
    contact_spread: float = TOUCH_SPREAD,
    block: bool = False,
    later: tuple[float, float] | None = None,
) -> list[list[ThermalTrace]]:
    """Touch a block with several fingers at once, `touches` times; return a list of hands with a trace a finger.

    Fingers of one hand share the piece and its temperature; each has its own sensor, contact and force.

    Args:
        material_name, seed: see `simulate_thermal`.
        preheats_k: each finger's start above ambient, K.
        touches, seconds, force_n, ambient_c, offset_c, thickness_m, contact_spread, block, later: see `TouchOptions`.

    Raises:
        ValueError: as `simulate_thermal`.
    """
    check_range("touches", touches, 1, 1000)
    check_range("fingers", len(preheats_k), 1, 5)
    check_range("seconds", seconds, 0.1, 120.0)
    check_range("force, N", force_n, 0.5, CONTACT_FORCE_N)
    check_range("seed", seed, 0, 2**53)
    check_range("ambient, C", ambient_c, 5.0, 35.0)
    for preheat_k in preheats_k:
        check_range("pre-heating, K", preheat_k, 0.0, 19.0)
    for offset_k in offset_c:
        check_range("object, C", round(ambient_c + offset_k, 6), -10.0, 60.0)
    name = known_material(material_name)
    fingers, count = len(preheats_k), touches * len(preheats_k)
    draw, reading, pressing = (np.random.default_rng([seed, crc32(name.encode()), part]) for part in range(3))
    sensors = SensorSpread.draw(count, draw)
    preheat_each_k = np.tile(np.asarray(preheats_k, dtype=np.float64), touches)
    target_c = np.minimum(ambient_c + preheat_each_k, SENSOR_PLATE_C)
    warm_s = REACH_S_K * preheat_each_k + draw.uniform(*WARM_S, count)
    sensor = _PreheatedSensor(ThermalTouch(sensors, ambient_c, reading), target_c, warm_s)
    touched: list[_Touched] = []
    if name == AIR:
        forces = np.zeros((round((LEAD_S + seconds) / STEP_S), count))
        contact_step = np.full(count, round(LEAD_S / STEP_S))
    else:
        surface = _SURFACE_OF.get(name, "plain_pvc")
        range_c = (ambient_c + offset_c[0], ambient_c + offset_c[1])
        touched = [
            one
            for _ in range(touches)
            for one in _Touched.draw(
                name,
                relief_of(surface),
                fingers,
                object_c=range_c,
                force_n=force_n,
                thickness_m=thickness_m,
                contact_spread=contact_spread,
                block=block,
                rng=draw,
            )
        ]
        forces = np.stack(
            [_press(one.force_n, surface_kind(surface).stiffness_n_m, seconds) for one in touched], axis=1
        )
        contact_step = np.argmax(forces >= CONTACT_N, axis=0)
        if later is not None:
            forces *= _later_share(len(forces), contact_step, *later)
    sensor_c, ambient_read_c = sensor.run(forces, contact_step, touched)
    measured = forces + FORCE_NOISE_N * pressing.standard_normal(forces.shape)
    time_s = STEP_S * np.arange(len(forces), dtype=np.float64)
    traces = [
        ThermalTrace(
            time_s,
            sensor_c[:, one],
            measured[:, one],
            ambient_read_c[:, one],
            touched[one].object_c if touched else None,
            float(time_s[contact_step[one]]),
            touched[one].full_w_m2k * float(force_share(forces[-1:, one])[0]) if touched else 0.0,
        )
        for one in range(count)
    ]
    return [traces[first : first + fingers] for first in range(0, count, fingers)]


def known_material(name: str) -> str:
    """Return the proper name of a material or alias, or `air`.

    Raises:
        ValueError: unknown material; the message lists the known ones.
    """
    try:
        return AIR if name == AIR else material(name).name
    except KeyError as error:
        raise ValueError(f"{error.args[0]}, {AIR}") from None


def check_range(what: str, value: float, low: float, high: float) -> None:
    """Raise ValueError unless low <= value <= high (NaN is refused too)."""
    if not low <= value <= high:
        raise ValueError(f"{what} must be {low:g}..{high:g}, not {value:g}")


class _PreheatedSensor:
    """Sensors that an ideal controller keeps at a target until contact, from `warm_s` before the trace starts."""

    def __init__(self, thermal: ThermalTouch, target_c: Array, warm_s: Array) -> None:
        self._thermal = thermal
        self._target_c = target_c
        idle = np.zeros(warm_s.size)
        longest_s = float(warm_s.max())
        for step in range(round(longest_s / STEP_S)):
            thermal.step(np.where(longest_s - step * STEP_S <= warm_s, self._heating(), 0.0), idle)

    def _heating(self) -> Array:
        return np.asarray(PREHEAT_PER_K * (self._target_c - self._thermal.plate_c))

    def run(self, forces: Array, contact_step: NDArray[np.intp], touched: list[_Touched]) -> tuple[Array, Array]:
        """Return readings of sensors and ambient sensors, C, for forces (steps, touches); heaters off from contact."""
        sensor_c, ambient_c = np.empty(forces.shape), np.empty(forces.shape)
        meets = np.argmax(forces > 0.0, axis=0).tolist() if touched else []
        for step, force in enumerate(forces):
            for one, at in enumerate(meets):
                if at == step:
                    self._thermal.touch(one, touched[one].column, touched[one].object_c, touched[one].full_w_m2k)
                    self._thermal.settle(one)
            self._thermal.step(np.where(step < contact_step, self._heating(), 0.0), force)
            sensor_c[step] = celsius_of(self._thermal.ssr_counts())
            ambient_c[step] = celsius_of(self._thermal.ambient_counts())
        return sensor_c, ambient_c


def _later_share(steps: int, contact_step: NDArray[np.intp], at_s: float, share: float) -> Array:
    """Return the factor on the force, (steps, touches), that changes from 1 to `share` at `at_s` after contact."""
    since_s = STEP_S * (np.arange(steps)[:, None] - contact_step) - at_s
    return np.asarray(1.0 + (share - 1.0) * np.clip(since_s / CHANGE_S, 0.0, 1.0))


def _press(force_n: float, stiffness_n_m: float, seconds: float) -> Array:
    """Return the true contact force every STEP_S while a finger is lowered to rest with `force_n`."""
    tip = Fingertip(HOVER_M)
    depth = pressing_depth_m(force_n, stiffness_n_m)
    start = LEAD_S - LOWER_AHEAD_S
    ticks = round(STEP_S / TICK_S)
    forces = np.empty(round((LEAD_S + seconds) / STEP_S))
    for step in range(forces.size):
        forces[step] = tip.force_n
        if step * STEP_S > start + LOWER_S and abs(tip.velocity_m_s) < 1e-9:
            continue  # at rest: the force stays constant
        for tick in range(ticks):
            u = min(max((step * STEP_S + tick * TICK_S - start) / LOWER_S, 0.0), 1.0)
            down = u**3 * (10.0 - 15.0 * u + 6.0 * u * u)  # minimum jerk
            tip.step(TICK_S, HOVER_M - down * (HOVER_M + depth), 0.0, stiffness_n_m)
    return forces
