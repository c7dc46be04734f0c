"""Classic ways to tell textures: band powers or moments of the signal, and a random forest or linear discriminant.

They are what a new method has to beat. They know nothing of speed, force or space, and have no setting that was chosen
by how well it does.
"""

from importlib import import_module
from itertools import pairwise
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.signal import welch

Array = NDArray[np.float64]

WINDOW = 256
"""Samples of one spectrum; the spectra of half-overlapping windows are averaged."""
BANDS = 12
"""Half octaves below half of the sampling rate."""
TREES = 300
SILENT = 1e-12
"""Least power and variance, so that a flat signal has a logarithm."""


class Classifier(Protocol):
    """What scikit-learn's classifiers have in common."""

    def fit(self, features: Array, labels: Any) -> Any:
        """Learn from features (strokes x features) and a label of each stroke."""

    def predict(self, features: Array) -> Any:
        """A label for each stroke."""


def band_powers(signal: Array, rate_hz: float) -> Array:
    """Natural logarithm of the mean power spectral density in BANDS half octaves, those of the first signal first.

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
        # the spectrum of a short signal may have nothing in a low band: its nearest frequency stands for the band
        rows.append(power[inside].mean(axis=0) if inside.any() else power[np.abs(frequency_hz - high_hz).argmin()])
    return np.log(np.maximum(rows, SILENT)).T.ravel()


def moments(signal: Array) -> Array:
    """Mean, ln of standard deviation, skewness, kurtosis and ln of the steps' deviation, signal by signal.

    Skewness and kurtosis of a flat signal are 0.

    Args:
        signal: samples, or samples x signals; any unit.

    Raises:
        ValueError: fewer than 16 samples.
    """
    columns = _columns(signal)
    spread = np.maximum(columns.std(axis=0), SILENT)
    scaled = (columns - columns.mean(axis=0)) / spread
    # of a flat signal all that is left is rounding
    scaled[:, spread <= 1e-9 * np.abs(columns).max(axis=0) + SILENT] = 0.0
    third, fourth = (scaled**3).mean(axis=0), (scaled**4).mean(axis=0)
    steps = np.maximum(np.diff(columns, axis=0).std(axis=0), SILENT)
    return np.stack([columns.mean(axis=0), np.log(spread), third, fourth, np.log(steps)]).T.ravel()


def classifiers(seed: int = 0) -> dict[str, Classifier]:
    """New, unfitted classifiers by name; for a `seed` always the same."""
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
