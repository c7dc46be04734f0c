"""Which calibrated material fits a touch, and how warm the object is: both from one joint posterior.

The object's temperature is unknown, so every temperature of a grid is tried with every material. Given
both, the drops are Gaussian: mean D g + (T_obj - T_ambient) l, covariance D^2 cov(g) + noise. The predictive
density is Student's t, since cov(g) comes from a limited number of touches.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from scipy.stats import chi2

from remote_site.material_table import MaterialTable, drift

Array = NDArray[np.float64]

LOWEST_K, HIGHEST_K, STEP_K = -20.0, 25.0, 0.25
"""Object temperatures considered, relative to ambient, K."""
ANYWHERE = 0.10
"""Weight of an object of any of these temperatures, beside the calibrated prior."""
SMALLEST_DIFFERENCE_K = 1.5
"""Below this difference between plate and object no material is named, K."""
DRIFT_ERROR = 0.15
"""Part of the leak past the object that its estimate may be wrong by."""
USUAL_SD = 3.0
"""Object temperatures within this many standard deviations of the calibrated ones are usual."""
UNKNOWN_QUANTILE = 0.999
"""A touch beyond this quantile of every calibrated material is of none of them."""
SHARED = 0.5
"""Part of a material's variance that the touches of several fingers on one object have in common."""

OFFSETS_K: Array = np.arange(LOWEST_K, HIGHEST_K + STEP_K / 2, STEP_K)


@dataclass(frozen=True, slots=True)
class Judgement:
    """Posterior of one touch (or of several on one object).

    Attributes:
        probability: posterior of each material, in the table's order; sums to 1.
        object_c: posterior mean of the object's temperature, C.
        object_c_sd: its standard deviation, K.
        by_shape: posterior of each material if any temperature were as likely as any other.
        usual_temperature: whether the likeliest material was calibrated at about this temperature.
        no_difference: probability that object and plate differed by less than SMALLEST_DIFFERENCE_K.
        foreign: whether the touch fits no calibrated material at any temperature.
    """

    probability: Array
    object_c: float
    object_c_sd: float
    by_shape: Array
    usual_temperature: bool
    no_difference: float
    foreign: bool


@dataclass(frozen=True, slots=True)
class Evidence:
    """Log likelihood of one touch over materials x OFFSETS_K, before any prior."""

    log_likelihood: Array
    start_c: float
    ambient_c: float
    misfit: float


class MaterialEvidence:
    """Evidence and judgement against one table; shared by all fingers, holds no touch."""

    def __init__(self, table: MaterialTable) -> None:
        self._table = table
        self._dof = np.array([float(entry.touches) for entry in table.materials])[:, None]
        anywhere = np.full(OFFSETS_K.shape, ANYWHERE / len(OFFSETS_K))
        priors = []
        for entry in table.materials:
            likely = np.exp(-0.5 * ((OFFSETS_K - entry.offset_k) / entry.offset_sd_k) ** 2)
            priors.append((1.0 - ANYWHERE) * likely / max(float(likely.sum()), 1e-12) + anywhere)
        self._log_prior: Array = np.log(np.array(priors))
        self._rotation: list[Array] = []
        self._eigenvalue: list[Array] = []
        self._mean: list[Array] = []
        self._drift: list[Array] = []
        self._offset_k = np.array([entry.offset_k for entry in table.materials])
        self._usual_k = np.array([USUAL_SD * entry.offset_sd_k for entry in table.materials])
        all_drifts = drift(np.array([entry.gain_mean for entry in table.materials]), table.times_s, table.leak_per_s)
        self._drift_square = np.mean(all_drifts**2, axis=0)
        for n in range(1, len(table.times_s) + 1):
            values, vectors = zip(
                *(np.linalg.eigh(np.array(entry.gain_covariance)[:n, :n]) for entry in table.materials), strict=True
            )
            self._rotation.append(np.array([v.T for v in vectors]))
            self._eigenvalue.append(np.array(values))
            means = np.array([entry.gain_mean[:n] for entry in table.materials])
            self._mean.append(np.einsum("mij,mj->mi", self._rotation[-1], means))
            self._drift.append(np.einsum("mij,mj->mi", self._rotation[-1], all_drifts[:, :n]))

    def weigh(self, drops_k: Array, start_c: float, ambient_c: float) -> Evidence:
        """Evidence of the drops at the table's first len(drops_k) times, K, of one touch.

        Args:
            drops_k: one or more.
            start_c: plate at contact, C.
            ambient_c: ambient temperature, C.
        """
        n = len(drops_k)
        difference_k = (start_c - ambient_c) - OFFSETS_K
        rotated = self._rotation[n - 1] @ drops_k
        square = difference_k * difference_k
        drift_variance = (DRIFT_ERROR * OFFSETS_K) ** 2 * float(self._drift_square[:n].mean())
        variance = square[None, :, None] * self._eigenvalue[n - 1][:, None, :]
        variance = variance + (self._table.noise_k**2 + drift_variance)[None, :, None]
        error = rotated[:, None, :] - difference_k[None, :, None] * self._mean[n - 1][:, None, :]
        error -= OFFSETS_K[None, :, None] * self._drift[n - 1][:, None, :]
        distance = np.sum(error * error / variance, axis=2)
        log_determinant = np.sum(np.log(variance), axis=2)
        log_likelihood = -0.5 * ((self._dof + n) * np.log1p(distance / self._dof) + log_determinant)
        misfit = float(distance.min()) / _limit(n)
        return Evidence(log_likelihood, start_c, ambient_c, misfit)

    def judge(self, touches: list[Evidence]) -> Judgement:
        """Posterior from the evidence of one touch, or of several fingers on one object.

        Fingers on one object share its effusivity, so that N touches count as N/(1 + (N-1) SHARED).
        """
        count = len(touches)
        total = sum((touch.log_likelihood for touch in touches), np.zeros_like(self._log_prior))
        total = total / (1.0 + (count - 1) * SHARED)
        posterior = _normal(total + self._log_prior)
        best = int(np.argmax(posterior.sum(axis=1)))
        best_k = float(posterior[best] @ OFFSETS_K) / float(posterior[best].sum())
        ambient_c = sum(touch.ambient_c for touch in touches) / count
        start_c = sum(touch.start_c for touch in touches) / count
        at_offset = posterior.sum(axis=0)
        mean_k = float(at_offset @ OFFSETS_K)
        sd_k = float(np.sqrt(max(at_offset @ (OFFSETS_K - mean_k) ** 2, STEP_K**2 / 12.0)))
        near = np.abs(start_c - ambient_c - OFFSETS_K) < SMALLEST_DIFFERENCE_K
        return Judgement(
            probability=posterior.sum(axis=1),
            object_c=ambient_c + mean_k,
            object_c_sd=sd_k,
            by_shape=_normal(total).sum(axis=1),
            usual_temperature=bool(abs(best_k - self._offset_k[best]) <= self._usual_k[best]),
            no_difference=float(at_offset[near].sum()),
            foreign=min(touch.misfit for touch in touches) > 1.0,
        )


def _normal(log_weight: Array) -> Array:
    """Weights that sum to 1 from their logarithms."""
    weight = np.exp(log_weight - log_weight.max())
    return np.asarray(weight / weight.sum())


@lru_cache(maxsize=32)
def _limit(n: int) -> float:
    """Squared Mahalanobis distance beyond which `n` drops belong to no material."""
    return float(chi2.ppf(UNKNOWN_QUANTILE, n))
