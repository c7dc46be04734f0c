"""Averages the answers about presses over several priors of the force law (Bayesian model averaging).

The fits of all priors follow the samples, and their stiffnesses differ. All presses of an object share this error,
so that it does not become smaller with their number, and does not differ between them. The average has the smallest
expected error, and the differences from it are a part of the standard deviation.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from remote_site.stiffness.force_law import PARAMETERS, depth_at
from remote_site.stiffness.press_population import Fits

Array = NDArray[np.float64]

MOST_LN_ODDS = 50.0
"""Largest ln of the odds of a prior against the general one."""
LAW_SHARE = 0.005
"""Error of the stiffness that the laws have in common, as a fraction of it."""
_STEP = 1e-5


class OtherFits(NamedTuple):
    """Fits with another prior, the presses that it may hold for, (n,), and its odds against the general prior."""

    fits: Fits
    holds: NDArray[np.bool_]
    odds: float


class Stated(NamedTuple):
    """Answers about n presses: ln stiffness, N/m, exponent, and depth of contact, mm.

    Attributes:
        values: the answers, (n, 3).
        repeat_sd: standard deviations of what differs between presses of one object, (n, 3).
        sd: standard deviations of the whole errors, (n, 3).
    """

    values: Array
    repeat_sd: Array
    sd: Array


def averaged(general: Fits, others: Sequence[OtherFits], at_n: float) -> Stated:
    """Return the answers at a force, N, averaged over the general prior and others.

    The evidence of a prior counts as that of one press, because the presses share the error of a law.

    Args:
        general: fits of all presses with the general prior.
        others: fits of some of the presses with each other prior.
        at_n: force at which the stiffness is stated, N.
    """
    values, repeat, own = _stated(general, at_n)
    odds = np.zeros((len(others), len(values), 1))
    away = np.zeros((len(others), *values.shape))
    common = np.zeros_like(away)
    for k, (fits, holds, before) in enumerate(others):
        away[k, holds] = _stated(fits, at_n)[0] - values[holds]
        common[k, holds] = away[k, holds].mean(axis=0)
        ln_odds = float((fits.evidence - general.evidence[holds]).mean())
        odds[k, holds] = before * np.exp(min(MOST_LN_ODDS, ln_odds))
    share = odds / (1.0 + odds.sum(axis=0))
    shift = (share * common).sum(axis=0)
    between = (share * (away - shift) ** 2).sum(axis=0) + (1.0 - share.sum(axis=0)) * shift**2
    between[:, 0] += LAW_SHARE**2
    return Stated(values + shift, repeat, np.sqrt(own**2 + between))


def _stated(fits: Fits, at_n: float) -> Stated:
    """Return the answers of one prior, and their standard deviations by noise, places, and the mean of all presses."""

    def state(parameters: Array) -> Array:
        u, exponent = depth_at(parameters, at_n)
        ln_n_m = np.log(1000.0 * at_n / (u * fits.unit_mm))
        return np.column_stack([ln_n_m, exponent, parameters[:, 3] * fits.unit_mm])

    values = state(fits.parameters)
    steps = _STEP * np.eye(PARAMETERS)
    by = np.stack([(state(fits.parameters + step) - values) / _STEP for step in steps], axis=-1)
    repeat_sd, sd = (
        fits.scale[:, np.newaxis] * np.sqrt(np.einsum("nki,nij,nkj->nk", by, covariance, by))
        for covariance in (fits.covariance, fits.covariance + fits.common)
    )
    return Stated(values, repeat_sd, sd)
