"""Fits the force law to all presses of one object at once; the presses of other places are the prior of each.

A short press alone does not give the exponent. The presses of one object are therefore draws from one normal
distribution of parameters, and this distribution is estimated together with them (an empirical Bayes method, by
expectation and maximisation). The prior of a press comes from the others alone. With few presses it stays near a
general prior of silicone and tissue. Each press is fitted by the method of Levenberg and Marquardt, and its
covariance is that of Laplace's approximation.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from remote_site.stiffness.force_law import PARAMETERS, gradient
from remote_site.stiffness.press_priors import GENERAL, Prior

Array = NDArray[np.float64]

GENERAL_PRESSES = 1.0
"""Number of presses that count as much as the general prior."""
DEPTH_SD_MM = 0.01
"""Standard deviation of a depth, mm: that of a robot's position."""
NOISE_N, SHARE = (0.002, 0.2), (0.003, 0.1)
"""Ranges of the estimated errors: noise of a force, N, and error of the law as a fraction of the force."""
ERROR_STEP = (0.5, 2.0)
"""Range of the change of an estimated error in one round, as a factor."""
ROUNDS, STEPS = 24, 8
"""Number of rounds of expectation and maximisation, and of fit steps in each."""
UNIT_SHARE = 0.7
"""Unit of depth, as a fraction of the median of the deepest samples."""
LEAST_UNIT_MM = 0.01
"""Smallest unit of depth, mm."""
TYPICAL_LN = 0.5
"""Difference between ln of the largest force of a press and ln of the force at the unit of depth."""
LEAST_FREEDOM = 0.5
"""Lower limit of a press's degrees of freedom."""
USUAL_FREEDOM = 10.0
"""Degrees of freedom with which a press is taken to have the noise of the others."""
LONGEST_STEP = 0.7
"""Largest change of a parameter in one step of the fit."""


@dataclass(frozen=True, slots=True)
class Errors:
    """Standard deviations of the samples: noise of the force, N, and error of the law as a fraction of the force."""

    noise_n: float
    share: float


FIRST_ERRORS = Errors(0.02, 0.03)
"""Errors from which their estimate begins."""


@dataclass(frozen=True, slots=True)
class Fits:
    """Fits of n presses.

    Attributes:
        parameters: of `force_law`, (n, 5), with depth in `unit_mm`.
        covariance: covariance of the parameters, (n, 5, 5), around the mean of all presses.
        common: covariance of the parameters by the error of that mean, (n, 5, 5).
        misfit: root of the squared residuals per degree of freedom, in standard deviations, (n,); 1 if the noise
            explains the residuals.
        scale: factor of each press's standard deviations, (n,): its misfit, drawn towards 1.
        evidence: ln of the marginal likelihood of each press's samples, without constants, (n,).
        errors: standard deviations of the samples.
        unit_mm: unit of depth of the parameters, mm.
    """

    parameters: Array
    covariance: Array
    common: Array
    misfit: Array
    scale: Array
    evidence: Array
    errors: Errors
    unit_mm: float


def fit_presses(depth_mm: Array, force_n: Array, weight: Array, contact_sd_mm: Array, prior: Prior = GENERAL) -> Fits:
    """Fit the law to n presses of one object with up to m samples each.

    Args:
        depth_mm: depths below about the place of contact, (n, m), mm.
        force_n: forces, (n, m), N.
        weight: 1 for a sample, 0 for padding, (n, m); each press has a sample.
        contact_sd_mm: standard deviation of each place of contact, (n,), mm, beside that of the prior.
        prior: prior of the parameters over objects.
    """
    deepest_mm = float(np.median(np.where(weight > 0.0, depth_mm, -np.inf).max(axis=1)))
    unit_mm = max(LEAST_UNIT_MM, UNIT_SHARE * deepest_mm)
    largest_n = np.where(weight > 0.0, force_n, -np.inf).max(axis=1)
    mean = prior.mean.copy()
    mean[0] += np.log(np.median(np.maximum(largest_n, FIRST_ERRORS.noise_n))) - TYPICAL_LN
    spread = np.diag(prior.sd**2)
    spread[3, 3] = (prior.contact_sd_mm / unit_mm) ** 2
    own = np.zeros((len(depth_mm), PARAMETERS, PARAMETERS))
    own[:, 3, 3] = (contact_sd_mm / unit_mm) ** 2
    means, spreads = np.tile(mean, (len(depth_mm), 1)), spread + own
    parameters, errors = means, FIRST_ERRORS
    for _ in range(ROUNDS):
        inverse: Array = np.linalg.inv(spreads).astype(np.float64)
        fit = _Fit(depth_mm / unit_mm, force_n, weight, means, inverse, errors, DEPTH_SD_MM / unit_mm)
        parameters, covariance, squares, evidence = fit.step(parameters, STEPS)
        # The prior's share of the information is not information from the samples.
        used = PARAMETERS - np.einsum("nij,nji->n", covariance, inverse)
        free = np.maximum(weight.sum(axis=1) - used, LEAST_FREEDOM)
        errors = fit.errors_after(parameters, float(free.sum() / weight.sum()))
        means, spreads = _priors_from_others(parameters, covariance, mean, spread)
        spreads += own
    scale = np.sqrt((squares + USUAL_FREEDOM) / (free + USUAL_FREEDOM))
    common = _by_common_mean(covariance, inverse, spread)
    return Fits(parameters, covariance, common, np.sqrt(squares / free), scale, evidence, errors, unit_mm)


def _by_common_mean(covariance: Array, inverse: Array, spread: Array) -> Array:
    """Return the covariance of each press's parameters, (n, 5, 5), by the error of the mean of all presses."""
    by_mean = covariance @ inverse
    known = (inverse - inverse @ by_mean).sum(axis=0)
    mean = np.linalg.inv(np.linalg.inv(spread) + known)
    return np.asarray(by_mean @ mean @ by_mean.transpose(0, 2, 1))


def _priors_from_others(parameters: Array, covariance: Array, mean: Array, spread: Array) -> tuple[Array, Array]:
    """Return mean, (n, 5), and covariance, (n, 5, 5), of the prior of each press from all others."""
    others = len(parameters) - 1.0 + GENERAL_PRESSES
    means = (parameters.sum(axis=0) - parameters + GENERAL_PRESSES * mean) / others
    centre = parameters.mean(axis=0)
    away = parameters - centre
    each = away[:, :, np.newaxis] * away[:, np.newaxis, :] + covariance
    from_centre = means - centre
    shift = from_centre[:, :, np.newaxis] * from_centre[:, np.newaxis, :]
    return means, (each.sum(axis=0) - each + GENERAL_PRESSES * (spread + shift)) / others


class _Fit:
    """Fit of all presses with fixed priors and noise."""

    def __init__(
        self,
        depth: Array,
        force_n: Array,
        weight: Array,
        means: Array,
        inverse: Array,
        errors: Errors,
        depth_sd: float,
    ) -> None:
        self.depth, self.force_n, self.weight = depth, force_n, weight
        self.means, self.inverse = means, inverse
        self.errors, self.depth_sd = errors, depth_sd

    def step(self, parameters: Array, steps: int) -> tuple[Array, Array, Array, Array]:
        """Return the parameters after some steps, their covariance, the squared residuals, in sd, and the evidence."""
        damping = np.full(len(parameters), 1e-2)
        parameters = parameters.copy()
        for _ in range(steps):
            variance, residual, information, slope = self._linearised(parameters)
            before = self._cost(parameters, variance, residual)
            own = np.einsum("nii->ni", information)
            damped = information + damping[:, np.newaxis, np.newaxis] * own[:, :, np.newaxis] * np.eye(PARAMETERS)
            change = np.linalg.solve(damped, slope[..., np.newaxis])[..., 0]
            tried = parameters + np.clip(change, -LONGEST_STEP, LONGEST_STEP)
            after = self._cost(tried, variance, self._residual(tried))
            better = after <= before
            parameters[better] = tried[better]
            damping = np.clip(np.where(better, 0.3 * damping, 8.0 * damping), 1e-6, 1e6)
        variance, residual, information, _ = self._linearised(parameters)
        squares = (self.weight * residual**2 / variance).sum(axis=1)
        # Laplace's approximation of the integral over the parameters.
        determinants = np.linalg.slogdet(self.inverse)[1] - np.linalg.slogdet(information)[1]
        cost = self._cost(parameters, variance, residual) + (self.weight * np.log(variance)).sum(axis=1)
        return parameters, np.linalg.inv(information).astype(np.float64), squares, 0.5 * (determinants - cost)

    def _linearised(self, parameters: Array) -> tuple[Array, Array, Array, Array]:
        law_n, by_parameters, by_depth = gradient(parameters, self.depth)
        variance = self.errors.noise_n**2 + self._law_variance(parameters, law_n, by_depth)
        residual = self.force_n - law_n
        weighted = by_parameters * (self.weight / variance)[..., np.newaxis]
        information = np.einsum("nmi,nmj->nij", weighted, by_parameters) + self.inverse
        away = parameters - self.means
        slope = np.einsum("nmi,nm->ni", weighted, residual) - np.einsum("nij,nj->ni", self.inverse, away)
        return variance, residual, information, slope

    def _law_variance(self, parameters: Array, law_n: Array, by_depth: Array) -> Array:
        """Return the variances of the force, N2, by errors of the law and of the depth."""
        elastic_n = law_n - parameters[:, 4:5]
        return np.asarray((self.errors.share * elastic_n) ** 2 + (self.depth_sd * by_depth) ** 2)

    def errors_after(self, parameters: Array, free_share: float) -> Errors:
        """Return the errors by which the residuals are as large as stated (variance components, one iteration)."""
        law_n, _, by_depth = gradient(parameters, self.depth)
        law = self._law_variance(parameters, law_n, by_depth)
        noise = np.full_like(law, self.errors.noise_n**2)
        found = []
        for part in (noise, law):
            share = self.weight * part / (noise + law)
            squares = (share * (self.force_n - law_n) ** 2 / (noise + law)).sum()
            found.append(np.sqrt((squares + GENERAL_PRESSES) / (free_share * share.sum() + GENERAL_PRESSES)))
        noise_factor, law_factor = np.clip(found, *ERROR_STEP)
        return Errors(
            float(np.clip(self.errors.noise_n * noise_factor, *NOISE_N)),
            float(np.clip(self.errors.share * law_factor, *SHARE)),
        )

    def _residual(self, parameters: Array) -> Array:
        return self.force_n - gradient(parameters, self.depth)[0]

    def _cost(self, parameters: Array, variance: Array, residual: Array) -> Array:
        away = parameters - self.means
        prior = np.einsum("ni,nij,nj->n", away, self.inverse, away)
        return np.asarray((self.weight * residual**2 / variance).sum(axis=1) + prior)
