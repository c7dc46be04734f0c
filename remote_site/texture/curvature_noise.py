"""Computes the part of the curvature's power that is sensor noise; exact for white noise, by the samples in a box."""

import math

import numpy as np
from numpy.typing import NDArray

from remote_site.texture.tip_path import RATE_HZ

_FEWEST, _MOST, _STEPS = 1.0, 64.0, 48
_LN_MOST = math.log(_MOST)
_PHASES = 8
"""Number of starting points of a box between two samples over which the power is averaged."""
_MEMORY = 40
"""Length of a lag's impulse response, samples."""


class CurvatureNoise:
    """Power of the curvature of white noise of 1 V rms after the lag that undoes the contact's viscosity."""

    def __init__(self, viscous_s: float) -> None:
        """Take the time constant of the contact's viscosity, s >= 0."""
        keep = math.exp(-1.0 / (RATE_HZ * viscous_s)) if viscous_s > 0.0 else 0.0
        lag = (1.0 - keep) * np.power(keep, np.arange(_MEMORY, dtype=np.float64))
        boxes = np.geomspace(_FEWEST, _MOST, _STEPS + 1)
        self._power = [_power(float(samples), lag) for samples in boxes]

    def power(self, samples: float) -> float:
        """Return the power for a number of samples in a box over that of the noise; interpolated in ln(samples)."""
        at = _STEPS * math.log(min(max(samples, _FEWEST), _MOST)) / _LN_MOST
        whole = min(int(at), _STEPS - 1)
        low, high = self._power[whole], self._power[whole + 1]
        return low + (at - whole) * (high - low)


def _power(samples: float, lag: NDArray[np.float64]) -> float:
    """Sum the squared weights of the samples in box - (boxes beside it) / 2, averaged over the starts of a box."""
    found = []
    for phase in np.arange(_PHASES) / _PHASES:
        edges = phase + samples * np.arange(4)
        ends = np.arange(math.ceil(edges[-1]) + 1)[:, None]
        covered = np.clip(np.minimum(ends + 1, edges[1:]) - np.maximum(ends, edges[:-1]), 0.0, None)
        weights = covered @ np.array([-0.5, 1.0, -0.5]) / samples
        found.append(float(np.square(np.convolve(weights[::-1], lag)).sum()))
    return float(np.mean(found))
