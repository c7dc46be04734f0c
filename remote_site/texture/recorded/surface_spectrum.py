"""What a slow stroke tells of a surface: how strongly it is uneven at each wavelength, whatever the pressure.

A slow sensor sees no single threads, but it sees how uneven a surface is over millimetres and centimetres. Four steps
make of the signals something that another pressure, another speed and another place change little:

- Each signal over its own mean: unevenness is felt as a share of the load.
- What all signals do together is taken away. Where the sensor as a whole heaves or tilts - the arm shakes, the finger
  sticks and slips - all of them follow; the surface passes one after the other.
- Power is taken in third octaves along the path, so that it belongs to the surface and not to the speed.
- Each stroke is taken in quarters: how these differ shows how much another place of the same surface would.
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
"""What wavelengths are measured in: metres; where the speed is unknown seconds, or parts of a stroke if all strokes
go the same way."""

PIECES = 4
LEAST_PERIODS = 3.0
"""A piece holds this many of the longest wavelength."""
BANDS_PER_OCTAVE = 3
HIGHEST = 0.95
"""The highest band ends at this part of half the sampling rate."""
MOTIONS = 3
"""A rigid sensor heaves and tilts two ways."""
ALL_NOISE = 0.3
"""Of the noise, this much is left of a band that is nothing but noise."""
QUIET = 0.1
"""The sensor's noise is what this part of the strokes is below at the highest frequencies: those over smooth ground."""
SILENT = 1e-14
"""Least relative power, so that a flat signal has a logarithm."""


@dataclass(frozen=True, slots=True)
class Unevenness:
    """Signals of one stroke as shares of the load, evenly along the path, without what they all do together.

    Attributes:
        values: samples x signals.
        length: of the stroke, in the unit of `Along`.
        loads: what each signal was divided by, its mean; the force or 1 where it carries no load.
        used: places of these signals among those of the stroke; flat ones are left out.
    """

    values: Array
    length: float
    loads: Array
    used: NDArray[np.intp]

    @property
    def step(self) -> float:
        """Distance of two samples."""
        return self.length / (len(self.values) - 1)


def unevenness(
    trace: StrokeTrace, along: Along, speed_m_s: float | None = None, motions: int = MOTIONS
) -> Unevenness | None:
    """What the signals of a stroke say of its surface; None without a signal that moves, or a speed where it is needed.

    Args:
        trace: the stroke; flat signals are left out.
        along: what the path is measured in.
        speed_m_s: of a stroke without a speed of its own; needed along metres.
        motions: of the whole sensor, to be taken away.
    """
    moved = travelled(trace, speed_m_s)
    if moved is None and along == "m":
        return None
    path = moved[0] if along == "m" and moved is not None else trace.time_s
    signals = trace.signals[moved[1]] if along == "m" and moved is not None else trace.signals
    used = np.flatnonzero(np.ptp(signals, axis=0) > 0.0)
    if not len(used) or len(signals) < 4 * PIECES:
        return None
    even = np.linspace(path[0], path[-1], len(path))
    values = np.column_stack([np.interp(even, path, column) for column in signals[:, used].T])
    # a signal that crosses zero carries no load of its own
    mean = values.mean(axis=0) if values.min() > 0.0 else np.ones(values.shape[1])
    force_n = None if trace.force_n is None else float(trace.force_n.mean())
    if values.min() <= 0.0 and force_n is not None and force_n > 0.0:
        mean = np.full(values.shape[1], force_n)
    shares = (values - values.mean(axis=0)) / mean
    length = 1.0 if along == "stroke" else float(path[-1] - path[0])
    return Unevenness(_without_motions(shares, motions), length, mean, used)


def _without_motions(shares: Array, motions: int) -> Array:
    """Signals less what they share: their mean, then what explains most of the rest; half of them are left at least."""
    motions = min(motions, shares.shape[1] // 2)
    if not motions:
        return shares
    shares = shares - shares.mean(axis=1, keepdims=True)
    _, directions = np.linalg.eigh(shares.T @ shares)
    tilts = directions[:, shares.shape[1] - (motions - 1) :]
    return np.asarray(shares - (shares @ tilts) @ tilts.T)


def bands(strokes: Sequence[Unevenness]) -> Array:
    """Edges of the bands, about third octaves, that all of some strokes can show, 1 over the unit of their path.

    Raises:
        ValueError: there are fewer than three.
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
    """Standard deviation of the white noise of each signal, in its own unit, from the quietest strokes."""
    found = np.full((len(strokes), signals), np.nan)
    for row, stroke in zip(found, strokes, strict=True):
        frequency, power = _power(stroke.values, stroke.step)
        row[stroke.used] = np.sqrt(power[frequency > 0.75 * frequency[-1]].mean(axis=0) / stroke.step) * stroke.loads
    return np.array(
        [np.quantile(column[np.isfinite(column)], QUIET) if np.isfinite(column).any() else 0.0 for column in found.T]
    )


def spectrum(stroke: Unevenness, edges: Array, noise: Array) -> Array:
    """Natural logarithm of the power in each band, pieces x bands; nan where a stroke is too short or too coarse.

    Args:
        stroke: of any length; a short one has fewer pieces, one at least.
        edges: of the bands, ascending.
        noise: of each signal of the sensor, from `sensor_noise`; its power is taken off.
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
    """Frequencies, and power density of each column less its trend; noise of variance 1 has the density `step`."""
    trend = np.polynomial.legendre.legvander(np.linspace(-1.0, 1.0, len(values)), 2)
    window = np.hanning(len(values))[:, None]
    rest = (values - trend @ np.linalg.lstsq(trend, values, rcond=None)[0]) * window
    power = np.abs(np.fft.rfft(rest, axis=0)) ** 2 * step / np.sum(window**2)
    return np.asarray(np.fft.rfftfreq(len(values), step)), power
