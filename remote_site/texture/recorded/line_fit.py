"""Fits the frequency of one spectral line by least squares, with a standard deviation from the stroke itself.

The highest bin of a spectrum gives a frequency only to a fraction of its resolution, with a bias to where the spectrum
rises. A sinusoid fitted to all samples with a slow trend is much more precise (the maximum likelihood estimate; Rife &
Boorstyn 1974). The noise does not give its uncertainty. A soft sensor leans into its stroke, so that the pattern leads
and lags by up to a millimetre, which is not white noise. Each tenth of the stroke is therefore left out in turn. The
scatter of these estimates gives the standard deviation (jackknife over blocks; Kunsch 1989).
"""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

TREND = 4
"""Degree of the polynomial that models tilt, drift and the arm's slow swing."""
BLOCKS = 10
"""Number of blocks of the jackknife."""
STEPS = 12
"""Maximum number of steps of the search."""
SETTLED = 1e-7
"""Step that ends the search, as a fraction of the frequency."""
FARTHEST = 0.7
"""Maximum distance of the fit from its start, in units of the spectral resolution; beyond, it has left the line."""


def fit_line(path_m: Array, signal: Array, start_per_m: float) -> tuple[float, float] | None:
    """Return the frequency of the line nearest to `start_per_m` and its standard deviation, 1/m; None without a line.

    Args:
        path_m: place of each sample along the stroke, m; ascending, with any spacing.
        signal: value of each sample, any unit.
        start_per_m: start of the search, 1/m, within half of the spectral resolution (1 over the length) of the line.
    """
    along = (path_m - path_m[0]) / (path_m[-1] - path_m[0])
    trend = np.polynomial.legendre.legvander(2.0 * along - 1.0, TREND)
    # in periods per stroke, so that all unknowns are of similar size
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
    """Return derivatives by trend, cosine, sine and number of periods, and the residual of the best first three."""
    angle = 2.0 * np.pi * periods * along
    line = np.column_stack([trend, np.cos(angle), np.sin(angle)])
    found = np.linalg.lstsq(line, signal, rcond=None)[0]
    cosine, sine = found[-2:]
    by_periods = 2.0 * np.pi * along * (sine * np.cos(angle) - cosine * np.sin(angle))
    return np.column_stack([line, by_periods]), signal - line @ found


def _jackknife(slopes: Array, rest: Array, along: Array) -> float:
    """Return the standard deviation of the last unknown, from its first-order changes without each block."""
    block = np.minimum((BLOCKS * along).astype(int), BLOCKS - 1)
    whole = slopes.T @ slopes
    changes = []
    for left_out in range(BLOCKS):
        part, missing = slopes[block == left_out], rest[block == left_out]
        changes.append(np.linalg.lstsq(whole - part.T @ part, -part.T @ missing, rcond=None)[0][-1])
    return float(np.sqrt((BLOCKS - 1) * np.var(changes)))
