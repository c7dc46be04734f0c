"""Simulated strokes, played to the identification of one finger."""

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from common.exploration.exploration_mode import ModeDetector
from common.exploration.hand_motion import HandMotion
from common.wire.messages import ExplorationMode
from remote_site.texture.recorded.stroke_playback import EvenStroke, StrokeBlock, felt
from sim_sensors.traces.simulated_stroke import StrokeTrace, simulate_stroke
from studies.texture.strokes import Asked, Drawn, Grooves, grooves_counted, stroking
from tests.unit.remote_site.shipped_tables import SURFACES

Array = NDArray[np.float64]
SIX = tuple(surface.name for surface in SURFACES.surfaces)
SPEEDS_MM_S, FORCES_N = (20.0, 150.0), (0.56, 4.5)
"""The range in which a stroke may be, with the spread that the simulated hand adds to its force."""


def even(trace: StrokeTrace, speed_factor: float = 1.0) -> EvenStroke:
    """A simulated stroke, its speed known wrongly by a factor."""
    return EvenStroke(trace.time_s, trace.pressure_v, trace.force_n, 1e-3 * speed_factor * trace.speed_mm_s)


def played(trace: StrokeTrace) -> list[StrokeBlock]:
    """All blocks of a stroke."""
    return list(felt(even(trace), SURFACES))


def to_and_fro(surface: str, length_m: float, times: int) -> tuple[StrokeTrace, Array]:
    """A stroke at 50 mm/s that turns `times` times on a short way, and the direction of each sample, 1 or -1."""
    speed_mm_s = 50.0
    made = simulate_stroke(surface, 7, speed_mm_s, 1.0, length_m=0.06)
    first = int(np.searchsorted(made.time_s, made.stroke_s[0] + 0.3))
    way = np.arange(first, first + round(2000.0 * length_m / (1e-3 * speed_mm_s)))
    ways = np.concatenate([np.arange(first), *[way[::turn] for turn in [1, -1] * (times // 2)]])
    direction = np.concatenate([np.ones(first), *[np.full(len(way), float(turn)) for turn in [1, -1] * (times // 2)]])
    time_s = np.arange(1, 1 + len(ways)) / 2000.0
    trace = replace(
        made,
        time_s=time_s,
        pressure_v=made.pressure_v[ways],
        force_n=made.force_n[ways],
        speed_mm_s=made.speed_mm_s[ways],
    )
    return trace, direction


def drawn(surface: str, seed: int) -> StrokeTrace:
    """A stroke of random speed and force over a surface, with a duration of which each second is a stroke."""
    chance = np.random.default_rng([seed, 11])
    speed_mm_s, force_n = chance.uniform(*SPEEDS_MM_S), chance.uniform(*FORCES_N)
    length_m = float(np.clip(1e-3 * speed_mm_s * 1.3, 0.02, 0.3))
    return simulate_stroke(surface, seed, float(speed_mm_s), float(force_n), length_m=length_m)


def counted(trace: StrokeTrace, blocks: list[StrokeBlock]) -> Grooves:
    """Compare impulses with the grooves that were crossed."""
    speed_mm_s = float(np.median(trace.speed_mm_s[trace.speed_mm_s > 5.0]))
    asked = Asked("", None, 0, speed_mm_s, math.nan)
    found_s = [impulse.time_s for block in blocks for impulse in block.texture.impulses]
    return grooves_counted(Drawn(asked, trace), stroking(blocks)[0].begin_s, found_s)


def modes_of(trace: StrokeTrace) -> list[ExplorationMode]:
    """Mode at each sample, as a machine that is stepped with each of them has it."""
    hand = HandMotion()
    exploration, modes = ModeDetector(hand), []
    x_m = np.cumsum(1e-3 * trace.speed_mm_s) / 2000.0
    for t_s, force_n, at_m in zip(trace.time_s.tolist(), trace.force_n.tolist(), x_m.tolist(), strict=True):
        hand.step(t_s, at_m, 0.0)
        modes.append(exploration.step(t_s, force_n, 0.0))
    return modes


def held_values(thing: object, seen: set[int] | None = None) -> int:
    """Number of values in all that an object holds."""
    seen = set() if seen is None else seen
    if id(thing) in seen or isinstance(thing, type):
        return 0
    seen.add(id(thing))
    if isinstance(thing, np.ndarray):
        return thing.size
    if isinstance(thing, dict):
        return sum(held_values(value, seen) for value in thing.values())
    if hasattr(thing, "__iter__") and not isinstance(thing, str):
        return sum(1 + held_values(value, seen) for value in thing)
    names = [name for kind in type(thing).__mro__ for name in getattr(kind, "__slots__", ())]
    return sum(held_values(getattr(thing, name), seen) for name in [*names, *getattr(thing, "__dict__", {})])
