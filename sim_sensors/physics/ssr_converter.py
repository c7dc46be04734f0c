"""Convert a silicon resistor's temperature to the counts of its 12-bit converter, and back by the data sheet's law."""

import numpy as np
from numpy.typing import NDArray

NOISE_C = 0.015
"""Noise of a reading at 100 Hz, K rms."""
R25_OHM = 1000.0
LINEAR_PER_K = 7.874e-3
SQUARE_PER_K2 = 1.874e-5
LOW_OHM = 814.9
"""Resistance at count 0, Ohm."""
HIGH_OHM = 1298.5
"""Resistance at count 4095, Ohm."""
FULL_COUNTS = 4095


def counts_of(ssr_c: NDArray[np.float64]) -> NDArray[np.int16]:
    """Return the converter's counts (0..4095, clipped) for a resistor at `ssr_c`, C."""
    above = ssr_c - 25.0
    ohm = R25_OHM * (1.0 + above * (LINEAR_PER_K + SQUARE_PER_K2 * above))
    counts = np.rint((ohm - LOW_OHM) * (FULL_COUNTS / (HIGH_OHM - LOW_OHM)))
    return np.minimum(np.maximum(counts, 0), FULL_COUNTS).astype(np.int16)


def celsius_of(counts: NDArray[np.int16]) -> NDArray[np.float64]:
    """Return the temperature for `counts`, C: the root of the resistor's quadratic."""
    ohm = LOW_OHM + counts.astype(np.float64) * ((HIGH_OHM - LOW_OHM) / FULL_COUNTS)
    root = np.sqrt(LINEAR_PER_K**2 + 4.0 * SQUARE_PER_K2 * (ohm / R25_OHM - 1.0))
    above: NDArray[np.float64] = (root - LINEAR_PER_K) / (2.0 * SQUARE_PER_K2)
    return above + 25.0
