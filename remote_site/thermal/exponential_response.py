"""Extrapolates the plate's exponential response (Kron & Schmidt 2003, Eq. 7-11, corrected).

The plate loses heat, C dT/dt = -A U (T - T_obj), so that T(t) = T_obj + D exp(-t/tau) with tau = C/(U A). The printed
equations lack the sign and use a resistance in place of a conductance. For every tau of a logarithmic grid, linear
least squares on running sums gives T_obj and D (variable projection, which reaches the Cramer-Rao bound). A parabola
refines the best tau.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

TAU_GRID_S: NDArray[np.float64] = np.geomspace(0.2, 80.0, 72)
ONSET_S = 0.8
"""Time after contact that is left out, s; there the readings show the lag of the SSR (0.2-0.5 s)."""
AT_ONCE = 10
"""Maximum number of readings that are summed at once."""
_LN_STEP = float(np.log(TAU_GRID_S[1] / TAU_GRID_S[0]))
_MINUS_RATE: NDArray[np.float64] = -1.0 / TAU_GRID_S


@dataclass(frozen=True, slots=True)
class ExponentialFit:
    """Parameters of Eq. 11: `rate_per_s` = 1/tau, 1/s; steady state, C; start offset D, K; rms residual, K."""

    rate_per_s: float
    object_c: float
    offset_k: float
    residual_k: float


class ExponentialResponse:
    """Running fit of one touch; its cost per sample depends only on the grid, not on the number of samples."""

    def __init__(self, start_c: float) -> None:
        """Begin at contact; `start_c` is the temperature of the plate, C, an offset that keeps the sums small."""
        self._start_c = start_c
        self._new: list[tuple[float, float]] = []
        """Readings that are not yet in the sums: time since contact, s, and reading above the start, K."""
        self._n = 0
        self._y = 0.0
        self._yy = 0.0
        self._sum = np.zeros_like(TAU_GRID_S)
        self._square = np.zeros_like(TAU_GRID_S)
        self._cross = np.zeros_like(TAU_GRID_S)

    def add(self, since_contact_s: float, sensor_c: float) -> None:
        """Take one reading, C, at a time since contact, s; readings within the onset are left out."""
        if since_contact_s < ONSET_S:
            return
        self._new.append((since_contact_s, sensor_c - self._start_c))
        if len(self._new) >= AT_ONCE:
            self._sum_up()

    def _sum_up(self) -> None:
        """Add the new readings to the sums."""
        times_s, y = np.array(self._new).T
        self._new.clear()
        basis = np.exp(np.multiply.outer(times_s, _MINUS_RATE))
        self._n += len(y)
        self._y += float(y.sum())
        self._yy += float(y @ y)
        self._sum += basis.sum(axis=0)
        self._square += np.einsum("kt,kt->t", basis, basis)
        self._cross += y @ basis

    def fit(self) -> ExponentialFit | None:
        """Return the best parameters; None with fewer than ten readings or with equal readings."""
        if self._new:
            self._sum_up()
        n = self._n
        if n < 10:
            return None
        mean = self._sum / n
        mean_y = self._y / n
        s_yy = self._yy - n * mean_y * mean_y
        s_ee = self._square - n * mean * mean
        s_ey = self._cross - n * mean * mean_y
        if not s_yy > 1e-12:
            return None
        offset = s_ey / np.maximum(s_ee, 1e-12)
        left = s_yy - offset * s_ey
        best = int(np.argmin(left))
        shift, low, high = 0.0, max(best - 1, 0), min(best + 1, len(left) - 1)
        if high - low == 2:
            bend = left[low] - 2.0 * left[best] + left[high]
            if bend > 0.0:
                shift = float(0.5 * (left[low] - left[high]) / bend)
        tau_s = float(TAU_GRID_S[best]) * float(np.exp(shift * _LN_STEP))
        other = high if shift > 0.0 else low
        part = abs(shift)
        d = float((1.0 - part) * offset[best] + part * offset[other])
        t_obj = mean_y - d * float((1.0 - part) * mean[best] + part * mean[other])
        return ExponentialFit(1.0 / tau_s, self._start_c + t_obj, d, float(np.sqrt(max(float(left[best]), 0.0) / n)))
