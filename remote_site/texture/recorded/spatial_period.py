"""Estimates the spatial period of a surface from the spectrum of a stroke.

It serves signals too slow to show single grooves, and gratings so dense that single grooves merge. A pattern is a line
that stands out from its neighbourhood in the spectrum, with its harmonics. Of several lines, the one with the largest
slope counts. The arm's swing may have a larger amplitude than the pattern, but it is also longer, and a texture sensor
or a finger responds to slope. Several signals of one stroke are judged together. The period comes from the signal with
the clearest line.
"""

import math

import numpy as np
from numpy.typing import NDArray

from remote_site.texture.groove_period import Period
from remote_site.texture.recorded.line_fit import fit_line

Array = NDArray[np.float64]
Places = NDArray[np.intp]

PADDING = 8
"""Length of the Fourier transform over the number of samples."""
FEWEST_SAMPLES = 32
"""Minimum number of samples of a stroke."""
LEAST_PERIODS = 3.0
"""Minimum number of a line's periods within the stroke."""
LEAST_SAMPLES = 2.2
"""Minimum number of samples per period of a line."""
LEAST_PROMINENCE = 30.0
"""Minimum power of a line over the median of its neighbourhood."""
NEIGHBOURS = 12
"""Half width of the neighbourhood in units of the spectral resolution; half of the frequency if that is more."""
FINEST_M = 2e-3
"""Wavelength scale of a soft fingertip's contact, m; shorter lines are weighted by height instead of slope.

Without this, the edges of wide grooves would outweigh the grooves.
"""
HARMONIC_PROMINENCE = 8.0
"""Minimum prominence of a harmonic; at a known place, noise reaches it once in 2^8 times."""
HARMONIC_AMPLITUDE = 0.9
"""Minimum amplitude of the harmonics below a line, over that of the line; apart from noise, they are not weaker."""
MOST_HARMONICS = 6
"""Highest order of harmonic that is considered."""
SAME_LINE = 0.25
"""Maximum distance of a harmonic from a multiple of its fundamental, in units of the spectral resolution."""
CONTACT_M = 0.25e-3
"""Standard deviation of the contact's place within a soft sensor, which leans into its stroke, m.

In the recorded boards the pattern leads and lags by this distance along a stroke, and by more at its ends.
"""


def spatial_period(path_m: Array, signals: Array) -> tuple[Period, int] | None:
    """Return the period of the clearest pattern, and the number of the signal with it; None without a pattern.

    The standard deviation excludes an error of the speed from which `path_m` comes. A relative error of the speed
    changes the period by the same fraction.

    Args:
        path_m: place of each sample along the stroke, m; ascending.
        signals: samples x signals, any unit.
    """
    length_m = float(path_m[-1] - path_m[0])
    if len(path_m) < FEWEST_SAMPLES or not (np.ptp(signals, axis=0) > 0.0).any():
        return None
    frequency, powers = _slope_spectra(path_m, signals)
    together = _Spectrum(frequency, powers.mean(axis=1), length_m)
    line = together.pattern(LEAST_PERIODS / length_m, (len(path_m) - 1) / (LEAST_SAMPLES * length_m))
    if line is None:
        return None
    each = [_Spectrum(frequency, power, length_m) for power in powers.T]
    shown = [own.near(float(frequency[line]), 0.5) for own in each]
    best = int(np.argmax([own.prominence[place] for own, place in zip(each, shown, strict=True)]))
    fitted = fit_line(path_m, signals[:, best], float(frequency[shown[best]]))
    if fitted is None:
        return None
    period_m = 1.0 / fitted[0]
    path_sd = math.sqrt(2.0) * CONTACT_M / length_m
    return Period(period_m, period_m * math.hypot(fitted[1] * period_m, path_sd), 0.0), best


def _slope_spectra(path_m: Array, signals: Array) -> tuple[Array, Array]:
    """Return spatial frequencies, 1/m, and the power of each signal's slope over its median."""
    n = len(path_m)
    even_m = np.linspace(path_m[0], path_m[-1], n)
    slopes = np.diff(np.column_stack([np.interp(even_m, path_m, column) for column in signals.T]), axis=0)
    slopes = (slopes - slopes.mean(axis=0)) * np.hanning(n - 1)[:, None]
    frequency = np.fft.rfftfreq(PADDING * n, (even_m[-1] - even_m[0]) / (n - 1))
    powers = np.abs(np.fft.rfft(slopes, PADDING * n, axis=0)) ** 2
    return frequency, powers / np.maximum(np.median(powers, axis=0), np.finfo(float).tiny)


class _Spectrum:
    """Power of the slope, and prominence of each frequency over its neighbourhood."""

    def __init__(self, frequency: Array, power: Array, length_m: float) -> None:
        self.frequency, self.power, self.resolution = frequency, power, 1.0 / length_m
        self.noise = self._neighbourhood()
        self.prominence = power / self.noise

    def _neighbourhood(self) -> Array:
        centres = np.geomspace(self.resolution, self.frequency[-1], 64)
        medians = []
        for centre in centres:
            reach = max(NEIGHBOURS * self.resolution, 0.5 * centre)
            near = (self.frequency > max(centre - reach, self.resolution)) & (self.frequency < centre + reach)
            medians.append(float(np.median(self.power[near])))
        return np.maximum(np.interp(self.frequency, centres, medians), np.finfo(float).tiny)

    def near(self, wanted: float, reach: float) -> int:
        """Return the index of most power within `reach` times the resolution of a frequency, 1/m."""
        inside = np.flatnonzero(np.abs(self.frequency - wanted) <= reach * self.resolution)
        return int(inside[np.argmax(self.power[inside])])

    def pattern(self, slowest: float, fastest: float) -> int | None:
        """Return the index of the fundamental of the line with most slope between two frequencies, 1/m."""
        power = self.power
        peaks = np.flatnonzero((power[1:-1] > power[:-2]) & (power[1:-1] >= power[2:])) + 1
        peaks = peaks[(self.frequency[peaks] > slowest) & (self.frequency[peaks] < fastest)]
        lines = peaks[self.prominence[peaks] > LEAST_PROMINENCE]
        if not len(lines):
            return None
        weighted = power[lines] / (1.0 + (FINEST_M * self.frequency[lines]) ** 2)
        line = int(lines[np.argmax(weighted)])
        return self._fundamental(line, peaks[self.prominence[peaks] > HARMONIC_PROMINENCE])

    def _fundamental(self, line: int, peaks: Places) -> int:
        """Return the fundamental of `line`: `line` itself, unless all lower harmonics exist and none is much weaker."""
        for order in range(MOST_HARMONICS, 1, -1):
            below = [self._peak(peaks, k * float(self.frequency[line]) / order) for k in range(1, order)]
            if all(k is not None and self._amplitude(k) > HARMONIC_AMPLITUDE * self._amplitude(line) for k in below):
                return below[0] or line
        return line

    def _peak(self, peaks: Places, wanted: float) -> int | None:
        near = peaks[np.abs(self.frequency[peaks] - wanted) < SAME_LINE * self.resolution]
        return int(near[0]) if len(near) else None

    def _amplitude(self, place: int) -> float:
        return math.sqrt(self.power[place]) / float(self.frequency[place])
