"""Computes the spectrum of a surface's unevenness from a slow stroke, independent of the pressure.

A slow sensor does not resolve single threads, but it measures the unevenness over millimetres and centimetres. Four
steps reduce the influence of pressure, speed and place:

- Each signal is divided by its own mean, because unevenness changes the load in proportion.
- The common motion of all signals is subtracted. All signals follow when the whole sensor heaves or tilts, because the
  arm shakes or the finger sticks and slips. The surface passes the signals one after the other.
- Power is computed in third octaves along the path, so that it belongs to the surface and not to the speed.
- Each stroke is divided into quarters. Their differences show the effect of another place on the same surface.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from remote_site.texture.recorded.stroke_path import travelled
from remote_site.traces.trace_files import StrokeTrace

Array = NDArray[np.float64]
Along = Literal["m", "s", "stroke"]
"""Measure of wavelengths: metres, or without a known speed seconds, or parts of a stroke if all cover the same path."""

PIECES = 4
"""Number of pieces of a stroke."""
LEAST_PERIODS = 3.0
"""Minimum number of periods of the longest wavelength within a piece."""
BANDS_PER_OCTAVE = 3
"""Number of bands per octave."""
HIGHEST = 0.95
"""Upper end of the highest band, as a fraction of half the sampling rate."""
MOTIONS = 3
"""Number of rigid motions of the sensor: heave and two tilts."""
ALL_NOISE = 0.3
"""Minimum power that remains in a band after the noise is subtracted, as a fraction of the noise power."""
QUIET = 0.1
"""Quantile of the strokes' noise at the highest frequencies that gives the sensor's own noise.

The quietest strokes are those over smooth ground.
"""
SILENT = 1e-14
"""Relative power that is added before the logarithm, so that a flat signal has one."""


@dataclass(frozen=True, slots=True)
class Unevenness:
    """Signals of one stroke as shares of the load, evenly along the path, without their common motion.

    Attributes:
        values: samples x signals.
        length: length of the stroke, in the unit of `Along`.
        loads: divisor of each signal: its mean, or the force or 1 if the signal crosses zero.
        used: indices of these signals among those of the stroke; flat signals are left out.
    """

    values: Array
    length: float
    loads: Array
    used: NDArray[np.intp]

    @property
    def step(self) -> float:
        """Distance between two samples, in the unit of `length`."""
        return self.length / (len(self.values) - 1)


def unevenness(
    trace: StrokeTrace, along: Along, speed_m_s: float | None = None, motions: int = MOTIONS
) -> Unevenness | None:
    """Return the unevenness of a stroke; None without a signal that varies, without a needed speed or if too short.

    Args:
        trace: the stroke; flat signals are left out.
        along: measure of the path.
        speed_m_s: speed of a stroke without one of its own, m/s; needed along metres.
        motions: number of common motions to subtract.
    """
    path, signals = trace.time_s, trace.signals
    if along == "m":
        if (moved := travelled(trace, speed_m_s)) is None:
            return None
        path, signals = moved[0], signals[moved[1]]
    used = np.flatnonzero(np.ptp(signals, axis=0) > 0.0)
    if not len(used) or len(signals) < 4 * PIECES:
        return None
    even = np.linspace(path[0], path[-1], len(path))
    values = np.column_stack([np.interp(even, path, column) for column in signals[:, used].T])
    # a signal that crosses zero carries no load of its own, so that the force replaces it if it is known
    force_n = 0.0 if trace.force_n is None else float(trace.force_n.mean())
    loads = np.full(values.shape[1], force_n if force_n > 0.0 else 1.0)
    if values.min() > 0.0:
        loads = values.mean(axis=0)
    shares = (values - values.mean(axis=0)) / loads
    length = 1.0 if along == "stroke" else float(path[-1] - path[0])
    return Unevenness(_without_motions(shares, motions), length, loads, used)


def _without_motions(shares: Array, motions: int) -> Array:
    """Subtract the mean of the signals, then their main components; at least half of the dimensions remain."""
    motions = min(motions, shares.shape[1] // 2)
    if not motions:
        return shares
    shares = shares - shares.mean(axis=1, keepdims=True)
    _, directions = np.linalg.eigh(shares.T @ shares)
    tilts = directions[:, shares.shape[1] - (motions - 1) :]
    return np.asarray(shares - (shares @ tilts) @ tilts.T)


def bands(strokes: Sequence[Unevenness]) -> Array:
    """Return the edges of the bands, about third octaves, that all strokes can show, 1 over the unit of their path.

    Raises:
        ValueError: there are fewer than three bands.
    """
    lowest = LEAST_PERIODS * PIECES / min(stroke.length for stroke in strokes)
    highest = HIGHEST * 0.5 / max(stroke.step for stroke in strokes)
    count = round(BANDS_PER_OCTAVE * np.log2(max(highest / lowest, 1.0)))
    if count < 3:
        raise ValueError(
            f"too short or too coarse: a stroke needs {3 * LEAST_PERIODS * PIECES:.0f} samples at least, "
            "the longest and the finest must have wavelengths in common"
        )
    return np.geomspace(lowest, highest, count + 1)


def sensor_noise(strokes: Sequence[Unevenness], signals: int) -> Array:
    """Return the standard deviation of each signal's white noise, in its own unit, from the quietest strokes."""
    found = np.full((len(strokes), signals), np.nan)
    for row, stroke in zip(found, strokes, strict=True):
        frequency, power = _power(stroke.values, stroke.step)
        row[stroke.used] = np.sqrt(power[frequency > 0.75 * frequency[-1]].mean(axis=0) / stroke.step) * stroke.loads
    return np.array(
        [np.quantile(column[np.isfinite(column)], QUIET) if np.isfinite(column).any() else 0.0 for column in found.T]
    )


def spectrum(stroke: Unevenness, edges: Array, noise: Array) -> Array:
    """Return ln of the power in each band, pieces x bands; nan where a stroke is too short or too coarse.

    Args:
        stroke: stroke of any length; a short one has fewer pieces, but at least one.
        edges: edges of the bands, ascending.
        noise: noise of each signal of the sensor, from `sensor_noise`; its power is subtracted.
    """
    pieces = int(np.clip(np.floor(stroke.length * edges[0] / LEAST_PERIODS + 1e-6), 1, PIECES))
    floor = (noise[stroke.used] / stroke.loads) ** 2 * stroke.step
    rows = []
    for piece in np.array_split(stroke.values, pieces):
        frequency, power = _power(piece, stroke.step)
        row = []
        for low, high in pairwise(edges):
            if high > 0.5001 / stroke.step or low * len(piece) * stroke.step < 0.5 * LEAST_PERIODS:
                row.append(np.nan)
                continue
            inside = (frequency >= low) & (frequency < high)
            if not inside.any():
                inside = np.arange(len(frequency)) == np.abs(frequency - np.sqrt(low * high)).argmin()
            left = np.maximum(power[inside].mean(axis=0) - floor, ALL_NOISE * floor)
            row.append(float(np.log(left.mean() + SILENT)))
        rows.append(row)
    return np.array(rows)


def _power(values: Array, step: float) -> tuple[Array, Array]:
    """Return frequencies, and the power density of each column without its trend.

    Noise of variance 1 has the density `step`.
    """
    trend = np.polynomial.legendre.legvander(np.linspace(-1.0, 1.0, len(values)), 2)
    window = np.hanning(len(values))[:, None]
    rest = (values - trend @ np.linalg.lstsq(trend, values, rcond=None)[0]) * window
    power = np.abs(np.fft.rfft(rest, axis=0)) ** 2 * step / np.sum(window**2)
    return np.asarray(np.fft.rfftfreq(len(values), step)), power
