"""A simulated hand that lands where it is told to, and what the remote site makes of it: no devices, no network."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from common.fingers import FINGERS
from common.scene import load_scene
from remote_site.finger_touch import FingerTouch
from remote_site.sensed import Sensed
from remote_site.thermal_sensor import PlateReading
from sim_sensors.remote_world import RemoteWorld
from sim_sensors.ssr_converter import celsius_of
from tests.remote_site.shipped_tables import perception

TICK_S = 0.002
READ_EVERY = 5
LOWER_S = 0.04
UP_M, DOWN_M = 0.006, -0.004
IN_M = 0.02
"""How far from an object's edge the hand lands, m."""
WARM_UP_S = 5.0


@dataclass(frozen=True)
class Landing:
    """Down for `down_s`, then up for `up_s`; `beside_m` from where the hand began."""

    down_s: float
    up_s: float = 0.0
    beside_m: float = 0.0


@dataclass(frozen=True)
class Felt:
    """All fingers at one moment; `landing` counts from 0."""

    time_s: float
    landing: int
    touches: dict[int, FingerTouch]


def land(name: str, landings: Iterable[Landing], seed: int = 0, fingers: tuple[str, ...] = FINGERS) -> list[Felt]:
    """Land on the object `name` of scene `materials` again and again, with plates that were warm at first."""
    world = RemoteWorld(load_scene("materials"), seed, fingers)
    identified = perception(fingers, "materials_blocks")
    used = [FINGERS.index(finger) for finger in fingers]
    low_x_m = next(thing.low_x_m for thing in world.bench.objects if thing.name == name)
    drive = np.zeros(len(FINGERS))
    felt: list[Felt] = []

    def pass_time(seconds: float, x_m: float, from_m: float, to_m: float, landing: int) -> None:
        ticks = round(seconds / TICK_S)
        for tick in range(ticks):
            moved = min((tick + 1) * TICK_S / LOWER_S, 1.0)
            eased = moved**3 * (10.0 - 15.0 * moved + 6.0 * moved * moved)
            world.step(TICK_S, x_m, 0.0, np.full(len(FINGERS), from_m + eased * (to_m - from_m)), drive)
            happened = identified.step(_sensed(world, drive, used, len(felt) % READ_EVERY == 0))
            assert all(event.time_ns == round(world.time_s * 1e9) for event in happened)
            for finger in used:
                drive[finger] = identified.touches[finger].heater_drive
            identified.work()
            felt.append(Felt(world.time_s, landing, {finger: identified.touches[finger] for finger in used}))

    pass_time(WARM_UP_S, low_x_m + IN_M, UP_M, UP_M, -1)
    for number, landing in enumerate(landings):
        x_m = low_x_m + IN_M + landing.beside_m
        pass_time(landing.down_s + LOWER_S, x_m, UP_M, DOWN_M, number)
        pass_time(landing.up_s + LOWER_S, x_m, DOWN_M, UP_M, number)
    return felt


def _sensed(world: RemoteWorld, drive: np.ndarray, used: list[int], reads: bool) -> Sensed:
    plates: list[PlateReading | None] = [None] * len(FINGERS)
    if reads:
        sensor_c, ambient_c = celsius_of(world.ssr_counts()), celsius_of(world.ambient_counts())
        for finger in used:
            plates[finger] = PlateReading(
                float(sensor_c[finger]),
                float(ambient_c[finger]),
                "",
                round(world.time_s * 1e6),
                round(1000 * drive[finger]),
            )
    return Sensed(
        world.time_s,
        world.x_m,
        world.y_m,
        tuple(world.z_m.tolist()),
        tuple(world.measured_force_n.tolist()),
        (None,) * len(FINGERS),
        tuple(plates),
    )


def named(felt: list[Felt], landing: int | None = None) -> set[str]:
    """All materials that were named in a landing, or ever."""
    return {
        touch.thermal.material
        for moment in felt
        if landing is None or moment.landing == landing
        for touch in moment.touches.values()
        if touch.thermal.material is not None
    }
