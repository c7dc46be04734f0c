"""Touches of both worlds: that of the shipped simulator, A, and the second one, B, which has another structure.

World A draws the sensor of each finger by itself, and a kind is a seed. In world B, the fingers of a hand are units of
one kind.
"""

from collections.abc import Sequence
from typing import Literal

from sim_sensors.traces.simulated_touch import BLOCK_M
from studies.second_world.touches import USUAL, Kind, Objects, simulate_touches
from studies.thermal_identification.situations import PREHEAT_K, STAGGERED_K, Hand, Situation, touched

World = Literal["A", "B"]


UNITS = 5
"""Number of units of a kind, and of fingers of a hand."""
FINGERS = {"1 finger": 1, "2 staggered": 2, "5 staggered": 5}
"""Number of fingers of each judged method."""
LIFTED_S = 0.4
"""Time in contact beyond the last answer, s. The answers count from a force of 0.3 N."""
CHUNK = 5
"""Number of judged touches of a piece of work."""
_LEARNING, _JUDGED, _CALIBRATION = 20, 2, 10
_PER_KIND, _FIRST_A = 1000, 10**9
"""Number of seeds of a kind, and the first one of world A; other studies use smaller ones."""


def calibration_hands(
    world: World,
    kind: int,
    name: str,
    touches: int,
    seconds: float,
    objects: Objects = USUAL,
    preheat_k: float = PREHEAT_K,
    first: int = 0,
) -> list[Hand]:
    """Return touches of one finger, `seconds` each, from number `first` on; each unit makes a fifth of them."""
    if world == "A":
        return _touched_a(name, _seed_a(kind, _CALIBRATION), first + touches, (preheat_k,), seconds, objects)[first:]
    drawn, numbers = Kind.draw(kind), range(first // UNITS, (first + touches) // UNITS)
    return [
        hand
        for seed, unit in enumerate(drawn.units, start=_seed_b(kind, _CALIBRATION))
        for hand in simulate_touches(Kind(drawn.sensor, (unit,)), name, seed, numbers, (preheat_k,), seconds, objects)
    ]


def learning_hands(world: World, kind: int, name: str, turn: int, touches: int, seconds: float) -> list[Hand]:
    """Return touches of five fingers; units change their places with `turn`, 0..4, so that each is each finger."""
    if world == "A":
        return _touched_a(name, _seed_a(kind, _LEARNING + turn), touches, STAGGERED_K, seconds)
    drawn = Kind.draw(kind)
    turned = Kind(drawn.sensor, drawn.units[turn:] + drawn.units[:turn])
    seed = _seed_b(kind, _LEARNING + turn)
    return list(simulate_touches(turned, name, seed, range(touches), STAGGERED_K, seconds))


def judged_hands(
    world: World, kind: int, name: str, numbers: Sequence[int], seconds: float, objects: Objects = USUAL
) -> list[Hand]:
    """Return touches of five fingers, which neither calibrated nor taught anything; each has a number."""
    if world == "A":
        seed = _seed_a(kind, 100 * _JUDGED + numbers[0])
        return _touched_a(name, seed, len(numbers), STAGGERED_K, seconds, objects)
    seed = _seed_b(kind, _JUDGED)
    return list(simulate_touches(Kind.draw(kind), name, seed, numbers, STAGGERED_K, seconds, objects))


def _touched_a(
    name: str, seed: int, touches: int, preheats_k: tuple[float, ...], seconds: float, objects: Objects = USUAL
) -> list[Hand]:
    thickness_m = objects.thickness_m or BLOCK_M
    return touched(Situation(name, seed, touches, preheats_k, objects.above_k, thickness_m, seconds=seconds))


def _seed_a(kind: int, part: int) -> int:
    return _FIRST_A + _seed_b(kind, part)


def _seed_b(kind: int, part: int) -> int:
    """Return a seed that each kind has for itself: no two kinds touch the same pieces."""
    return _PER_KIND * kind + part
