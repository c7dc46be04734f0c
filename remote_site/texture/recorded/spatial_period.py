"""Estimates the spatial period of a surface from the spectrum of a stroke.

It serves signals too slow to show single grooves, and gratings so dense that single grooves merge. A pattern is a line
that stands out from its neighbourhood in the spectrum, with its harmonics. Of several lines, the one with the largest
slope counts. The arm's swing may have a larger amplitude than the pattern, but it is also longer, and a texture sensor
or a finger responds to slope. Several signals of one stroke are judged together. The period comes from the signal with
the clearest line.

A finger that sticks and slips oscillates in time. At a constant speed this is a line as sharp as a surface's, and at a
low speed it has the larger slope. It moves all signals together, while a surface passes one signal after the other.
Four signals or more show the difference; one signal alone does not.
"""

import math

import numpy as np
from numpy.typing import NDArray

from remote_site.texture.groove_period import Period
from remote_site.texture.recorded.line_fit import fit_line

Array = NDArray[np.float64]
Places = NDArray[np.intp]
Spectra = NDArray[np.complex128]

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
FEWEST_SIGNALS = 4
"""Minimum number of signals that can show a motion of the whole sensor."""
PASSING = 0.4
"""Fraction of the power of a surface's line that is not common to all signals, 0..1; excess common power is a motion's.

It is reached by a pattern of eight times the standard deviation of the signals' places along the stroke.
"""
SHAKEN = 0.1
"""Fraction of a line's power that is not common to all signals, 0..1, below which the whole sensor moves."""
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
COUNT_SD = 0.05
"""Standard deviation of the number of periods in a stroke, from slow motions that a few periods do not separate."""


def spatial_period(path_m: Array, signals: Array, whole: Array | None = None) -> tuple[Period, int] | None:
    """Return the period of the clearest pattern, and the number of the signal with it; None without a pattern.

    The standard deviation grows with noise, with a few periods and with a contact that leans. It excludes an error of
    the speed from which `path_m` comes. A relative error of the speed changes the period by the same fraction.

    Args:
        path_m: place of each sample along the stroke, m; ascending.
        signals: samples x signals, any unit.
        whole: samples x all signals of the sensor, any unit, where `signals` is their mean. The pattern is searched in
            these, and in their mean if the sensor does not shake. The period is fitted to `signals`.
    """
    length_m = float(path_m[-1] - path_m[0])
    if len(path_m) < FEWEST_SAMPLES or not (np.ptp(signals, axis=0) > 0.0).any():
        return None
    frequency, slopes = _slope_spectra(path_m, signals)
    powers = np.abs(slopes) ** 2
    every = slopes if whole is None else _slope_spectra(path_m, whole)[1]
    passing = _passing(every)
    limits = LEAST_PERIODS / length_m, (len(path_m) - 1) / (LEAST_SAMPLES * length_m)
    together = _Spectrum(frequency, (np.abs(every) ** 2).mean(axis=1), length_m)
    line = together.pattern(*limits, passing)
    if line is None and whole is not None and not together.shaken(limits[0], passing):
        line = _Spectrum(frequency, powers.mean(axis=1), length_m).pattern(*limits, passing)
    if line is None:
        return None
    each = [_Spectrum(frequency, power, length_m) for power in powers.T]
    shown = [own.near(float(frequency[line]), 0.5) for own in each]
    prominence = [own.prominence[place] for own, place in zip(each, shown, strict=True)]
    best = int(np.argmax(prominence))
    if prominence[best] < HARMONIC_PROMINENCE:
        return None
    fitted = fit_line(path_m, signals[:, best], float(frequency[shown[best]]))
    if fitted is None:
        return None
    period_m = 1.0 / fitted[0]
    of_contact, of_count = math.sqrt(2.0) * CONTACT_M / length_m, COUNT_SD * period_m / length_m
    return Period(period_m, period_m * math.hypot(fitted[1] * period_m, of_contact, of_count), 0.0), best


def _slope_spectra(path_m: Array, signals: Array) -> tuple[Array, Spectra]:
    """Return spatial frequencies, 1/m, and the spectrum of each signal's slope over the root of its median power."""
    n = len(path_m)
    even_m = np.linspace(path_m[0], path_m[-1], n)
    steps = np.diff(np.column_stack([np.interp(even_m, path_m, column) for column in signals.T]), axis=0)
    steps = (steps - steps.mean(axis=0)) * np.hanning(n - 1)[:, None]
    frequency = np.fft.rfftfreq(PADDING * n, (even_m[-1] - even_m[0]) / (n - 1))
    slopes = np.fft.rfft(steps, PADDING * n, axis=0)
    scale = np.sqrt(np.median(np.abs(slopes) ** 2, axis=0))
    return frequency, slopes / np.maximum(scale, np.sqrt(np.finfo(float).tiny))


def _passing(slopes: Spectra) -> Array:
    """Return the fraction of the power at each frequency, 0..1, that is not common to all signals.

    Squares of spectra have the same phase in two signals that move together, or in opposition as a tilting sensor
    moves them. The mean of their product over all pairs of signals measures this. With fewer than FEWEST_SIGNALS
    signals nothing counts as common.
    """
    if slopes.shape[1] < FEWEST_SIGNALS:
        return np.ones(len(slopes))
    power = np.abs(slopes) ** 2
    alone = (power**2).sum(axis=1)
    common = np.abs((slopes**2).sum(axis=1)) ** 2 - alone
    pairs = np.maximum(power.sum(axis=1) ** 2 - alone, np.finfo(float).tiny)
    return np.asarray(1.0 - np.sqrt(np.clip(common / pairs, 0.0, 1.0)))


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

    def shaken(self, slowest: float, passing: Array) -> bool:
        """Return whether a line above a frequency, 1/m, is a motion of the whole sensor."""
        lines = (self.frequency > slowest) & (self.prominence > LEAST_PROMINENCE)
        return bool((passing[lines] <= SHAKEN).any())

    def pattern(self, slowest: float, fastest: float, passing: Array) -> int | None:
        """Return the index of the fundamental of the line with most slope between two frequencies, 1/m.

        Common power counts less. If a motion of the whole sensor still counts most, it may hide a pattern; the result
        is then None.

        Args:
            slowest: lower frequency, 1/m.
            fastest: upper frequency, 1/m.
            passing: fraction of the power at each frequency that is not common to all signals, 0..1.
        """
        power = self.power
        peaks = np.flatnonzero((power[1:-1] > power[:-2]) & (power[1:-1] >= power[2:])) + 1
        peaks = peaks[(self.frequency[peaks] > slowest) & (self.frequency[peaks] < fastest)]
        lines = peaks[self.prominence[peaks] > LEAST_PROMINENCE]
        if not len(lines):
            return None
        weighted = power[lines] / (1.0 + (FINEST_M * self.frequency[lines]) ** 2)
        weighted *= np.minimum(passing[lines] / PASSING, 1.0)
        line = int(lines[np.argmax(weighted)])
        if passing[line] <= SHAKEN:
            return None
        harmonics = (self.prominence[peaks] > HARMONIC_PROMINENCE) & (passing[peaks] > SHAKEN)
        return self._fundamental(line, peaks[harmonics])

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
