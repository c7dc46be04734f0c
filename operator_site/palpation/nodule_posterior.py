"""Computes the posterior of one nodule near a place: position, depth, diameter, stiffness ratio, and if there is one.

The data are ln stiffness at places. Without a nodule they vary as the ground does, by a Gaussian process. A nodule adds
the lift of `inclusion_model`. The posterior is a sum over a grid, so that its probabilities need no approximation, and
its cost is bounded by the grid and by MOST_PLACES.

One stiffness per place cannot separate depth, diameter and stiffness ratio: a deep, large nodule lifts like a shallow,
small and soft one. `Quantity.known` states what the data determine.
"""

import math
from dataclasses import dataclass
from functools import lru_cache
from itertools import product

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.linalg import cho_factor, solve_triangular
from scipy.spatial.distance import cdist
from scipy.special import logsumexp

from operator_site.palpation.inclusion_model import contact_radius_m, energy_share, ln_lift
from operator_site.palpation.stiffness_field import CONSTANT_SD, NARROW_M, WIDE_M, matern

Floats = NDArray[np.float64]
TOPS_M = tuple(np.geomspace(1e-3, 20e-3, 9).tolist())
"""Depths of a nodule's upper pole in the prior, m; equally probable."""
DIAMETERS_M = tuple(np.geomspace(4e-3, 20e-3, 7).tolist())
"""Diameters of a nodule in the prior, m; equally probable."""
RATIOS = tuple(np.geomspace(1.3, 20.0, 7).tolist())
"""Stiffness ratios of a nodule to its surroundings in the prior; equally probable."""
NODULE = 0.05
"""Prior probability of a nodule around a place."""
AROUND_M, STEP_M = 8e-3, 2e-3
"""Half the side of the square that can hold a nodule's middle, and the step in it, m."""
WITHIN_M = 25e-3
"""Largest distance of the used places from the middle of the square, m."""
MOST_PLACES = 80
"""Maximum number of used places."""
WIDE_SD = 0.2
"""Standard deviation of the ground's wide component, natural logarithm."""
DISCREPANCY = 0.15
"""Standard deviation of the model's error as a share of the excess."""
KNOWN_SHARE = 0.5
"""Largest deviation of a known quantity as a share of its deviation in the prior."""
MOST_AT_END = 0.2
"""Largest probability of the prior's first or last value for a known quantity; at an end the model does not fit."""
_OFFSETS_M = np.arange(0.0, WITHIN_M + 2.0 * AROUND_M, 0.5e-3)


@dataclass(frozen=True, slots=True)
class Quantity:
    """Posterior of a positive quantity.

    Attributes:
        middle: exponential of the mean logarithm, in the quantity's unit.
        ln_sd: standard deviation of the natural logarithm.
        low, high: ends of the interval that holds the quantity with 90 %, within the range of the prior.
        known: whether the deviation is at most KNOWN_SHARE of the prior's, and the prior's ends hold little.
    """

    middle: float
    ln_sd: float
    low: float
    high: float
    known: bool


@dataclass(frozen=True, slots=True)
class Nodule:
    """Posterior of a nodule.

    Attributes:
        probability: probability that there is a nodule, 0..1.
        x_m, y_m: mean position, m.
        place_sd_m: standard deviation of the position along an axis, m.
        top: depth of the upper pole, m.
        diameter: diameter, m.
        ratio: stiffness ratio to the surroundings.
        large: probability that the diameter is above the middle of the prior, 0..1.
    """

    probability: float
    x_m: float
    y_m: float
    place_sd_m: float
    top: Quantity
    diameter: Quantity
    ratio: Quantity
    large: float


@dataclass(frozen=True, slots=True)
class Presses:
    """Presses around a place, in arrays of one length.

    Attributes:
        places_m: places, (n, 2), m.
        ln_stiffness: ln stiffness, N/m, (n,).
        variance: its variance, (n,).
        indentation_m: indentation at which the stiffness holds, (n,), m; two at a place help with the depth.
    """

    places_m: Floats
    ln_stiffness: Floats
    variance: Floats
    indentation_m: Floats


def nodule(presses: Presses, middle_m: ArrayLike, spread: float, probe_radius_m: float) -> Nodule | None:
    """Return the posterior of a nodule around a place; None with fewer than four presses near.

    Args:
        presses: the presses.
        middle_m: middle of the square in which a nodule is searched, (2,), m.
        spread: natural spread of the ground, natural logarithm, such as `LumpMap.spread`.
        probe_radius_m: radius of the probe or fingertip, m.
    """
    middle = np.asarray(middle_m, dtype=np.float64)
    away = np.hypot(*(presses.places_m - middle).T)
    near = np.argsort(away, kind="stable")[:MOST_PLACES]
    near = near[away[near] <= WITHIN_M]
    if len(near) < 4:
        return None
    axis = np.arange(-AROUND_M, AROUND_M + 0.5 * STEP_M, STEP_M)
    positions = middle + np.array(list(product(axis, axis)))
    lifts = _lifts(presses.indentation_m[near], cdist(positions, presses.places_m[near]), probe_radius_m)
    ln_odds = _ln_likelihood_ratio(presses, near, spread, lifts.reshape(-1, len(near))).reshape(lifts.shape[:-1])
    evidence = float(logsumexp(ln_odds) - math.log(ln_odds.size))
    odds = NODULE / (1.0 - NODULE) * math.exp(min(evidence, 500.0))
    weight = np.exp(ln_odds - logsumexp(ln_odds))
    by_place = weight.sum(axis=(1, 2, 3))
    place = by_place @ positions
    variance = by_place @ np.square(positions - place).sum(axis=1) / 2.0 + STEP_M**2 / 12.0
    by_diameter = weight.sum(axis=(0, 1, 3))
    return Nodule(
        odds / (1.0 + odds),
        float(place[0]),
        float(place[1]),
        math.sqrt(float(variance)),
        _quantity(TOPS_M, weight.sum(axis=(0, 2, 3))),
        _quantity(DIAMETERS_M, by_diameter),
        _quantity(RATIOS, weight.sum(axis=(0, 1, 2))),
        float(by_diameter[(len(DIAMETERS_M) + 1) // 2 :].sum() + 0.5 * by_diameter[len(DIAMETERS_M) // 2]),
    )


def _lifts(indentation_m: Floats, away_m: Floats, probe_radius_m: float) -> Floats:
    """Return the lift of each hypothesis at each place, (positions, tops, diameters, ratios, places)."""
    lifts = np.zeros((len(away_m), len(TOPS_M), len(DIAMETERS_M), len(RATIOS), away_m.shape[1]))
    contact_um = np.round([1e6 * contact_radius_m(probe_radius_m, one) for one in indentation_m], -2).astype(int)
    for contact in np.unique(contact_um):
        table = _table(1e-6 * float(contact))
        mine = np.flatnonzero(contact_um == contact)
        at = np.clip(away_m[:, mine] / (_OFFSETS_M[1] - _OFFSETS_M[0]), 0.0, len(_OFFSETS_M) - 1.001)
        low = at.astype(int)
        part = at - low
        found = table[..., low] * (1.0 - part) + table[..., low + 1] * part
        lifts[..., mine] = np.moveaxis(found, 3, 0)
    return lifts


@lru_cache(maxsize=64)
def _table(contact_m: float) -> Floats:
    """Return the lift of each hypothesis at each of the offsets, (tops, diameters, ratios, offsets)."""
    shares = [[energy_share(_OFFSETS_M, top, 0.5 * size, contact_m) for size in DIAMETERS_M] for top in TOPS_M]
    return ln_lift(np.array(shares)[:, :, None, :], np.array(RATIOS)[:, None])


def _ln_likelihood_ratio(presses: Presses, near: NDArray[np.intp], spread: float, lifts: Floats) -> Floats:
    """Return ln of the likelihood of each row of lifts, relative to no nodule."""
    far_m = cdist(presses.places_m[near], presses.places_m[near])
    covariance = spread**2 * matern(far_m, NARROW_M) + WIDE_SD**2 * matern(far_m, WIDE_M) + CONSTANT_SD**2
    off = presses.ln_stiffness[near] - np.median(presses.ln_stiffness[near])
    covariance[np.diag_indices(len(near))] += presses.variance[near] + (DISCREPANCY * np.maximum(off, 0.0)) ** 2
    lower = cho_factor(covariance, lower=True)[0]
    seen = solve_triangular(lower, off, lower=True)
    expected = solve_triangular(lower, lifts.T, lower=True, check_finite=False)
    return np.asarray(seen @ expected - 0.5 * np.square(expected).sum(axis=0))


def _quantity(values: tuple[float, ...], weight: Floats) -> Quantity:
    ln = np.log(values)
    mean = float(weight @ ln)
    step = float(ln[1] - ln[0])
    sd = math.sqrt(float(weight @ np.square(ln - mean)) + step**2 / 12.0)
    edges = np.concatenate([ln - 0.5 * step, [ln[-1] + 0.5 * step]])
    low, high = np.interp((0.05, 0.95), np.concatenate([[0.0], np.cumsum(weight)]), edges).clip(ln[0], ln[-1])
    prior = math.sqrt(float(np.var(ln)) + step**2 / 12.0)
    known = sd <= KNOWN_SHARE * prior and max(float(weight[0]), float(weight[-1])) <= MOST_AT_END
    return Quantity(math.exp(mean), sd, math.exp(float(low)), math.exp(float(high)), known)
