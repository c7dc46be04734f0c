"""Spatial period of a surface from the spectrum of a steady stroke.

For signals too slow for impulse flags, and for gratings so dense that single grooves run together.
"""

import numpy as np
from numpy.typing import NDArray

from remote_site.groove_period import Period

PADDING = 8
LEAST_PERIODS = 2.5
"""A line needs this many periods within the stroke."""
LEAST_SAMPLES = 2.5
"""... and this many samples per period."""
LEAST_PROMINENCE = 30.0
"""Power of a line over the median of the spectrum; the largest of 500 bins of white noise stays below 15."""
WIDTH = 0.2
"""Standard deviation of a period, in parts of the spectral resolution."""


def spatial_period(signal: NDArray[np.float64], step_m: float) -> tuple[Period, float] | None:
    """Period of the strongest line, and its power over the median of the spectrum; None without a line.

    The slope of the signal is analysed, not its height: a slow swing of the arm or a tilt of the board
    carries much height and little slope, and it is slope that a texture sensor and a finger feel.

    Args:
        signal: evenly sampled along a stroke of constant speed.
        step_m: distance between samples, m.
    """
    slope = np.diff(signal)
    n = len(slope)
    length_m = n * step_m
    if n < 16 or not slope.any():
        return None
    slope = (slope - slope.mean()) * np.hanning(n)
    power = np.abs(np.fft.rfft(slope, PADDING * n)) ** 2
    frequency = np.fft.rfftfreq(PADDING * n, step_m)
    allowed = (frequency > LEAST_PERIODS / length_m) & (frequency < 1.0 / (LEAST_SAMPLES * step_m))
    if np.count_nonzero(allowed) < 3:
        return None
    power, frequency = power[allowed], frequency[allowed]
    best = int(np.argmax(power))
    prominence = float(power[best] / max(float(np.median(power)), 1e-30))
    if best in (0, len(power) - 1) or prominence < LEAST_PROMINENCE:
        return None
    period_m = 1.0 / float(frequency[best])
    return Period(period_m, WIDTH * period_m * period_m / length_m, 0.0), prominence
