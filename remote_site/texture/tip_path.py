"""Computes the path of the texture sensor's tip over a surface, and its curvature along the path.

The signal of a stroke depends on speed and force, but the surface does not. Three steps therefore reconstruct the path
before any judgement. The sensor's leaky integrator, which answers a groove with a tail of 50 ms, is undone. The
viscosity of the contact is undone: F + tau dF/dt makes a fast stroke strong, and a lag with the time constant tau is
its exact inverse. Time becomes distance: samples are averaged over cells of equal length.

Curvature is the second difference of means over boxes of two cells: a box minus the mean of its two neighbours. It is
independent of the hand's pressure, an arm's swing and a board's tilt, which all change slowly along the path. It needs
only 0.6 mm of path.
"""

import math
from collections import deque
from collections.abc import Sequence
from typing import NamedTuple

RATE_HZ = 2000.0
"""Sampling rate of the texture sensor, Hz."""
LEAK_HZ = 3.0
"""Corner of the texture sensor's leaky integrator, Hz."""
DRIFT_HZ = 0.2
"""Corner below which the leak is not undone, Hz; otherwise noise would be integrated without limit."""
CELL_M = 0.1e-3
"""Length of a cell of the path, m."""
SLOWEST_M_S = 4e-3
"""Minimum speed of a path, m/s; below it, the hand's force moves the signal more than the surface."""
_CELLS = 6
"""Number of cells of a curvature: three boxes of two. A box is half as long as a groove is wide."""
_KEEP = 1.0 - 2.0 * math.pi * DRIFT_HZ / RATE_HZ
_LONGEST = RATE_HZ * CELL_M / SLOWEST_M_S


class Curve(NamedTuple):
    """Curvature at one place: time of the tip, s; distance from the start, m; curvature, V; samples in a box."""

    time_s: float
    place_m: float
    curvature_v: float
    samples: float


class TipPath:
    """Converts samples at RATE_HZ to a curvature every CELL_M of path."""

    def __init__(self, viscous_s: float, leak_hz: float = LEAK_HZ) -> None:
        """Take the contact's time constant, s, and the corner of the integrator, Hz; 0 means none."""
        self._leak = 2.0 * math.pi * leak_hz / RATE_HZ
        self._cells: deque[tuple[float, float, float]] = deque(maxlen=_CELLS)
        self._lag = 1.0 - math.exp(-1.0 / (RATE_HZ * viscous_s)) if viscous_s > 0.0 else 1.0
        self.forget()

    def forget(self) -> None:
        """Reset integrator and path after a loss of contact."""
        self._integral_v = 0.0
        self._path_v = 0.0
        self._way = 0
        self.interrupt()

    def interrupt(self) -> None:
        """Interrupt the path; no curvature spans the interruption."""
        self._cells.clear()
        self._sum_v = self._count = self._filled = 0.0

    def step(self, samples_v: Sequence[float], end_s: float, speed_m_s: float) -> list[Curve]:
        """Take consecutive samples, V, the last at `end_s`, s, at one speed, m/s >= 0; return the new curvatures."""
        curves: list[Curve] = []
        cells_a_sample = speed_m_s / (RATE_HZ * CELL_M)
        leak, lag, integral_v, path_v = self._leak, self._lag, self._integral_v, self._path_v
        sum_v, count, filled = self._sum_v, self._count, self._filled
        time_s = end_s - len(samples_v) / RATE_HZ
        for sample_v in samples_v:
            integral_v = _KEEP * (integral_v + sample_v)
            path_v += lag * (sample_v + leak * integral_v - path_v)
            left, part = cells_a_sample, 1.0
            while filled + left >= 1.0:
                room = 1.0 - filled
                part = room / cells_a_sample
                left -= room
                ends_s = time_s + (1.0 - left / cells_a_sample) / RATE_HZ
                self._close(sum_v + part * path_v, count + part, ends_s, curves)
                sum_v = count = filled = 0.0
                part = left / cells_a_sample
            sum_v += part * path_v
            count += part
            filled += left
            time_s += 1.0 / RATE_HZ
        self._integral_v, self._path_v = integral_v, path_v
        self._sum_v, self._count, self._filled = sum_v, count, filled
        return curves

    def _close(self, sum_v: float, count: float, end_s: float, curves: list[Curve]) -> None:
        """Close a full cell; three boxes make a curvature."""
        cells = self._cells
        if count > _LONGEST:
            cells.clear()
            return
        cells.append((sum_v, count, end_s))
        self._way += 1
        if len(cells) == _CELLS:
            (s0, n0, _), (s1, n1, _), (s2, n2, middle_s), (s3, n3, _), (s4, n4, _), (s5, n5, _) = cells
            sides_v = (s0 + s1) / (n0 + n1) + (s4 + s5) / (n4 + n5)
            samples = n2 + n3
            place_m = (self._way - _CELLS // 2) * CELL_M
            curves.append(Curve(middle_s, place_m, (s2 + s3) / samples - 0.5 * sides_v, samples))
