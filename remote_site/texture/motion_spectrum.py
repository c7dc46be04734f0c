"""Recognises surfaces of recorded strokes by the spectrum of the vibration at a known speed and force.

ln power in each band is linear in ln speed and ln force. The coefficients of a surface are drawn from a normal
distribution of all surfaces, so that a few strokes suffice (a linear mixed model). The same distribution describes
surfaces that were never calibrated, and so shows whether a stroke belongs to one of them.
"""

import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from common.files.strict_model import StrictModel
from remote_site.tables.table_file import Positive

Array = NDArray[np.float64]

EDGES_HZ: Array = np.geomspace(20.0, 450.0, 14)
"""Edges of the bands, Hz, a third of an octave each. A sensor of 1000 samples/s shows all of them."""
UNKNOWN = "unknown"
"""Label of a stroke of no calibrated surface."""
TERMS = 3
"""Number of coefficients of a band: at nominal speed and force, by ln speed, by ln force."""


class StrokeSpectrum(NamedTuple):
    """Spectrum of a stroke: ln power density of each band, terms of its motion, (TERMS,), and duration, s."""

    ln_power: Array
    motion: Array
    seconds: float


@dataclass(frozen=True, slots=True)
class Ranking:
    """Surfaces of a stroke.

    Attributes:
        probabilities: of the calibrated surfaces, in their order; they add up to one.
        fit: ln likelihood of the calibrated surfaces on average over that of any surface, relative to their peaks.
        known: whether the stroke belongs to a calibrated surface.
    """

    probabilities: Array
    fit: float
    known: bool

    @property
    def best(self) -> int:
        """Index of the likeliest surface."""
        return int(self.probabilities.argmax())


class MotionSpectra(StrictModel):
    """Spectra of calibrated surfaces, as functions of speed and force.

    A vector of coefficients has TERMS x bands values, the bands of each term beside each other.

    Attributes:
        mean: mean coefficients of all surfaces.
        between: covariance of the coefficients between surfaces.
        within: covariance of ln power between strokes of one surface, bands x bands.
        seconds: mean duration of the calibrated strokes, s; shorter strokes scatter more.
        coefficients: coefficients of each surface; these do not include their uncertainty.
        moments: sum of the products of the motion's terms over the strokes of each surface, TERMS x TERMS.
        least_fit: smallest `fit` of a stroke that belongs to a calibrated surface.
    """

    mean: list[float]
    between: list[list[float]]
    within: list[list[float]]
    seconds: Positive
    coefficients: list[list[float]] = Field(min_length=2)
    moments: list[list[list[float]]]
    least_fit: float

    def rank(self, stroke: StrokeSpectrum) -> Ranking:
        """Return the probabilities of the surfaces of a stroke; all surfaces have the same prior probability."""
        within = np.array(self.within) + _scatter(stroke.seconds, self.seconds)
        centre, spread = predicted(stroke.motion, *self._surfaces)
        surfaces = ln_density(stroke.ln_power - centre, spread + within)
        any_centre, any_spread = predicted(stroke.motion, np.array([self.mean]), np.array([self.between]))
        fit = fit_of(surfaces, ln_density(stroke.ln_power - any_centre, any_spread + within))
        weights = np.exp(surfaces[0] - surfaces[0].max())
        return Ranking(weights / weights.sum(), fit, fit >= self.least_fit)

    @cached_property
    def _surfaces(self) -> tuple[Array, Array]:
        """Coefficients of each surface, and their covariance."""
        covariance = [posterior(np.array(self.between), np.array(self.within), each) for each in np.array(self.moments)]
        return np.array(self.coefficients), np.array(covariance)


def posterior(between: Array, within: Array, moments: Array) -> Array:
    """Return the covariance of a surface's coefficients after strokes with these moments, TERMS x TERMS."""
    return np.linalg.inv(np.linalg.inv(between) + np.kron(moments, np.linalg.inv(within)))


def predicted(motion: Array, coefficients: Array, covariance: Array) -> tuple[Array, Array]:
    """Return the predicted ln power, surfaces x bands, and its covariance, surfaces x bands x bands."""
    count, bands = len(coefficients), coefficients.shape[1] // TERMS
    parts = covariance.reshape(count, TERMS, bands, TERMS, bands)
    return (
        np.einsum("t,ktb->kb", motion, coefficients.reshape(count, TERMS, bands)),
        np.einsum("s,ksatb,t->kab", motion, parts, motion),
    )


def ln_density(off: Array, covariance: Array) -> Array:
    """Return ln normal density of deviations, cases x bands, and at its peak, (2, cases), without a constant."""
    solved = np.linalg.solve(covariance, off[:, :, None])[:, :, 0]
    peak = -0.5 * np.linalg.slogdet(covariance)[1]
    return np.array([peak - 0.5 * np.einsum("kb,kb->k", off, solved), peak])


def fit_of(surfaces: Array, anything: Array) -> float:
    """Return ln of the mean density of the surfaces over that of any surface, less its mean value at their peaks.

    Densities are those of `ln_density`. The peaks make strokes of all durations comparable.
    """
    density, peaks = surfaces
    mean = float(np.logaddexp.reduce(density)) - math.log(len(density))
    return mean - float(anything[0, 0]) - float(peaks.mean() - anything[1, 0])


def _scatter(seconds: float, calibrated_seconds: float) -> Array:
    """Return the covariance that a spectrum shorter than the calibrated ones adds; a band shows 1 / (width * time)."""
    return np.diag(max(0.0, 1.0 / seconds - 1.0 / calibrated_seconds) / np.diff(EDGES_HZ))
