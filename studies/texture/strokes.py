"""Draws the strokes of the texture study, at random speed and force, over one or two of the paper's six surfaces."""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from common.wire.messages import ExplorationMode
from remote_site.texture.recorded.stroke_playback import EvenStroke, StrokeBlock, felt
from remote_site.texture.surface_table import SurfaceTable
from sim_sensors.traces.simulated_stroke import LENGTH_M, StrokeTrace, simulate_stroke
from teletaction.make_tables import STROKED

SPEED_MM_S, FORCE_N = (20.0, 150.0), (0.56, 4.5)
"""Ranges of the drawn speed, mm/s, and force, N; the hand varies the force by a tenth to either side."""
LONGEST_M = 0.32
BEFORE_GROOVES_M = 2e-3
"""Distance that the identification needs before it detects grooves, m."""


class Asked(NamedTuple):
    """Parameters of a stroke over one surface, or from one surface to another; any process can simulate it."""

    surface: str
    then: str | None
    seed: int
    speed_mm_s: float
    force_n: float
    length_m: float = LENGTH_M

    def drawn(self, **how: float) -> "Drawn":
        """Simulate the stroke; `how` are further arguments of `simulate_stroke`."""
        surface, then, seed, speed_mm_s, force_n, length_m = self
        return Drawn(self, simulate_stroke(surface, seed, speed_mm_s, force_n, length_m=length_m, then=then, **how))


class Drawn(NamedTuple):
    """Simulated stroke with its true parameters."""

    asked: Asked
    trace: StrokeTrace

    @property
    def even(self) -> EvenStroke:
        """The stroke in the form that the identification takes."""
        trace = self.trace
        return EvenStroke(trace.time_s, trace.pressure_v, trace.force_n, 1e-3 * trace.speed_mm_s)


class Grooves(NamedTuple):
    """Numbers of crossed grooves, of missed ones among them, and of impulses without a groove."""

    crossed: int
    missed: int
    invented: int


def strokes(each: int, seconds: float, seed: int) -> Iterator[Asked]:
    """Yield `each` strokes over each surface, for `seconds` each."""
    chance = np.random.default_rng([seed, 1])
    for number in range(each):
        for surface in STROKED:
            speed_mm_s, force_n = float(chance.uniform(*SPEED_MM_S)), float(chance.uniform(*FORCE_N))
            length_m = min(1e-3 * speed_mm_s * (seconds + 0.2), LONGEST_M)
            yield Asked(surface, None, (seed << 20) + number, speed_mm_s, force_n, length_m)


def changes(count: int, seed: int) -> Iterator[Asked]:
    """Yield `count` strokes from one surface to another, 70 mm on each."""
    chance = np.random.default_rng([seed, 2])
    for number in range(count):
        before, after = (STROKED[k] for k in chance.choice(len(STROKED), 2, replace=False))
        speed_mm_s, force_n = float(chance.uniform(*SPEED_MM_S)), float(chance.uniform(*FORCE_N))
        yield Asked(before, after, (seed << 20) + 500_000 + number, speed_mm_s, force_n, 0.14)


def stroking(blocks: list[StrokeBlock]) -> list[StrokeBlock]:
    """Return the blocks in stroking mode."""
    return [block for block in blocks if block.mode is ExplorationMode.STROKING]


def stroke_blocks(drawn: Drawn, table: SurfaceTable) -> list[StrokeBlock]:
    """Return the blocks that the shipped method identifies."""
    return list(felt(drawn.even, table))


def grooves_counted(drawn: Drawn, begin_s: float, found_s: list[float]) -> Grooves:
    """Count crossed and missed grooves and false impulses, matched to 0.5 mm, from shortly after the stroke's start."""
    speed_mm_s, end_s = drawn.asked.speed_mm_s, drawn.trace.stroke_s[1] - 0.01
    begin_s += 0.08 + 1e3 * BEFORE_GROOVES_M / speed_mm_s
    true, found = np.array(drawn.trace.groove_s), np.array(found_s)
    near_s = 0.5 / speed_mm_s

    def alone(some: np.ndarray, others: np.ndarray) -> int:
        meant = some[(some > begin_s) & (some < end_s)]
        return sum(1 for time_s in meant if not len(others) or np.abs(others - time_s).min() > near_s)

    crossed = int(((true > begin_s) & (true < end_s)).sum())
    return Grooves(crossed, alone(true, found), alone(found, true))
