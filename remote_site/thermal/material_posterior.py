"""Computes the posterior of material and temperature from the evidence of one touch, or of fingers on one object.

Fingers on one object share its material, its piece and its temperature, but not the quality of their contacts. Each
finger's evidence is normal in temperature and ln effusivity for each substance, so that the product has a closed form.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import NDArray
from scipy.special import expit, ndtr

from remote_site.thermal.material_table import MaterialTable
from remote_site.thermal.touch_estimate import ANYWHERE_K, TouchEvidence
from remote_site.thermal.touch_hypotheses import Substances

Array = NDArray[np.float64]

ANYWHERE = 0.10
"""Prior probability of an object with any temperature, instead of one as in calibration."""
STEPS = np.arange(-2.0, 3.0)
"""Means of the narrow normals that model an even spread of the calibration's object temperatures, in steps."""
STEP_SD = 0.6
"""Standard deviation of each of these narrow normals, in steps."""
SAME_OBJECT = 0.9
"""Prior probability that fingers of one hand that touch at the same time touch the same object."""
SHARED_ERROR = 0.3
"""Share of a finger's errors that the other fingers on the same object have as well.

Fingers of one hand touch the same piece, with the same kind of sensor, under the same ambient temperature. n equal
fingers then count as n / (1 + (n - 1) SHARED_ERROR) independent ones.
"""
OWN_EFFUSIVITY = 0.5
"""Share of the variance of ln effusivity in calibration that is each finger's error; the piece has the rest.

Calibration touches each piece once and cannot distinguish the two.
"""
SMALLEST_DIFFERENCE_K = 1.0
"""Smallest difference between plate and object that readings can show, K."""


@dataclass(frozen=True, slots=True)
class Posterior:
    """Posterior of an object.

    Attributes:
        probability: probability of each calibrated material, in the table's order.
        foreign: probability of another material; with `probability` it sums to 1.
        object_c: posterior mean of the object's temperature, C.
        object_c_sd: standard deviation of the temperature, K.
        ln_effusivity: posterior mean of ln effusivity, in the table's units.
        ln_effusivity_sd: standard deviation of ln effusivity.
        no_difference: probability that no finger's plate differed from the object by more than SMALLEST_DIFFERENCE_K.
        misfit: largest misfit of the touches.
        same_object: probability that all fingers touched one object; 1 for one finger.
    """

    probability: Array
    foreign: float
    object_c: float
    object_c_sd: float
    ln_effusivity: float
    ln_effusivity_sd: float
    no_difference: float
    misfit: float
    same_object: float


class _Prior(NamedTuple):
    """Prior of (temperature, ln effusivity) of m substances, as if they had any temperature, in information form.

    Attributes:
        information: (m, 2, 2) information matrices.
        vector: (m, 2) information vectors.
        integral: (m,) ln integral; see `_integral`.
    """

    information: Array
    vector: Array
    integral: Array

    @classmethod
    def of(cls, ln_effusivity: Array, variance: Array) -> Self:
        """Return the prior for these means and variances of ln effusivity, (m,) each."""
        information, vector = np.zeros((len(variance), 2, 2)), np.zeros((len(variance), 2))
        information[:, 0, 0], information[:, 1, 1] = 1.0 / ANYWHERE_K**2, 1.0 / variance
        vector[:, 1] = ln_effusivity / variance
        mean = np.stack((np.zeros(len(variance)), ln_effusivity), axis=1)
        return cls(information, vector, _integral(information, vector, mean))


class MaterialPosterior:
    """Judges evidence by one table; it has no state of a touch."""

    def __init__(self, table: MaterialTable, known: Substances) -> None:
        self._known = known
        count = len(known.probability)
        self._ln_prior = np.log(known.probability)
        calibrated = np.arange(count) < known.calibrated
        self._own_variance = OWN_EFFUSIVITY * np.where(
            calibrated, known.effusivity_variance, np.median(known.effusivity_variance[: known.calibrated])
        )
        of_piece = known.effusivity_variance - np.where(calibrated, self._own_variance, 0.0)
        self._finger_prior = _Prior.of(known.ln_effusivity, known.effusivity_variance)
        self._prior = _Prior.of(known.ln_effusivity, of_piece)
        others = count - known.calibrated
        offsets = np.array([entry.offset_k for entry in table.materials])
        sds = np.array([entry.offset_sd_k for entry in table.materials])
        usual_k = np.concatenate((offsets, np.full(others, offsets.mean())))
        usual_sd_k = np.concatenate((sds, np.full(others, np.hypot(sds.max(), offsets.std()))))
        step_k = usual_sd_k / np.sqrt(np.mean(STEPS**2) + STEP_SD**2)
        share = np.append(np.full(len(STEPS), (1.0 - ANYWHERE) / len(STEPS)), ANYWHERE)[:, None]
        warmer_k = np.vstack((usual_k + STEPS[:, None] * step_k, np.zeros(count)))
        sd_k = np.vstack((np.tile(STEP_SD * step_k, (len(STEPS), 1)), np.full(count, ANYWHERE_K)))
        # each case of the prior, in place of the fingers' initial prior: temperature above ambient (c, m)
        self._case_information = sd_k**-2 - ANYWHERE_K**-2
        self._case_vector = warmer_k * sd_k**-2
        self._case_ln = np.log(share * ANYWHERE_K / sd_k) - 0.5 * (warmer_k / sd_k) ** 2

    def judge(self, touches: Sequence[TouchEvidence], *, compare: bool = True) -> Posterior:
        """Return the posterior from touches, assumed to be on one object; `compare` for the probability of that."""
        ln_likelihood, information, vector = self._gained(touches)
        share = _independent_share(information)
        ln_weight, mean, covariance = self._weigh(
            share * ln_likelihood.sum(axis=0), share * information.sum(axis=0), share * vector.sum(axis=0)
        )
        covariance[..., 0, 0] += sum(touch.common_k2 for touch in touches) / len(touches)
        weight = np.exp(ln_weight - ln_weight.max())
        weight /= weight.sum()
        middle = np.einsum("cm,cmi->i", weight, mean)
        away = mean - middle
        sd = np.sqrt(np.einsum("cm,cmi->i", weight, covariance[..., (0, 1), (0, 1)] + away * away))
        substance = weight.sum(axis=0)
        known = self._known.calibrated
        ambient_c = _ambient_c(touches)
        same_object = 1.0
        if compare and len(touches) > 1:
            alone = self._weigh(share * ln_likelihood, share * information, share * vector)[0]
            same_object = _same_object(_ln_sum(ln_weight) - sum(_ln_sum(each) for each in alone))
        return Posterior(
            probability=substance[:known],
            foreign=float(substance[known:].sum()),
            object_c=ambient_c + float(middle[0]),
            object_c_sd=float(sd[0]),
            ln_effusivity=float(middle[1]),
            ln_effusivity_sd=float(sd[1]),
            no_difference=_no_difference(touches, weight, mean[..., 0], covariance[..., 0, 0]),
            misfit=max(touch.misfit for touch in touches),
            same_object=same_object,
        )

    def beside(self, touch: TouchEvidence) -> TouchEvidence:
        """Convert evidence of a sensor of another kind on the same object, for `judge`.

        Each sensor measures effusivity over its own plate's heat capacity; only material and temperature are shared.
        """
        covariance = np.zeros_like(touch.covariance)
        covariance[:, 0, 0] = touch.covariance[:, 0, 0]
        covariance[:, 1, 1] = self._known.effusivity_variance
        mean = np.stack((touch.mean[:, 0], self._known.ln_effusivity), axis=1)
        return replace(touch, mean=mean, covariance=covariance)

    def _weigh(self, ln_likelihood: Array, information: Array, vector: Array) -> tuple[Array, Array, Array]:
        """Combine evidence on (temperature, ln effusivity) with the prior.

        Args:
            ln_likelihood: (..., m) ln likelihood of each substance; see `_gained`.
            information: (..., m, 2, 2) information matrices beyond the prior's.
            vector: (..., m, 2) information vectors beyond the prior's.

        Returns:
            Ln weights (..., c, m), means (..., c, m, 2) and covariances (..., c, m, 2, 2) for each case of the prior.
        """
        shape = (*ln_likelihood.shape[:-1], *self._case_ln.shape)
        more, push = np.empty((*shape, 2, 2)), np.empty((*shape, 2))
        more[...] = (self._prior.information + information)[..., None, :, :, :]
        push[...] = (self._prior.vector + vector)[..., None, :, :]
        more[..., 0, 0] += self._case_information
        push[..., 0] += self._case_vector
        covariance = _inverse(more)
        middle = _times(covariance, push)
        total = (self._ln_prior + ln_likelihood - self._prior.integral)[..., None, :] + self._case_ln
        return total + _integral(more, push, middle), middle, covariance

    def _gained(self, touches: Sequence[TouchEvidence]) -> tuple[Array, Array, Array]:
        """Return what each touch adds to the prior of (temperature, ln effusivity), for each substance.

        Distant hypotheses drawn together can be wider than the prior; then they add nothing. The effusivity of a touch
        differs from that of the piece by the finger's own error. The fingers' ambient temperatures may differ.

        Returns:
            Ln likelihoods (t, m), information (t, m, 2, 2) and vectors (t, m, 2).
        """
        prior = self._finger_prior
        mean = np.array([touch.mean for touch in touches])
        gained = _inverse(np.array([touch.covariance for touch in touches])) - prior.information
        lost = (_determinant(gained) < 0.0) | (gained[..., 0, 0] < 0.0) | (gained[..., 1, 1] < 0.0)
        if lost.any():
            values, axes = np.linalg.eigh(gained[lost])
            gained[lost] = np.einsum("mij,mj,mkj->mik", axes, np.maximum(values, 0.0), axes)
        both = prior.information + gained
        along = _times(both, mean)
        ln_likelihood = np.array([touch.ln_likelihood for touch in touches])
        ln_likelihood += prior.integral - _integral(both, along, mean)
        vector = along - prior.vector
        row, at = gained[..., 1], vector[..., 1]
        less = 1.0 + self._own_variance * row[..., 1]
        share = self._own_variance / less
        ln_likelihood += 0.5 * (share * at * at - np.log(less))
        vector -= (share * at)[..., None] * row
        gained -= share[..., None, None] * row[..., None] * row[..., None, :]
        # From here on, temperatures are relative to the mean of what the fingers' thermometers call ambient.
        higher_k = np.array([[touch.ambient_c] for touch in touches]) - _ambient_c(touches)
        ln_likelihood -= higher_k * (vector[..., 0] + 0.5 * higher_k * gained[..., 0, 0])
        vector += higher_k[..., None] * gained[..., 0]
        return ln_likelihood, gained, vector


def _independent_share(information: Array) -> float:
    """Return the share of the fingers' information that counts, because they have SHARED_ERROR in common.

    Errors e_i with variances 1 / g_i and this correlation give their weighted mean a variance of
    (1 + SHARED_ERROR ((sum sqrt(g_i))^2 - sum g_i) / sum g_i) / sum g_i. A finger that knows nothing changes nothing.

    Args:
        information: (t, m, 2, 2) information of each finger; its largest one on temperature counts.
    """
    known = information[..., 0, 0].max(axis=1)
    whole = float(known.sum())
    if whole <= 0.0:
        return 1.0
    return 1.0 / (1.0 + SHARED_ERROR * (float(np.sqrt(known).sum()) ** 2 - whole) / whole)


def _ambient_c(touches: Sequence[TouchEvidence]) -> float:
    return sum(touch.ambient_c for touch in touches) / len(touches)


def _ln_sum(ln_weight: Array) -> float:
    top = float(ln_weight.max())
    return top + float(np.log(np.exp(ln_weight - top).sum()))


def _same_object(ln_odds: float) -> float:
    """Return the probability of one object, from ln(probability of the readings with one object / with one each)."""
    odds = np.log(SAME_OBJECT / (1.0 - SAME_OBJECT)) + ln_odds
    return float(expit(odds))


def _no_difference(touches: Sequence[TouchEvidence], weight: Array, mean_k: Array, variance: Array) -> float:
    """Return the probability that even the plate farthest from the object has the object's temperature."""
    ambient_c = _ambient_c(touches)
    middle_k = float((weight * mean_k).sum())
    start_k = max((touch.start_c - ambient_c for touch in touches), key=lambda k: abs(k - middle_k))
    sd = np.sqrt(variance)
    near = ndtr((start_k + SMALLEST_DIFFERENCE_K - mean_k) / sd) - ndtr((start_k - SMALLEST_DIFFERENCE_K - mean_k) / sd)
    return float((weight * near).sum())


def _integral(information: Array, vector: Array, mean: Array) -> Array:
    """Return ln of the integral of exp(-s' information s / 2 + vector' s), up to a constant that always cancels."""
    return np.asarray(0.5 * (vector * mean).sum(axis=-1) - 0.5 * np.log(_determinant(information)))


def _determinant(matrix: Array) -> Array:
    return np.asarray(matrix[..., 0, 0] * matrix[..., 1, 1] - matrix[..., 0, 1] * matrix[..., 1, 0])


def _inverse(matrix: Array) -> Array:
    """Invert symmetric 2 x 2 matrices (..., 2, 2), several times faster than the general method."""
    found = np.empty_like(matrix)
    found[..., 0, 0], found[..., 1, 1] = matrix[..., 1, 1], matrix[..., 0, 0]
    found[..., 0, 1] = found[..., 1, 0] = -matrix[..., 0, 1]
    return np.asarray(found / _determinant(matrix)[..., None, None])


def _times(matrix: Array, vector: Array) -> Array:
    """Multiply matrices (..., 2, 2) by vectors (..., 2)."""
    return np.asarray(matrix[..., 0] * vector[..., :1] + matrix[..., 1] * vector[..., 1:])
