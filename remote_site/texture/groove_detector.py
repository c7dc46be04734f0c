"""Detects grooves and edges, where the tip's path is more hollow than the surface's own roughness makes it.

A groove is a hollow. One side of an edge, in either direction, and the foot of a ridge are hollows, too. Roughness
makes hollows as often as bumps. The threshold therefore follows from a rank of the surrounding curvature. A grating
that fills half of the path raises this rank only little, and the rank follows the surface within millimetres. The
detector holds no value, so that it cannot latch.
"""

import math
from bisect import bisect_left, insort
from collections import deque
from typing import NamedTuple

from remote_site.texture.tip_path import CELL_M, Curve

STANDS_OUT = 7.0
"""Hollow, over the rms of the surrounding curvature, above which it is not roughness."""
WINDOWS_M = (8e-3, 2e-3)
"""Lengths of path over which roughness is ranked, m; the rougher result counts.

The longer window is more precise. The shorter one responds sooner when the surface becomes rougher.
"""
LEAST_M = 1.5e-3
"""Minimum length of path before the roughness is known, m."""
RANK = 1.0 / 3.0
"""Fraction of the curvature's magnitudes that lie below the ranked value."""
RMS_OF_RANK = 1.0 / 0.4307
"""Rms of a normal curvature over the magnitude at RANK."""
APART_M = 0.5e-3
"""Smallest spacing at which two grooves are resolved, m; the sides of an edge or feet of a ridge count as one."""
SUNK = 0.5
"""Fraction of its deepest hollow below which an impulse ends."""


class Impulse(NamedTuple):
    """A groove or an edge: time, s; place along the path, m; curvature for one newton, V."""

    time_s: float
    place_m: float
    strength_v: float


class _Rank:
    """Magnitude below which the fraction RANK of the recent cells lies."""

    def __init__(self, cells: int) -> None:
        self._cells = cells
        self._recent: deque[float] = deque()
        self._ranked: list[float] = []

    def __len__(self) -> int:
        return len(self._ranked)

    def add(self, magnitude_v: float) -> None:
        """Take the magnitude of another cell and drop the oldest."""
        self._recent.append(magnitude_v)
        insort(self._ranked, magnitude_v)
        if len(self._recent) > self._cells:
            del self._ranked[bisect_left(self._ranked, self._recent.popleft())]

    @property
    def value_v(self) -> float:
        """Magnitude at RANK; needs at least one cell."""
        return self._ranked[int(RANK * len(self._ranked))]


class GrooveDetector:
    """Finds impulses in the curvature for one newton, cell by cell."""

    def __init__(self, least_v: float) -> None:
        """Begin; `least_v` is the minimum curvature of a groove for one newton, V."""
        self._least_v = least_v
        self.forget()

    def forget(self) -> None:
        """Forget the roughness, since another surface begins."""
        self._ranks = tuple(_Rank(round(window_m / CELL_M)) for window_m in WINDOWS_M)
        self.interrupt()

    def interrupt(self) -> None:
        """Interrupt the path."""
        self._deepest: Impulse | None = None
        self._last_m = -math.inf
        self._before_v = 0.0
        self._sides_v: list[float] = []

    @property
    def known(self) -> bool:
        """Whether the path is long enough for a threshold."""
        return len(self._ranks[0]) * CELL_M >= LEAST_M

    @property
    def threshold_v(self) -> float:
        """Minimum hollow of a groove for one newton, V; infinite while the surface is unknown."""
        if not self.known:
            return math.inf
        return max(STANDS_OUT * RMS_OF_RANK * max(rank.value_v for rank in self._ranks), self._least_v)

    def step(self, curve: Curve, curvature_v: float) -> Impulse | None:
        """Take the next cell with its curvature for one newton, V; return the impulse that has just ended."""
        found: Impulse | None = None
        hollow_v, deepest = -curvature_v, self._deepest
        if deepest is None:
            # The threshold is never below `_least_v` and takes longer to compute.
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
    """Move the place to the top of the parabola through the deepest cell and its neighbours; the time stays."""
    bend_v = before_v - 2.0 * deepest.strength_v + after_v
    cells = 0.5 * (before_v - after_v) / bend_v if bend_v < 0.0 else 0.0
    return deepest._replace(place_m=deepest.place_m + CELL_M * min(max(cells, -0.5), 0.5))
