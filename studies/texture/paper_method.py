"""The paper's texture identification as a baseline (Kron & Schmidt 2003, section 4.1, Eq. 5-6 with the pattern hold).

    |p|            the rectified signal, mean over 5 ms
    mean           of |p| since the stroke began; while a pattern lasts it is held, and so is the number of values
    pattern        begins where |p| is much greater than the mean and ends where it is close to it again

The paper gives no numbers for "much greater" and "close to". Hard intervals of the mean distinguish the surfaces.
Patterned surfaces are distinguished by the distance between the beginnings of patterns.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from common.wire.messages import ExplorationMode
from remote_site.texture.recorded.stroke_playback import EvenStroke

Array = NDArray[np.float64]

CHUNK = 10
MUCH_GREATER, CLOSE_TO = 3.0, 1.5
BEFORE_PATTERNS = 10
"""Number of 5 ms values in the mean before any pattern can begin."""
PATTERNED = 3
"""Least number of patterns in a stroke over a patterned surface."""


class PaperRoughness:
    """Mean and patterns of one stroke.

    Attributes:
        mean_v: mean of the rectified signal without patterns, V.
        pattern: whether the mean is held.
        began: whether a pattern began with the last step.
    """

    def __init__(self) -> None:
        self.mean_v = 0.0
        self.pattern = self.began = False
        self._count = 0

    def step(self, chunk_v: Array) -> None:
        """Take the next 5 ms of the stroke, V."""
        rectified_v = float(np.abs(chunk_v).mean())
        was = self.pattern
        if self._count >= BEFORE_PATTERNS:
            limit = CLOSE_TO if was else MUCH_GREATER
            self.pattern = rectified_v > limit * self.mean_v
        self.began = self.pattern and not was
        if not self.pattern:
            self._count += 1
            self.mean_v += (rectified_v - self.mean_v) / self._count


@dataclass(frozen=True, slots=True)
class PaperState:
    """State of the paper's method at a time: mean, V, and patterns.

    Attributes:
        time_s: the time, s.
        mean_v: mean of the rectified signal without patterns, V.
        pattern: whether a pattern lasts.
        patterns_s, patterns_m: beginnings of patterns, s and m along the way.
    """

    time_s: float
    mean_v: float
    pattern: bool
    patterns_s: tuple[float, ...]
    patterns_m: tuple[float, ...]


def paper_states(stroke: EvenStroke, modes: Sequence[ExplorationMode]) -> list[PaperState]:
    """States over a stroke, one for each 5 ms of stroking; `modes` are those of the stroke's blocks."""
    roughness, way_m = PaperRoughness(), 0.0
    begun_s, begun_m, found = list[float](), list[float](), list[PaperState]()
    for number, mode in enumerate(modes):
        if mode is not ExplorationMode.STROKING:
            continue
        part = slice(number * CHUNK, (number + 1) * CHUNK)
        time_s = float(stroke.time_s[part][-1])
        way_m += float(stroke.speed_m_s[part].sum()) / 2000.0
        roughness.step(stroke.signal_v[part])
        if roughness.began:
            begun_s.append(time_s)
            begun_m.append(way_m)
        found.append(PaperState(time_s, roughness.mean_v, roughness.pattern, tuple(begun_s), tuple(begun_m)))
    return found


class PaperClasses:
    """Hard intervals of the mean, and the distances of patterns, learned from labelled strokes."""

    def __init__(self, strokes: Mapping[str, Sequence[PaperState]]) -> None:
        """Learn from the states at the end of each surface's strokes."""
        self._period_m: dict[str, float] = {}
        self._mean: dict[str, float] = {}
        for name, ends in strokes.items():
            periods = [period for end in ends if (period := _period_m(end)) is not None]
            if len(periods) > 0.5 * len(ends):
                self._period_m[name] = float(np.median(periods))
            self._mean[name] = float(np.median([math.log(max(end.mean_v, 1e-6)) for end in ends]))

    def surface(self, state: PaperState) -> str:
        """The surface in whose interval the stroke falls; borders lie midway in logarithms."""
        period_m = _period_m(state)
        if period_m is not None and self._period_m:
            return min(self._period_m, key=lambda name: abs(math.log(period_m / self._period_m[name])))
        plain = {name: mean for name, mean in self._mean.items() if name not in self._period_m} or self._mean
        return min(plain, key=lambda name: abs(math.log(max(state.mean_v, 1e-6)) - plain[name]))


def _period_m(state: PaperState) -> float | None:
    """Median distance of patterns, m; None where there are too few."""
    return float(np.median(np.diff(state.patterns_m))) if len(state.patterns_m) >= PATTERNED else None
