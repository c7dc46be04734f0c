"""Recognises the calibrated surface under a stroke with a recursive Bayesian filter along the path.

One mechanism recognises a surface, forgets it and detects a change. Each measurement multiplies the probabilities, and
with every millimetre the surface may have become another one. Measurements are the power of the curvature and the gaps
between grooves, including the present gap that has not ended.
"""

import math

import numpy as np
from numpy.typing import NDArray

from remote_site.texture.roughness import FREEDOMS_PER_M
from remote_site.texture.surface_table import Surface, SurfaceTable

Array = NDArray[np.float64]

CHANGES_PER_M = 2.0
"""Rate at which a stroke reaches another surface, 1/m."""
INVENTED_PER_M = 1.0
"""Rate of impulses on a surface without grooves, such as edges and scratches, 1/m."""
OUTLIER = 0.05
"""Fraction of gaps outside of the pattern: a missed, a false or a worn groove."""
RULED_OUT = 0.01
"""Probability below which a surface and its gap restart anywhere in the pattern, since it can only have just begun."""
SURE = 0.95
"""Minimum probability of a recognised surface."""
_GRID_M = 0.1e-3
_LONGEST_M = 40e-3
_LAST = round(_LONGEST_M / _GRID_M)


class SurfaceFilter:
    """Probabilities of the calibrated surfaces.

    Attributes:
        probabilities: of the table's surfaces, in its order; they add up to one.
    """

    def __init__(self, table: SurfaceTable) -> None:
        self._table = table
        self._each = np.arange(len(table.surfaces))
        self._power = np.array([math.exp(2.0 * surface.ln_roughness) for surface in table.surfaces])
        self._sd = np.array([2.0 * surface.ln_roughness_sd for surface in table.surfaces])
        laws = [_gaps(surface) for surface in table.surfaces]
        # [0] from anywhere, [1] from a groove: ln density of the next groove, ln probability of none until now
        self._log_density = np.array([[law[known][0] for law in laws] for known in (0, 1)])
        self._log_survival = np.array([[law[known][1] for law in laws] for known in (0, 1)])
        self.forget()

    def forget(self) -> None:
        """Give all surfaces the same probability."""
        count = len(self._table.surfaces)
        self.probabilities: Array = np.full(count, 1.0 / count)
        self.interrupt()

    def interrupt(self) -> None:
        """Interrupt the path; the distance from the last groove becomes unknown."""
        self._gap = np.zeros(len(self.probabilities), dtype=np.intp)
        self._known = np.zeros(len(self.probabilities), dtype=np.intp)

    @property
    def best(self) -> Surface:
        """The likeliest surface."""
        return self._table.surfaces[int(self.probabilities.argmax())]

    @property
    def sure(self) -> Surface | None:
        """The surface whose probability is at least SURE; None without one."""
        return self.best if float(self.probabilities.max()) >= SURE else None

    def move(self, way_m: float) -> None:
        """Take another `way_m`, m > 0, without a groove."""
        count = len(self.probabilities)
        if count > 1:
            leaves = 1.0 - math.exp(-CHANGES_PER_M * way_m)
            self.probabilities += leaves * ((1.0 - self.probabilities) / (count - 1) - self.probabilities)
        before = self._gap
        self._gap = _within(before + round(way_m / _GRID_M))
        survival = self._log_survival
        self._weigh(survival[self._known, self._each, self._gap] - survival[self._known, self._each, before])
        out = self.probabilities < RULED_OUT
        out &= survival[self._known, self._each, self._gap] < math.log(RULED_OUT)
        self._gap[out] = self._known[out] = 0

    def groove(self, beyond_m: float = 0.0) -> None:
        """Take a groove, `beyond_m`, m, ahead of the path moved; negative if it lies behind."""
        beyond = round(beyond_m / _GRID_M)
        density = self._log_density[self._known, self._each, _within(self._gap + beyond)]
        self._weigh(density - self._log_survival[self._known, self._each, self._gap])
        self._gap = np.full_like(self._gap, max(-beyond, 0))
        self._known = np.ones_like(self._known)

    def roughness(self, power: float, noise: float, way_m: float) -> None:
        """Take the mean power of the curvature for one newton over `way_m`, m, with its noise power, both in V^2."""
        expected = self._power + noise
        # the expected logarithm of a mean of squares lies below the logarithm of its expectation
        freedoms = FREEDOMS_PER_M * way_m
        variance = (self._sd * self._power / expected) ** 2 + 2.0 / freedoms
        miss = math.log(max(power, 1e-14)) + 1.0 / freedoms - np.log(expected)
        self._weigh(-0.5 * (miss * miss / variance + np.log(variance)))

    def _weigh(self, log_likelihood: Array) -> None:
        weighed = self.probabilities * np.exp(log_likelihood - log_likelihood.max())
        self.probabilities = np.maximum(weighed / weighed.sum(), 1e-9)


def _within(gaps: NDArray[np.intp]) -> NDArray[np.intp]:
    """Limit gaps to the grid."""
    return np.minimum(np.maximum(gaps, 0), _LAST)


def _gaps(surface: Surface) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """Return ln density and ln survival of the distance to the next groove, from anywhere and from a groove."""
    way: Array = _GRID_M * np.arange(_LAST + 1, dtype=np.float64)
    if surface.period_mm is None:
        rare: tuple[Array, Array] = (np.full_like(way, math.log(INVENTED_PER_M)), -INVENTED_PER_M * way)
        return rare, rare
    period = 1e-3 * surface.period_mm
    sd = math.hypot(surface.irregularity * period, 0.04 * period, 0.1e-3)
    pattern = np.exp(-0.5 * ((way - period) / sd) ** 2)
    pattern /= pattern.sum() * _GRID_M
    other = np.exp(-way / (2.0 * period))
    other /= other.sum() * _GRID_M
    density = (1.0 - OUTLIER) * pattern + OUTLIER * other
    survival = _beyond(density)
    anywhere = survival / (survival.sum() * _GRID_M)
    groove: tuple[Array, Array] = (np.log(density), np.log(survival))
    other_place: tuple[Array, Array] = (np.log(anywhere), np.log(_beyond(anywhere)))
    return other_place, groove


def _beyond(density: Array) -> Array:
    """Return the probability of a distance at least this long."""
    beyond: Array = np.cumsum(density[::-1])[::-1] * _GRID_M
    return beyond
