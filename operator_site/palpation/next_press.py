"""Chooses where to press next: the place that is expected to separate nodules best from places without one.

A typical nodule at a place changes the presses around it. A new press adds to the evidence for this nodule: the square
of the change that the presses before do not predict, over the variance that they leave open. The choice maximises the
sum over many places of a nodule. Each place counts by how undecided it is:

- Nodules and other places have equal likelihood ratios slightly above 1, so that their ranks change most there.
- The outline of a nodule that was found is open where it is as likely beneath a place as not.

Expected information would count other places most: those whose probability is open, although their rank is decided.
"""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from operator_site.palpation.nodule_search import NoduleSearch

Floats = NDArray[np.float64]
FLOOR = 0.1
"""Weight of a decided place; an undecided one has up to 1 more."""
UNDECIDED, UNDECIDED_SD = 0.7, 1.2
"""Middle and width of the undecided natural logarithms of the likelihood ratio."""
MOST_CANDIDATES = 400
"""Maximum number of candidates."""
MOST_SITES = 170
"""Maximum number of places of a nodule."""
_CANDIDATE_M, _SITE_M = 2e-3, 4.5e-3
_INSET_M = 4e-3
"""Least distance of a nodule's middle from the edge of the rectangle, m: half of a usual diameter."""


def next_presses(search: NoduleSearch, low_m: ArrayLike, high_m: ArrayLike, number: int = 1) -> Floats:
    """Return the next places in a rectangle, (number, 2), m, the most informative first.

    Each is chosen as if the ones before had been pressed, so that several fingers can share them.

    Args:
        search: the search in the presses so far.
        low_m, high_m: near left and far right corner of the rectangle, (2,), m.
        number: number of places.
    """
    low, high = np.asarray(low_m, dtype=np.float64), np.asarray(high_m, dtype=np.float64)
    candidates = _lattice(low, high, _CANDIDATE_M, MOST_CANDIDATES)
    return candidates[best(search, candidates, number)]


def best(search: NoduleSearch, candidates_m: Floats, number: int = 1) -> list[int]:
    """Return the indices of the most informative candidates, (n, 2), m."""
    sites_m = _sites(candidates_m.min(axis=0), candidates_m.max(axis=0))
    weight = _undecided(search, sites_m)
    shares, whole, noise = search.ground.unpressed(candidates_m)
    change = search.typical_effect(sites_m, candidates_m)
    change -= search.typical_effect(sites_m, search.presses.places_m) @ shares
    count = len(candidates_m)
    numbers = np.arange(count)[:, None] + count * np.arange(len(noise))  # of each candidate
    chosen: list[int] = []
    for _ in range(min(number, count)):
        # The inverse of a root of the covariance makes the numbers of each candidate independent, with a variance of 1.
        seen = whole[numbers[:, :, None], numbers[:, None, :]] + np.diag(noise)
        root = np.linalg.inv(np.linalg.cholesky(seen))
        gain = weight @ np.square(np.einsum("cab,icb->ica", root, change[:, numbers])).sum(axis=2)
        gain[chosen] = -np.inf
        one = int(gain.argmax())
        chosen.append(one)
        learnt = root[one] @ whole[numbers[one]]
        change -= change[:, numbers[one]] @ root[one].T @ learnt
        whole -= learnt.T @ learnt
    return chosen


def _undecided(search: NoduleSearch, sites_m: Floats) -> Floats:
    """Return how much each place of a nodule counts, (n,)."""
    taken = search.taken(sites_m)
    rank = np.exp(-0.5 * ((search.ln_ratio(sites_m) - UNDECIDED) / UNDECIDED_SD) ** 2)
    return np.asarray(FLOOR + rank + 4.0 * taken * (1.0 - taken))


def _sites(low_m: Floats, high_m: Floats) -> Floats:
    """Return places of a nodule that lies within a rectangle, (n, 2), m."""
    inset_m = np.minimum(_INSET_M, 0.5 * (high_m - low_m))
    return _lattice(low_m + inset_m, high_m - inset_m, _SITE_M, MOST_SITES)


def _lattice(low_m: Floats, high_m: Floats, step_m: float, most: int) -> Floats:
    """Return a lattice of at most `most` places inside a rectangle; a line in the middle of a narrow one."""
    step_m = max(step_m, math.sqrt(float(np.prod(high_m - low_m)) / most))
    while True:
        axes = [_inside(low, high, step_m) for low, high in zip(low_m.tolist(), high_m.tolist(), strict=True)]
        if math.prod(map(len, axes)) <= most:
            return np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
        step_m *= 1.1


def _inside(low_m: float, high_m: float, step_m: float) -> Floats:
    """Return the multiples of a step from one place of an axis to another; the middle without one."""
    multiples = step_m * np.arange(math.floor(low_m / step_m), math.ceil(high_m / step_m) + 1)
    inside = multiples[(multiples >= low_m) & (multiples <= high_m)]
    return np.asarray(inside if len(inside) else [0.5 * (low_m + high_m)], dtype=np.float64)
