"""Interpolates the logarithm of stiffness by a Gaussian process whose uncertainty grows away from measured places.

The field is a constant, plus a wide component (the ground: thickness, support, organ), plus a narrow component (the
excess: lumps). Both components have a Matern kernel of order 3/2 (Rasmussen and Williams 2006, eq. 4.17) and the same
standard deviation. This deviation, and the scatter of a press, are those of the largest posterior density on a grid.
"""

import math
from collections.abc import Iterator, Sequence
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.cluster.hierarchy import fcluster, linkage
from scipy.linalg import cho_solve, solve_triangular
from scipy.spatial.distance import cdist

Floats = NDArray[np.float64]
NARROW_M = 7e-3
"""Length of the narrow component, m: a lump of some millimetres, widened by tissue and by the finger."""
WIDE_M = 40e-3
"""Length of the wide component, m."""
CONSTANT_SD = 2.0
"""Standard deviation of the field's constant from the median of the places, natural logarithm."""
FIELD_SD = (0.1, 0.2, 0.4, 0.8)
"""Standard deviations of each component to choose from, natural logarithm."""
PRESS_SD = (0.02, 0.05, 0.1)
"""Scatter of a press beyond its stated variance to choose from, natural logarithm."""
EXPECTED_FIELD_SD, EXPECTED_PRESS_SD = 0.2, 0.03
"""Medians of the prior of both standard deviations."""
PRIOR_LN_SD = 1.5
"""Standard deviation of the natural logarithm of both in the prior."""
MOST_PLACES = 256
"""Maximum number of places of a field; near and equally stiff ones are merged until this number holds."""
MOST_CLUSTERED = 1024
"""Maximum number of places that are searched for equally stiff ones; of more, near ones are merged first."""
MOST_FITTED = 96
"""Maximum number of places that choose the standard deviations."""
_MERGED_M = 1e-3
"""Side of the squares in which places are merged first, m."""


class Estimate(NamedTuple):
    """Means and standard deviations at some places, natural logarithm of N/m or of a ratio, (n,) each."""

    mean: Floats
    sd: Floats


class StiffnessField:
    """Field of ln stiffness.

    Attributes:
        places_m: merged places, (n, 2), m.
        value, variance: ln stiffness at these places, N/m, and its variance, (n,).
        field_sd: standard deviation of each component, natural logarithm.
        press_sd: scatter of a press beyond its stated variance, natural logarithm.
    """

    def __init__(self, places_m: ArrayLike, ln_stiffness: ArrayLike, variance: ArrayLike) -> None:
        """Make the field of some presses.

        Args:
            places_m: places, (n, 2), m.
            ln_stiffness: natural logarithms of the stiffness in N/m, (n,).
            variance: their variances, (n,), above 0.

        Raises:
            ValueError: there is no place, or a number is not finite.
        """
        every = np.column_stack([np.asarray(places_m, dtype=np.float64).reshape(-1, 2), ln_stiffness, variance])
        if not len(every) or not np.isfinite(every).all() or (every[:, 3] <= 0.0).any():
            raise ValueError("a field of stiffness needs places with finite values and variances above 0")
        merged = _merged(every)
        self.places_m, self.value, self.variance = merged[:, :2], merged[:, 2], merged[:, 3]
        self._centre = float(np.median(self.value))
        some = np.unique(np.linspace(0, len(merged) - 1, min(len(merged), MOST_FITTED)).round().astype(int))
        self.field_sd, self.press_sd = _fitted(merged[some])
        covariance = self.field_sd**2 * correlation(cdist(self.places_m, self.places_m)) + CONSTANT_SD**2
        covariance[np.diag_indices(len(merged))] += self.variance + self.press_sd**2
        lower = np.linalg.cholesky(covariance)
        self._inverse: Floats = solve_triangular(lower, np.eye(len(merged)), lower=True)
        """Inverse of the Cholesky factor: many places are estimated by products with it."""
        self._weights: Floats = self._inverse.T @ (self._inverse @ (self.value - self._centre))

    def at(self, places_m: ArrayLike) -> Estimate:
        """Return ln stiffness at some places, (n, 2), m; the deviation is that of the tissue and not of a new press."""
        covariance = self.field_sd**2 * correlation(self._far(places_m)) + CONSTANT_SD**2
        return self._estimate(covariance, 2.0 * self.field_sd**2 + CONSTANT_SD**2, self._centre)

    def excess(self, places_m: ArrayLike) -> Estimate:
        """Return the narrow component at some places, (n, 2), m: ln of the ratio to the ground around."""
        covariance = self.field_sd**2 * matern(self._far(places_m), NARROW_M)
        return self._estimate(covariance, self.field_sd**2, 0.0)

    def nearest_m(self, places_m: ArrayLike) -> Floats:
        """Return the distance of each place, (n, 2), m, from the nearest measured one, (n,), m."""
        nearest: Floats = self._far(places_m).min(axis=1)
        return nearest

    def _far(self, places_m: ArrayLike) -> Floats:
        return np.asarray(cdist(np.asarray(places_m, dtype=np.float64), self.places_m))

    def _half(self, covariance: Floats) -> Floats:
        return np.asarray(self._inverse @ covariance.T)

    def _estimate(self, covariance: Floats, prior: float, centre: float) -> Estimate:
        left = prior - np.square(self._half(covariance)).sum(axis=0)
        return Estimate(centre + covariance @ self._weights, np.sqrt(np.maximum(left, 1e-8 * prior)))


def matern(far_m: Floats, length_m: float) -> Floats:
    """Return the Matern correlation of order 3/2 at distances, m."""
    scaled = math.sqrt(3.0) / length_m * far_m
    return np.asarray((1.0 + scaled) * np.exp(-scaled))


def correlation(far_m: Floats) -> Floats:
    """Return the correlation of both components together at distances, m."""
    return matern(far_m, NARROW_M) + matern(far_m, WIDE_M)


def factors(correlations: Floats, variance: Floats) -> Iterator[tuple[tuple[float, float], Floats, float]]:
    """Yield each pair of standard deviations, of field and press, to choose from.

    With it come the lower Cholesky factor of the presses' covariance, and the part of the ln posterior density that
    does not depend on their values.
    """
    for field_sd, press_sd in product(FIELD_SD, PRESS_SD):
        covariance = field_sd**2 * correlations + CONSTANT_SD**2
        covariance[np.diag_indices(len(variance))] += variance + press_sd**2
        lower = np.asarray(np.linalg.cholesky(covariance), dtype=np.float64)
        from_prior = math.log(field_sd / EXPECTED_FIELD_SD) ** 2 + math.log(press_sd / EXPECTED_PRESS_SD) ** 2
        yield (field_sd, press_sd), lower, float(-np.log(np.diag(lower)).sum() - 0.5 * from_prior / PRIOR_LN_SD**2)


def _fitted(rows: Floats) -> tuple[float, float]:
    """Return the standard deviations of field and press of the largest posterior density."""
    off = rows[:, 2] - np.median(rows[:, 2])
    best, found = -math.inf, (EXPECTED_FIELD_SD, EXPECTED_PRESS_SD)
    for pair, lower, ln_rest in factors(correlation(cdist(rows[:, :2], rows[:, :2])), rows[:, 3]):
        density = ln_rest - 0.5 * off @ cho_solve((lower, True), off)
        if density > best:
            best, found = density, pair
    return found


def _merged(rows: Floats) -> Floats:
    """Return rows x, y, value, variance, at most MOST_PLACES: one for each square with places, then for alike ones."""
    side_m = _MERGED_M
    while True:
        _, square = np.unique(np.floor(rows[:, :2] / side_m).astype(np.int64), axis=0, return_inverse=True)
        if square.max() < MOST_CLUSTERED:
            break
        side_m *= 1.25
    places = _mean_rows(rows, square.ravel())
    if len(places) <= MOST_PLACES:
        return places
    # Ward's clusters join places that are near and equally stiff, so that the edges of lumps remain.
    scaled = np.column_stack([places[:, :2] / NARROW_M, places[:, 2] / FIELD_SD[0]])
    return _mean_rows(places, fcluster(linkage(scaled, "ward"), MOST_PLACES, "maxclust") - 1)


def _mean_rows(rows: Floats, group: NDArray[np.int64]) -> Floats:
    """Return the mean row of each group by precision; disagreement widens its variance (Birge 1932)."""
    precision = 1.0 / rows[:, 3]

    def sums(values: Floats) -> Floats:
        return np.asarray(np.bincount(group, weights=values), dtype=np.float64)

    whole = sums(precision)
    mean = np.column_stack([sums(precision * rows[:, column]) / whole for column in range(3)])
    chi2 = sums(precision * np.square(rows[:, 2] - mean[group, 2]))
    ratio = np.maximum(1.0, chi2 / np.maximum(np.bincount(group) - 1, 1))
    return np.column_stack([mean, ratio / whole])


def lattice(low_m: Sequence[float], high_m: Sequence[float], step_m: float) -> Floats:
    """Return the places of a square lattice that covers a rectangle, (n, 2), m; multiples of the step."""
    axes = [
        step_m * np.arange(math.floor(low / step_m), math.ceil(high / step_m) + 1)
        for low, high in zip(low_m, high_m, strict=True)
    ]
    return np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
