"""Fits the spectra of surfaces to labelled strokes, and tests them on strokes and surfaces that were left out."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from remote_site.texture.motion_spectrum import (
    TERMS,
    MotionSpectra,
    StrokeSpectrum,
    fit_of,
    ln_density,
    posterior,
    predicted,
)

Array = NDArray[np.float64]
ROUNDS = 20
"""Number of rounds of the expectation-maximisation."""
USUAL = 2.0
"""Number of surfaces that the usual covariance between surfaces counts for."""
USUAL_SD = (1.5, 1.0, 1.0)
"""Usual standard deviation between surfaces of ln power, and of its slopes by ln speed and ln force."""
SHRINKAGE = 0.1
"""Share of the covariance between bands that is discarded, because few strokes cannot show it."""
LEAST_SD = 0.1
"""Minimum standard deviation of ln power between strokes of one surface."""
STRANGERS_KEPT_OUT = 0.85
"""Share of the strokes of left-out surfaces that are to be unknown."""
OWN_LOST = 0.02
"""Share of the strokes of calibrated surfaces that may be unknown where surfaces differ clearly."""


@dataclass(frozen=True, slots=True)
class MotionFit:
    """Fitted spectra, with the label and the answer for each stroke by a table made without it."""

    spectra: MotionSpectra
    left_out: list[tuple[str, str]]

    @property
    def right(self) -> int:
        """Number of left-out strokes whose likeliest surface is their own."""
        return sum(label == answer for label, answer in self.left_out)


def fit_spectra(strokes: Sequence[StrokeSpectrum], labels: Sequence[str]) -> MotionFit | None:
    """Fit spectra to labelled strokes; surfaces are in the order of their labels.

    The result is None with fewer than two surfaces, or with a surface of one stroke.
    """
    names = sorted(set(labels))
    if len(names) < 2 or min(map(labels.count, names)) < 2:
        return None
    label = np.array([names.index(each) for each in labels])
    power, motion = np.array([one.ln_power for one in strokes]), np.array([one.motion for one in strokes])
    mixed = _mixed(power, motion, label)
    densities = _left_out(mixed, power, motion, label)
    answers = [(own, names[int(known[0].argmax())]) for own, (known, _) in zip(labels, densities, strict=True)]
    own = [fit_of(known, anything) for known, anything in densities]
    strange = [
        fit_of(np.delete(known, place, axis=1), anything)
        for place, (known, anything) in zip(label, densities, strict=True)
    ]
    least_fit = max(float(np.quantile(strange, STRANGERS_KEPT_OUT)), float(np.quantile(own, OWN_LOST)))
    spectra = MotionSpectra(
        mean=mixed.mean.tolist(),
        between=mixed.between.tolist(),
        within=mixed.within.tolist(),
        seconds=float(np.mean([one.seconds for one in strokes])),
        coefficients=mixed.coefficients.tolist(),
        moments=mixed.moments.tolist(),
        least_fit=least_fit,
    )
    return MotionFit(spectra, answers)


@dataclass(frozen=True, slots=True)
class _Mixed:
    """Mixed model: distribution of the coefficients, scatter of strokes, and both sums over each surface's strokes."""

    mean: Array
    between: Array
    within: Array
    coefficients: Array
    moments: Array
    products: Array


def _mixed(power: Array, motion: Array, label: NDArray[np.intp]) -> _Mixed:
    """Fit the mixed model to ln power, strokes x bands, and motion, strokes x TERMS, by expectation-maximisation."""
    bands, count = power.shape[1], int(label.max()) + 1
    usual = np.kron(np.diag(np.square(USUAL_SD)), np.eye(bands))
    of = [label == surface for surface in range(count)]
    moments = np.array([motion[own].T @ motion[own] for own in of])
    products = np.array([motion[own].T @ power[own] for own in of])
    mean = np.concatenate([power.mean(axis=0), np.zeros((TERMS - 1) * bands)])
    between, within = usual, np.eye(bands) * np.var(power - power.mean(axis=0))
    coefficients = np.tile(mean, (count, 1))
    for _ in range(ROUNDS):
        covariance = np.array([posterior(between, within, each) for each in moments])
        seen = np.linalg.solve(between, mean) + (products @ np.linalg.inv(within)).reshape(count, -1)
        coefficients = np.einsum("kij,kj->ki", covariance, seen)
        mean = coefficients.mean(axis=0)
        off = coefficients - mean
        between = (off.T @ off + covariance.sum(axis=0) + USUAL * usual) / (count + USUAL)
        left = power - np.einsum("nt,ntb->nb", motion, coefficients.reshape(count, TERMS, bands)[label])
        parts = covariance.reshape(count, TERMS, bands, TERMS, bands)
        whole = (left.T @ left + np.einsum("kst,ksatb->ab", moments, parts)) / len(power)
        within = (1.0 - SHRINKAGE) * whole + SHRINKAGE * np.diag(np.diag(whole)) + LEAST_SD**2 * np.eye(bands)
    return _Mixed(mean, between, within, coefficients, moments, products)


def _left_out(mixed: _Mixed, power: Array, motion: Array, label: NDArray[np.intp]) -> list[tuple[Array, Array]]:
    """Return the ln densities of each stroke for each surface, its own without this stroke, and for any surface."""
    covariance = np.array([posterior(mixed.between, mixed.within, each) for each in mixed.moments])
    inverse, prior = np.linalg.inv(mixed.within), np.linalg.solve(mixed.between, mixed.mean)
    found = []
    for own, moved, seen in zip(label, motion, power, strict=True):
        others, spread = mixed.coefficients.copy(), covariance.copy()
        spread[own] = posterior(mixed.between, mixed.within, mixed.moments[own] - np.outer(moved, moved))
        others[own] = spread[own] @ (prior + ((mixed.products[own] - np.outer(moved, seen)) @ inverse).ravel())
        centre, within = predicted(moved, others, spread)
        any_centre, any_within = predicted(moved, mixed.mean[None], mixed.between[None])
        anything = ln_density(seen - any_centre, any_within + mixed.within)
        found.append((ln_density(seen - centre, within + mixed.within), anything))
    return found
