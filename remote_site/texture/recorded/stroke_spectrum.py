"""Measures the spectrum of a stroke of a fast sensor, with its speed and force."""

import math
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.signal import welch

from remote_site.texture.motion_spectrum import EDGES_HZ, StrokeSpectrum
from remote_site.texture.texture_law import LEAST_FORCE_N, LEAST_SPEED_M_S, NOMINAL_FORCE_N, NOMINAL_SPEED_M_S

Array = NDArray[np.float64]
WINDOW_S = 0.128
"""Length of one window of the spectrum, s; windows overlap by half."""
SILENT = 1e-14
"""Power density that is added before the logarithm, so that a flat signal has one, V^2/Hz."""


def stroke_spectrum(signal_v: Array, rate_hz: float, speed_m_s: float, force_n: float) -> StrokeSpectrum | None:
    """Return the spectrum of a steady stroke; None if it is shorter than one window.

    Samples are in V or the sensor's own unit, at 1000 Hz or more; speed and force are means.
    """
    window = round(WINDOW_S * rate_hz)
    if len(signal_v) < window:
        return None
    frequency_hz, power = welch(signal_v, rate_hz, nperseg=window)
    bands = [power[_inside(frequency_hz, low_hz, high_hz)].mean() for low_hz, high_hz in pairwise(EDGES_HZ)]
    speed, force = max(abs(speed_m_s), LEAST_SPEED_M_S), max(force_n, LEAST_FORCE_N)
    motion = np.array([1.0, math.log(speed / NOMINAL_SPEED_M_S), math.log(force / NOMINAL_FORCE_N)])
    return StrokeSpectrum(np.log(np.array(bands) + SILENT), motion, len(signal_v) / rate_hz)


def _inside(frequency_hz: Array, low_hz: float, high_hz: float) -> NDArray[np.intp]:
    """Return the frequencies in a band, or the nearest one if the band has none."""
    inside = np.flatnonzero((frequency_hz >= low_hz) & (frequency_hz < high_hz))
    return inside if len(inside) else np.array([np.abs(frequency_hz - math.sqrt(low_hz * high_hz)).argmin()])
