"""Classic texture classifiers: band powers or moments of the signal, with a random forest or a linear discriminant.

They are the baselines for new methods. They use neither speed nor force nor position, and none of their settings was
tuned to its results.
"""

from importlib import import_module
from itertools import pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.signal import welch

Array = NDArray[np.float64]

WINDOW = 256
"""Number of samples of one spectrum; the spectra of half-overlapping windows are averaged."""
BANDS = 12
"""Number of half-octave bands below half of the sampling rate."""
TREES = 300
SILENT = 1e-12
"""Least power and standard deviation, so that a flat signal has a logarithm."""


def band_powers(signal: Array, rate_hz: float) -> Array:
    """Return the natural logarithm of the mean power spectral density in BANDS half octaves, signal by signal.

    Args:
        signal: samples, or samples x signals; any unit.
        rate_hz: sampling rate, 1/s. The bands end at half of it.

    Raises:
        ValueError: fewer than 16 samples.
    """
    columns = _columns(signal)
    window = min(WINDOW, len(columns))
    frequency_hz, power = welch(columns, rate_hz, nperseg=window, axis=0)
    edges_hz = 0.5 * rate_hz * 2.0 ** (0.5 * np.arange(-BANDS, 1))
    rows = []
    for low_hz, high_hz in pairwise(edges_hz):
        inside = (frequency_hz > low_hz) & (frequency_hz <= high_hz)
        # a low band of a short signal may have no frequency inside; the nearest frequency then represents the band
        rows.append(power[inside].mean(axis=0) if inside.any() else power[np.abs(frequency_hz - high_hz).argmin()])
    return np.log(np.maximum(rows, SILENT)).T.ravel()


def moments(signal: Array) -> Array:
    """Return mean, ln of standard deviation, skewness, kurtosis and ln of the steps' deviation, signal by signal.

    Skewness and kurtosis of a flat signal are 0. Raises ValueError with fewer than 16 samples.
    """
    columns = _columns(signal)
    spread = np.maximum(columns.std(axis=0), SILENT)
    scaled = (columns - columns.mean(axis=0)) / spread
    # a flat signal leaves only rounding errors
    scaled[:, spread <= 1e-9 * np.abs(columns).max(axis=0) + SILENT] = 0.0
    third, fourth = (scaled**3).mean(axis=0), (scaled**4).mean(axis=0)
    steps = np.maximum(np.diff(columns, axis=0).std(axis=0), SILENT)
    return np.stack([columns.mean(axis=0), np.log(spread), third, fourth, np.log(steps)]).T.ravel()


def classifiers(seed: int = 0) -> dict[str, Any]:
    """Return new, unfitted classifiers of scikit-learn by name; the same `seed` gives the same classifiers."""
    forest = import_module("sklearn.ensemble").RandomForestClassifier(TREES, random_state=seed)
    discriminant = import_module("sklearn.discriminant_analysis").LinearDiscriminantAnalysis(
        solver="lsqr", shrinkage="auto"
    )
    return {"random forest": forest, "linear discriminant": discriminant}


def _columns(signal: Array) -> Array:
    columns = signal[:, None] if signal.ndim == 1 else signal
    if len(columns) < 16:
        raise ValueError(f"a signal needs at least 16 samples, not {len(columns)}")
    return columns
