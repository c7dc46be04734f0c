"""Grooves and edges: the places where the tip's path is hollow beyond what the surface's own roughness makes it.

A groove is a hollow; so is one side of an edge, whichever way it goes, and the foot of a ridge. Roughness is a
hollow too, as often as a bump: what stands out is judged by a rank of the curvature round about, which a grating
that fills half of the way cannot lift much, and which follows the surface within millimetres. So nothing is held,
and nothing can latch.
"""

import math
from bisect import bisect_left, insort
from collections import deque
from typing import NamedTuple

from remote_site.texture.tip_path import CELL_M, Curve

STANDS_OUT = 7.0
"""A hollow this many times the rms of the curvature round about is no roughness."""
WINDOWS_M = (8e-3, 2e-3)
LEAST_M = 1.5e-3
"""Ways that say how rough it is round about, and the least that says anything, m. The longer says it better, the
shorter sooner where it becomes rougher: the rougher holds."""
RANK = 1.0 / 3.0
RMS_OF_RANK = 1.0 / 0.4307
"""This part of the magnitudes of a normal curvature lies below 0.43 of its rms."""
APART_M = 0.5e-3
"""Nearer to each other than this no two grooves are told apart, m: an edge's two sides, a ridge's two feet are one."""
SUNK = 0.5
"""An impulse is over when the hollow has become this part of its deepest."""


class Impulse(NamedTuple):
    """A groove or an edge: when, s, and where along the way, m; its curvature for one newton, V."""

    time_s: float
    place_m: float
    strength_v: float


class _Rank:
    """The magnitude below which RANK of those of the last so many cells lie."""

    __slots__ = ("_cells", "_ranked", "_recent")

    def __init__(self, cells: int) -> None:
        self._cells = cells
        self._recent: deque[float] = deque()
        self._ranked: list[float] = []

    def __len__(self) -> int:
        return len(self._ranked)

    def add(self, magnitude_v: float) -> None:
        """Take another cell's; forget the oldest."""
        self._recent.append(magnitude_v)
        insort(self._ranked, magnitude_v)
        if len(self._recent) > self._cells:
            del self._ranked[bisect_left(self._ranked, self._recent.popleft())]

    @property
    def value_v(self) -> float:
        """The magnitude at RANK; there must be one."""
        return self._ranked[int(RANK * len(self._ranked))]


class GrooveDetector:
    """Finds impulses in the curvature for one newton, cell by cell."""

    __slots__ = ("_before_v", "_deepest", "_last_m", "_least_v", "_ranks", "_sides_v")

    def __init__(self, least_v: float) -> None:
        """Take the curvature for one newton below which nothing counts as a groove, V."""
        self._least_v = least_v
        self.forget()

    def forget(self) -> None:
        """Another surface: what was round about says nothing about it."""
        self._ranks = tuple(_Rank(round(window_m / CELL_M)) for window_m in WINDOWS_M)
        self.interrupt()

    def interrupt(self) -> None:
        """The way is interrupted."""
        self._deepest: Impulse | None = None
        self._last_m = -math.inf
        self._before_v = 0.0
        self._sides_v: list[float] = []

    @property
    def known(self) -> bool:
        """Whether enough was felt to say what stands out."""
        return len(self._ranks[0]) * CELL_M >= LEAST_M

    @property
    def threshold_v(self) -> float:
        """Hollow that stands out, V for one newton; infinite before anything is known of the surface."""
        if not self.known:
            return math.inf
        return max(STANDS_OUT * RMS_OF_RANK * max(rank.value_v for rank in self._ranks), self._least_v)

    def step(self, curve: Curve, curvature_v: float) -> Impulse | None:
        """Take the next cell, its curvature given for one newton; return the impulse that has just ended."""
        found: Impulse | None = None
        hollow_v, deepest = -curvature_v, self._deepest
        if deepest is None:
            # The threshold is never below `_least_v`, and takes longer to find.
            if hollow_v > self._least_v and hollow_v > self.threshold_v and curve.place_m - self._last_m > APART_M:
                self._deepen(curve, hollow_v)
        elif hollow_v > deepest.strength_v:
            self._deepen(curve, hollow_v)
        else:
            if len(self._sides_v) == 1:
                self._sides_v.append(hollow_v)
            if hollow_v < SUNK * deepest.strength_v or curve.place_m - deepest.place_m >= APART_M:
                found = _between_cells(deepest, *self._sides_v)
                self._deepest = None
                self._last_m = found.place_m
        self._before_v = hollow_v
        for rank in self._ranks:
            rank.add(abs(curvature_v))
        return found

    def _deepen(self, curve: Curve, hollow_v: float) -> None:
        self._deepest = Impulse(curve.time_s, curve.place_m, hollow_v)
        self._sides_v = [self._before_v]


def _between_cells(deepest: Impulse, before_v: float, after_v: float) -> Impulse:
    """The top of the parabola through the deepest cell and those beside it; its time stays the cell's."""
    bend_v = before_v - 2.0 * deepest.strength_v + after_v
    cells = 0.5 * (before_v - after_v) / bend_v if bend_v < 0.0 else 0.0
    return deepest._replace(place_m=deepest.place_m + CELL_M * min(max(cells, -0.5), 0.5))
