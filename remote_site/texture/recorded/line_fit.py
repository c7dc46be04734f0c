"""Frequency of one line of a spectrum by least squares, with the standard deviation that the stroke itself shows.

The highest bin of a spectrum knows a frequency to a part of its resolution, and is drawn to where the spectrum rises.
A sinusoid fitted to all samples, beside a slow trend, knows it far better (the maximum likelihood estimate; Rife &
Boorstyn 1974). How sure it is cannot be taken from the noise: a soft sensor leans into its stroke, so that the pattern
leads and lags by up to a millimetre, and that is no white noise. Each tenth of the stroke is left out in turn, and the
scatter of what the rest says is the standard deviation (jackknife over blocks; Kunsch 1989).
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

TREND = 4
"""Degree of the polynomial that stands for tilt, drift and the arm's slow swing."""
BLOCKS = 10
STEPS = 12
SETTLED = 1e-7
"""Of the frequency: a smaller step ends the search."""
FARTHEST = 0.7
"""The fit may move so far from where it started, in parts of the spectral resolution; beyond, it left the line."""


def fit_line(path_m: Array, signal: Array, start_per_m: float) -> tuple[float, float] | None:
    """Spatial frequency of the line nearest to `start_per_m` and its standard deviation, 1/m; None if there is none.

    Args:
        path_m: where each sample was taken along the stroke, m; ascending, of any spacing.
        signal: one value for each, any unit.
        start_per_m: within half of the spectral resolution (1 over the length) of the line, 1/m.
    """
    along = (path_m - path_m[0]) / (path_m[-1] - path_m[0])
    trend = np.polynomial.legendre.legvander(2.0 * along - 1.0, TREND)
    # in periods per stroke: all unknowns are of like size
    per_m = 1.0 / float(path_m[-1] - path_m[0])
    start = periods = start_per_m / per_m
    for _ in range(STEPS):
        slopes, rest = _linearised(along, signal, trend, periods)
        step = float(np.linalg.lstsq(slopes, rest, rcond=None)[0][-1])
        periods += float(np.clip(step, -0.2, 0.2))
        if abs(periods - start) > FARTHEST:
            return None
        if abs(step) < SETTLED * periods:
            break
    slopes, rest = _linearised(along, signal, trend, periods)
    return periods * per_m, _jackknife(slopes, rest, along) * per_m


def _linearised(along: Array, signal: Array, trend: Array, periods: float) -> tuple[Array, Array]:
    """Derivatives by trend, cosine, sine and number of periods, and what the best of the first three leave."""
    angle = 2.0 * np.pi * periods * along
    line = np.column_stack([trend, np.cos(angle), np.sin(angle)])
    found = np.linalg.lstsq(line, signal, rcond=None)[0]
    cosine, sine = found[-2:]
    by_periods = 2.0 * np.pi * along * (sine * np.cos(angle) - cosine * np.sin(angle))
    return np.column_stack([line, by_periods]), signal - line @ found


def _jackknife(slopes: Array, rest: Array, along: Array) -> float:
    """Standard deviation of the last unknown, from what leaving out each block changes, to first order."""
    block = np.minimum((BLOCKS * along).astype(int), BLOCKS - 1)
    whole = slopes.T @ slopes
    changes = []
    for left_out in range(BLOCKS):
        part, missing = slopes[block == left_out], rest[block == left_out]
        changes.append(np.linalg.lstsq(whole - part.T @ part, -part.T @ missing, rcond=None)[0][-1])
    return float(np.sqrt((BLOCKS - 1) * np.var(changes)))
