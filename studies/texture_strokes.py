"""Strokes that the study of texture feels: at random speed and force over the paper's six surfaces, or over two."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from common.messages import ExplorationMode
from remote_site.felt_stroke import EvenStroke, FeltBlock, felt
from remote_site.surface_class import SurfaceTable
from sim_sensors.simulated_stroke import StrokeTrace, simulate_stroke
from teletaction.make_tables import STROKED

SPEED_MM_S, FORCE_N = (20.0, 150.0), (0.56, 4.5)
"""Ranges from which speed and force are drawn; the hand adds a tenth to either side of the force."""
LONGEST_M = 0.32
BEFORE_GROOVES_M = 2e-3
"""The way that the identification needs before it says anything of grooves."""


class Drawn(NamedTuple):
    """A stroke with what is true of it."""

    surface: str
    then: str | None
    speed_mm_s: float
    force_n: float
    trace: StrokeTrace

    @property
    def even(self) -> EvenStroke:
        """As the identification takes it."""
        trace = self.trace
        return EvenStroke(trace.time_s, trace.pressure_v, trace.force_n, 1e-3 * trace.speed_mm_s)


class Asked(NamedTuple):
    """A stroke that can be simulated anywhere: over one surface, or from it to another."""

    surface: str
    then: str | None
    seed: int
    speed_mm_s: float
    force_n: float
    length_m: float

    def drawn(self) -> Drawn:
        """Simulate it."""
        trace = simulate_stroke(
            self.surface, self.seed, self.speed_mm_s, self.force_n, length_m=self.length_m, then=self.then
        )
        return Drawn(self.surface, self.then, self.speed_mm_s, self.force_n, trace)


def strokes(each: int, seconds: float, seed: int) -> Iterator[Asked]:
    """So many strokes over each surface, of so many seconds."""
    chance = np.random.default_rng([seed, 1])
    for number in range(each):
        for surface in STROKED:
            speed_mm_s, force_n = float(chance.uniform(*SPEED_MM_S)), float(chance.uniform(*FORCE_N))
            length_m = min(1e-3 * speed_mm_s * (seconds + 0.2), LONGEST_M)
            yield Asked(surface, None, (seed << 20) + number, speed_mm_s, force_n, length_m)


def changes(count: int, seed: int) -> Iterator[Asked]:
    """So many strokes that come from one surface to another, 70 mm on each."""
    chance = np.random.default_rng([seed, 2])
    for number in range(count):
        before, after = (STROKED[k] for k in chance.choice(len(STROKED), 2, replace=False))
        speed_mm_s, force_n = float(chance.uniform(*SPEED_MM_S)), float(chance.uniform(*FORCE_N))
        yield Asked(before, after, (seed << 20) + 500_000 + number, speed_mm_s, force_n, 0.14)


def stroking(blocks: list[FeltBlock]) -> list[FeltBlock]:
    """The blocks that stroke."""
    return [block for block in blocks if block.mode is ExplorationMode.STROKING]


def felt_blocks(drawn: Drawn, table: SurfaceTable) -> list[FeltBlock]:
    """What the shipped method feels."""
    return list(felt(drawn.even, table))


def grooves_counted(drawn: Drawn, begin_s: float, found_s: list[float]) -> tuple[int, int, int]:
    """Grooves crossed, missed, and impulses invented, to half a millimetre, from shortly after the stroke's begin."""
    speed_mm_s, end_s = drawn.speed_mm_s, drawn.trace.stroke_s[1] - 0.01
    begin_s += 0.08 + 1e3 * BEFORE_GROOVES_M / speed_mm_s
    true, told = np.array(drawn.trace.groove_s), np.array(found_s)
    near_s = 0.5 / speed_mm_s

    def alone(some: np.ndarray, others: np.ndarray) -> int:
        meant = some[(some > begin_s) & (some < end_s)]
        return sum(1 for time_s in meant if not len(others) or np.abs(others - time_s).min() > near_s)

    crossed = int(((true > begin_s) & (true < end_s)).sum())
    return crossed, alone(true, told), alone(told, true)
