"""Simulated strokes as the identification of one finger feels them."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from common.exploration import Exploration
from common.hand_motion import HandMotion
from common.messages import ExplorationMode
from remote_site.felt_stroke import EvenStroke, FeltBlock, felt
from remote_site.surface_class import SurfaceTable
from sim_sensors.simulated_stroke import StrokeTrace, simulate_stroke

SHIPPED = SurfaceTable.load(Path(__file__).parents[2] / "remote_site" / "tables" / "surfaces.json")
SIX = tuple(surface.name for surface in SHIPPED.surfaces)
SPEEDS_MM_S, FORCES_N = (20.0, 150.0), (0.56, 4.5)
"""The range in which a stroke may be, with the spread that the simulated hand adds to its force."""


def even(trace: StrokeTrace, speed_factor: float = 1.0) -> EvenStroke:
    """A simulated stroke, its speed known wrongly by a factor."""
    return EvenStroke(trace.time_s, trace.pressure_v, trace.force_n, 1e-3 * speed_factor * trace.speed_mm_s)


def played(trace: StrokeTrace, table: SurfaceTable = SHIPPED) -> list[FeltBlock]:
    """All blocks of a stroke."""
    return list(felt(even(trace), table))


def drawn(surface: str, seed: int, *, seconds: float = 1.3, **how: object) -> StrokeTrace:
    """A stroke of random speed and force over a surface, so long that a second of it is a stroke."""
    chance = np.random.default_rng([seed, 11])
    speed_mm_s, force_n = chance.uniform(*SPEEDS_MM_S), chance.uniform(*FORCES_N)
    length_m = float(np.clip(1e-3 * speed_mm_s * seconds, 0.02, 0.3))
    return simulate_stroke(surface, seed, float(speed_mm_s), float(force_n), length_m=length_m, **how)  # type: ignore[arg-type]


@dataclass(frozen=True)
class Counted:
    """Grooves crossed while stroking, and of them missed; impulses that no groove gave."""

    crossed: int
    missed: int
    invented: int


def counted(trace: StrokeTrace, blocks: list[FeltBlock]) -> Counted:
    """Compare impulses with what was crossed: from 2 mm within the stroke to its end, to half a millimetre."""
    speed_mm_s = float(np.median(trace.speed_mm_s[trace.speed_mm_s > 5.0]))
    begin_s = 0.08 + 2.0 / speed_mm_s + next(b.begin_s for b in blocks if b.mode is ExplorationMode.STROKING)
    near_s = 0.5 / speed_mm_s
    found = np.array([i.time_s for block in blocks for i in block.texture.impulses])
    true = np.array(trace.groove_s)
    meant = [times[(times > begin_s) & (times < trace.stroke_s[1] - 0.01)] for times in (true, found)]
    return Counted(len(meant[0]), _without(meant[0], found, near_s), _without(meant[1], true, near_s))


def _without(some: NDArray[np.float64], others: NDArray[np.float64], near_s: float) -> int:
    return sum(1 for time_s in some if not len(others) or np.abs(others - time_s).min() > near_s)


def modes_of(trace: StrokeTrace) -> list[ExplorationMode]:
    """Mode at each sample, as a machine that is stepped with each of them has it."""
    hand = HandMotion()
    exploration = Exploration(hand)
    x_m = np.cumsum(1e-3 * trace.speed_mm_s) / 2000.0
    rows = zip(trace.time_s, trace.force_n, x_m, 1e-3 * trace.speed_mm_s, strict=True)
    modes = []
    for t, f, x, _ in rows:
        hand.step(float(t), float(x), 0.0)
        modes.append(exploration.step(float(t), float(f), 0.0))
    return modes
