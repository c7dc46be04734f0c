"""Computes the probability that a place belongs to a lump, from a field of stiffness.

A place belongs to a lump where its excess over the ground is at least half of the largest excess nearby. Nearby is a
disc around the place, and a cord that lies across the disc does not lower its own excess: the ground is the wide
component of the field. The largest excess itself is a lump with the probability of Bayes' rule. Without a lump, the
excess has the natural spread of this ground, with the heavy tails of a Student distribution.

That excess shows lumps near the surface. A deeper one lifts the stiffness less than the ground varies, over a wider
area, and a search for nodules can find it. Where the search finds nothing, the excess counts by the square of its
probability, because a small one says hardly more than its prior. Where both find a lump, their doubts multiply.
"""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial.distance import cdist
from scipy.special import ndtr

from operator_site.palpation.nodule_search import DIAMETERS_M, REACH_M, NoduleSearch, PressNumbers, one_stiffness
from operator_site.palpation.stiffness_field import StiffnessField, lattice

Floats = NDArray[np.float64]
LUMP_SHARE = 0.08
"""Prior probability that the largest excess nearby is a lump."""
LUMP_LN = 0.5
"""Mean excess of a lump's middle in the prior, an exponential distribution of the natural logarithm of the ratio."""
UNKNOWN = 0.05
"""Probability of a place of which nothing is known."""
SEEN_M = REACH_M + 0.5 * math.sqrt(DIAMETERS_M[0] * DIAMETERS_M[-1])
"""Largest distance from a press at which a search knows something, m.

A searched nodule of middle size reaches as far. Gaps of a raster are nearer: their surroundings were searched.
"""
TAIL = 10.0
"""Degrees of freedom of the excess without a lump."""
PEAK_SHARE = 0.5
"""Share of the largest excess at which a lump ends."""
NEARBY_M = 12e-3
"""Radius in which the largest excess is searched, m."""
FEWEST_PLACES = 8
"""Smallest number of measured places with a probability; below it the spread of the ground is unknown."""
LEAST_SPREAD = 0.02
"""Smallest natural spread of the ground, natural logarithm."""
_FELT_M = 6e-3
"""Largest distance of a searched place from a measured one, m."""
_STEP_M = 2e-3
"""Step of the searched places of a small map, m."""
_MOST_SEARCHED = 600
"""Maximum number of searched places; a larger map has a wider step."""
_SIZES = np.linspace(0.05, 4.0, 80)
"""Excesses of a lump over which the prior is summed, natural logarithm of the ratio."""


class LumpMap:
    """Lump probabilities over a field.

    Attributes:
        spread: natural spread of the ground's excess, natural logarithm of the ratio.
        nodules: nodules of the search, in any order; empty without one.
    """

    def __init__(self, field: StiffnessField, search: NoduleSearch | None = None) -> None:
        """Search the field for its largest excesses.

        Args:
            field: the field.
            search: a search for nodules in the same presses; None: only lumps near the surface are found.

        Raises:
            ValueError: the field has fewer than FEWEST_PLACES places.
        """
        if len(field.places_m) < FEWEST_PLACES:
            raise ValueError(f"lump probabilities need {FEWEST_PLACES} places; there are {len(field.places_m)}")
        self._field, self._search = field, search
        self.nodules = () if search is None else tuple(search.nodules)
        searched_m = _searched(field)
        mean, sd = field.excess(searched_m)
        low, self._middle = (float(value) for value in np.quantile(mean, (0.16, 0.5)))
        self.spread = max(self._middle - low, LEAST_SPREAD)
        order = np.argsort(-mean)
        self._searched_m, self._excess = searched_m[order], mean[order] - self._middle
        self._lump = self._existence(self._excess, sd[order])
        if search is not None:
            self._lump *= 1.0 - (1.0 - self._lump) * (1.0 - search.probability(self._searched_m))

    def probability(self, places_m: ArrayLike) -> Floats:
        """Return the probability that each place, (n, 2), m, belongs to a lump, (n,), 0..1."""
        places = np.asarray(places_m, dtype=np.float64)
        mean, sd = self._field.excess(places)
        near = cdist(places, self._searched_m) <= NEARBY_M
        highest = near.argmax(axis=1)  # the first place nearby has the largest excess
        peak = self._excess[highest]
        inside = ndtr((mean - self._middle - PEAK_SHARE * peak) / sd)
        lump = np.where(near.any(axis=1) & (peak > 0.0), self._lump[highest], 0.0)
        unknown = (sd / self._field.field_sd) ** 4 * UNKNOWN
        if self._search is None:
            return np.asarray(np.maximum(lump * inside, unknown))
        found = lump * inside + (1.0 - lump) * self._search.probability(places)
        return np.asarray(np.where(self._field.nearest_m(places) <= SEEN_M, found, np.maximum(found, unknown)))

    def _existence(self, excess: Floats, sd: Floats) -> Floats:
        """Return the probability that an excess is a lump's; its prior in the field is divided out."""
        prior = self._field.field_sd**2
        variance = 1.0 / np.maximum(1.0 / sd**2 - 1.0 / prior, 1e-6 / prior)
        seen = excess * variance / sd**2
        weight = np.exp(-_SIZES / LUMP_LN)
        blurred = variance + (_SIZES[1] - _SIZES[0]) ** 2  # so that no excess falls between two sizes
        off = np.minimum(seen, _SIZES[-1])[:, None] - _SIZES
        lump = np.exp(-0.5 * off**2 / blurred[:, None]) @ (weight / weight.sum())
        lump *= LUMP_SHARE / np.sqrt(2.0 * math.pi * blurred)
        scale = np.sqrt(self.spread**2 + variance)
        norm = math.exp(math.lgamma(0.5 * (TAIL + 1.0)) - math.lgamma(0.5 * TAIL)) / math.sqrt(math.pi * TAIL)
        ground = norm / scale * (1.0 + np.maximum(seen, 0.0) ** 2 / (TAIL * scale**2)) ** (-0.5 * (TAIL + 1.0))
        found: Floats = lump / (lump + (1.0 - LUMP_SHARE) * ground)
        return found


def lumps_of_presses(presses: PressNumbers) -> LumpMap:
    """Return the lump probabilities of presses, with a search for nodules.

    The field is that of the number with the least noise, without disturbances.

    Raises:
        ValueError: there are fewer than FEWEST_PLACES places.
    """
    search = NoduleSearch(presses)
    best = int(np.median(presses.variance, axis=1).argmin())
    return LumpMap(StiffnessField(presses.places_m, search.steady[best], presses.variance[best]), search)


def lumps_of_field(field: StiffnessField) -> LumpMap:
    """Return the lump probabilities of a field, with a search for nodules.

    Raises:
        ValueError: the field has fewer than FEWEST_PLACES places.
    """
    return LumpMap(field, search_of_field(field))


def search_of_field(field: StiffnessField) -> NoduleSearch:
    """Return a search for nodules in the places of a field."""
    return NoduleSearch(one_stiffness(field.places_m, field.value, field.variance + field.press_sd**2))


def _searched(field: StiffnessField) -> Floats:
    """Return the places of a lattice near measured ones, (n, 2), m."""
    step_m = _STEP_M
    low, high = field.places_m.min(axis=0) - _FELT_M, field.places_m.max(axis=0) + _FELT_M
    while np.prod((high - low) / step_m + 2.0) > 8 * _MOST_SEARCHED:
        step_m *= 1.25
    while True:
        every = lattice(low.tolist(), high.tolist(), step_m)
        near = every[field.nearest_m(every) <= _FELT_M]
        if len(near) <= _MOST_SEARCHED:
            return np.concatenate([near, field.places_m])
        step_m *= 1.25
