"""A simulated hand that lands on an object repeatedly, and its identification."""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from common.fingers import FINGERS
from common.scenes.scene import load_scene
from remote_site.thermal.thermal_result import ThermalResult
from teletaction.testbed.remote_fingers import RemoteFingers
from teletaction.testbed.rendered_fingers import TICK_S

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
class Touched:
    """Whether one finger is in contact, and the answer for its object."""

    contact: bool
    thermal: ThermalResult


@dataclass(frozen=True)
class Moment:
    """All fingers at one moment; `landing` counts from 0, and `drive` is of the heaters (5,), -1..1."""

    time_s: float
    landing: int
    touches: dict[int, Touched]
    drive: tuple[float, ...]


def land(name: str, landings: Iterable[Landing], seed: int = 0, fingers: tuple[str, ...] = FINGERS) -> list[Moment]:
    """Land on the object `name` of scene `materials` again and again, with plates that were warm at first."""
    hand = RemoteFingers(load_scene("materials"), seed, fingers)
    low_x_m = next(thing.low_x_m for thing in hand.world.bench.objects if thing.name == name)
    moments: list[Moment] = []

    def pass_time(seconds: float, x_m: float, from_m: float, to_m: float, landing: int) -> None:
        for tick in range(round(seconds / TICK_S)):
            moved = min((tick + 1) * TICK_S / LOWER_S, 1.0)
            eased = moved**3 * (10.0 - 15.0 * moved + 6.0 * moved * moved)
            hand.move(x_m, 0.0, np.full(len(FINGERS), from_m + eased * (to_m - from_m)))
            touches = {number: Touched(touch.contact, touch.thermal.answer) for number, touch in hand.touches.items()}
            moments.append(Moment(hand.world.time_s, landing, touches, tuple(hand.drive.tolist())))

    pass_time(WARM_UP_S, low_x_m + IN_M, UP_M, UP_M, -1)
    for number, landing in enumerate(landings):
        x_m = low_x_m + IN_M + landing.beside_m
        pass_time(landing.down_s + LOWER_S, x_m, UP_M, DOWN_M, number)
        pass_time(landing.up_s + LOWER_S, x_m, DOWN_M, UP_M, number)
    return moments


def named(moments: list[Moment], landing: int | None = None) -> set[str]:
    """All materials that were named in a landing, or ever."""
    return {
        touch.thermal.material
        for moment in moments
        if landing is None or moment.landing == landing
        for touch in moment.touches.values()
        if touch.thermal.material is not None
    }
