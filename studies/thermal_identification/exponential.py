"""Baselines that fit a single exponential to a touch, in the paper's way and in a good way, and classify its rate.

The paper (Kron & Schmidt 2003, Eq. 7-11) waits until the lag of the read-out is over. The good fit uses every reading
from contact: it knows the plate's start temperature and has the lag as a parameter. Both solve the linear parameters in
closed form for each point of a grid (variable projection). The likeliest calibrated rate gives the material.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from remote_site.thermal.exponential_response import TAU_GRID_S, ExponentialFit, ExponentialResponse
from remote_site.thermal.thermal_identification import LEAST_RATE_SD
from remote_site.thermal.touch_start import RecordedTouch
from studies.thermal_identification.situations import Hand

Array = NDArray[np.float64]

LAG_GRID_S: Array = np.geomspace(0.08, 0.8, 9)
FEWEST = 10
"""Fewest readings for a fit."""
_LN_STEP = float(np.log(TAU_GRID_S[1] / TAU_GRID_S[0]))


class LaggedResponse:
    """Fit of T_obj + D exp(-t/tau) as read by a lagging thermistor, which reads T_obj + D at contact."""

    def __init__(self, start_c: float) -> None:
        """Begin at contact; `start_c` is the reading there, C."""
        self._start_c = start_c
        tau_s, lag_s = np.meshgrid(TAU_GRID_S, LAG_GRID_S, indexing="ij")
        # the formula is singular for equal time constants; a difference of 0.1 % removes that without effect
        self._lag_s = np.where(np.abs(tau_s - lag_s) < 1e-3 * lag_s, 1.001 * lag_s, lag_s)
        self._tau_s = tau_s
        self._square, self._cross = np.zeros_like(tau_s), np.zeros_like(tau_s)
        self._yy, self._n = 0.0, 0

    def add(self, since_contact_s: float, sensor_c: float) -> None:
        """Take one reading, C, at a time since contact, s."""
        tau_s, lag_s = self._tau_s, self._lag_s
        left = (tau_s * np.exp(-since_contact_s / tau_s) - lag_s * np.exp(-since_contact_s / lag_s)) / (tau_s - lag_s)
        fallen, y = 1.0 - left, self._start_c - sensor_c
        self._square += fallen * fallen
        self._cross += fallen * y
        self._yy += y * y
        self._n += 1

    def fit(self) -> ExponentialFit | None:
        """Return the best parameters so far; None with fewer than FEWEST readings."""
        if self._n < FEWEST:
            return None
        offset = self._cross / np.maximum(self._square, 1e-12)
        left = self._yy - offset * self._cross
        best, lag = np.unravel_index(int(np.argmin(left)), left.shape)
        shift = 0.0
        if 0 < best < len(TAU_GRID_S) - 1:
            low, middle, high = left[best - 1 : best + 2, lag]
            bend = low - 2.0 * middle + high
            shift = float(0.5 * (low - high) / bend) if bend > 0.0 else 0.0
        beside = min(max(int(best) + (1 if shift > 0.0 else -1), 0), len(TAU_GRID_S) - 1)
        offset_k = float((1.0 - abs(shift)) * offset[best, lag] + abs(shift) * offset[beside, lag])
        tau_s = float(TAU_GRID_S[best]) * float(np.exp(shift * _LN_STEP))
        residual_k = float(np.sqrt(max(float(left[best, lag]), 0.0) / self._n))
        return ExponentialFit(1.0 / tau_s, self._start_c - offset_k, offset_k, residual_k)


Response = ExponentialResponse | LaggedResponse
"""Running fit of one touch."""
WAYS: Mapping[str, Callable[[float], Response]] = {
    "paper": ExponentialResponse,
    "good exponential": LaggedResponse,
}


def fits(way: str, touch: RecordedTouch, times_s: Sequence[float]) -> list[ExponentialFit | None]:
    """Return the fit of the readings up to each time after contact; times ascend, s."""
    response, found = WAYS[way](touch.start_c), list[ExponentialFit | None]()
    for since_s, sensor_c, _ in list(touch.readings())[1:]:
        while len(found) < len(times_s) and since_s > times_s[len(found)] + 1e-6:
            found.append(response.fit())
        if len(found) == len(times_s):
            break
        response.add(since_s, sensor_c)
    return found + [response.fit()] * (len(times_s) - len(found))


@dataclass(frozen=True, slots=True)
class RateTable:
    """Median and scatter of ln(rate) that one kind of fit finds in calibration touches, (materials, times)."""

    way: str
    names: tuple[str, ...]
    times_s: tuple[float, ...]
    ln_rate: Array
    ln_rate_sd: Array

    @classmethod
    def of(cls, way: str, hands: Mapping[str, Sequence[Hand]], times_s: Sequence[float]) -> Self:
        """Build the table from labelled touches; NaN for times without a fit."""
        rows, scatter = [], []
        for each in hands.values():
            rates = np.array([[_ln_rate(fit) for fit in fits(way, hand.fingers[0], times_s)] for hand in each])
            fitted = ~np.isnan(rates).all(axis=0)
            middle, sd = np.full(len(times_s), np.nan), np.full(len(times_s), np.nan)
            middle[fitted] = np.nanmedian(rates[:, fitted], axis=0)
            sd[fitted] = np.nanstd(rates[:, fitted], axis=0)
            rows.append(middle)
            scatter.append(np.maximum(sd, LEAST_RATE_SD))
        return cls(way, tuple(hands), tuple(times_s), np.array(rows), np.array(scatter))

    def likeliest(self, time: int, fit: ExponentialFit | None) -> str | None:
        """Return the material whose calibrated rate and scatter explain a fit best; None without a rate."""
        if fit is None or np.isnan(self.ln_rate[:, time]).any():
            return None
        sd = self.ln_rate_sd[:, time]
        misfit = 0.5 * ((self.ln_rate[:, time] - np.log(fit.rate_per_s)) / sd) ** 2 + np.log(sd)
        return self.names[int(np.argmin(misfit))]


def _ln_rate(fit: ExponentialFit | None) -> float:
    return float("nan") if fit is None else float(np.log(fit.rate_per_s))
