"""The path of the texture sensor's tip over a surface, in space, and the curvature that it feels.

What a stroke sounds like depends on how fast and how hard the finger goes; what the surface is like does not. So the
signal is brought back to the surface before anything is judged. The sensor's leaky integrator is undone: it answers a
groove with a tail of 50 ms. The viscosity of the contact is undone: F + tau dF/dt makes a fast stroke strong, and a
lag of the same time is its exact inverse. And time becomes way: samples are averaged over cells of equal length.

Curvature is the second difference of means over BOX_M: a box less the mean of its two neighbours. It knows neither the
pressure of the hand nor the swing of an arm nor the tilt of a board, all of which change slowly along the way; it
needs 0.6 mm of it and no more.
"""

import math
from collections import deque
from collections.abc import Sequence
from typing import NamedTuple

RATE_HZ = 2000.0
LEAK_HZ = 3.0
"""Corner of the texture sensor's leaky integrator, Hz."""
DRIFT_HZ = 0.2
"""Undoing the leak would sum noise for ever; below this it is let go, Hz."""
CELL_M = 0.1e-3
BOX_M = 2.0 * CELL_M
"""Length over which the path is averaged, m: half of a groove's width."""
SLOWEST_M_S = 4e-3
"""Slower than this the hand's force moves the signal more than the surface does: the path begins anew, m/s."""
_CELLS = 6
_KEEP = 1.0 - 2.0 * math.pi * DRIFT_HZ / RATE_HZ
_LONGEST = RATE_HZ * CELL_M / SLOWEST_M_S


class Curve(NamedTuple):
    """Curvature at one place: when the tip was there, s; way since the path began, m; V; samples in a box."""

    time_s: float
    place_m: float
    curvature_v: float
    samples: float


class TipPath:
    """From samples at RATE_HZ to curvature every CELL_M of way."""

    __slots__ = ("_cells", "_count", "_filled", "_integral_v", "_lag", "_leak", "_path_v", "_sum_v", "_way")

    def __init__(self, viscous_s: float, leak_hz: float = LEAK_HZ) -> None:
        """Take the contact's time constant, s, and the corner of the integrator, Hz; 0 where there is none."""
        self._leak = 2.0 * math.pi * leak_hz / RATE_HZ
        self._cells: deque[tuple[float, float, float]] = deque(maxlen=_CELLS)
        self._lag = 1.0 - math.exp(-1.0 / (RATE_HZ * viscous_s)) if viscous_s > 0.0 else 1.0
        self.forget()

    def forget(self) -> None:
        """Nothing is touched: what the integrator held is gone, and so is the way."""
        self._integral_v = 0.0
        self._path_v = 0.0
        self._way = 0
        self.interrupt()

    def interrupt(self) -> None:
        """The way is interrupted: nothing before is compared with what comes."""
        self._cells.clear()
        self._sum_v = self._count = self._filled = 0.0

    def step(self, samples_v: Sequence[float], end_s: float, speed_m_s: float) -> list[Curve]:
        """Take consecutive samples, V, the last at `end_s`, at one speed >= 0; return the curvatures now known."""
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
        """A cell is full: three boxes make a curvature."""
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
