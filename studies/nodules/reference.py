"""A reference that knows the generator: it compares simulated nodules with the presses by their likelihood.

Two numbers describe a press: the logarithm of its force in the first and in the last half of its depth. Ground that
varies, breathing and noise make them a Gaussian vector, whose few parameters are fitted to each phantom. A hypothesis
is a nodule of the generator at a place. Its effect on the numbers comes from the simulator itself, and its weight from
the ranges. The likeliest nodule is taken away before the next one is sought. Stated probabilities are corrected on
phantoms that are not judged.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import product

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import block_diag, cholesky, solve_triangular
from scipy.optimize import least_squares, minimize
from scipy.special import expit, logit, logsumexp

from sim_sensors.tissue.contrast import LARGEST_SHARE, Sphere, taken_share
from sim_sensors.tissue.ground import Ground
from studies.nodules.judge import Answer, FoundNodule, above_nodule, places_mm
from studies.nodules.phantoms import Phantom, Presses, distances_mm, grid_mm
from studies.nodules.ranges import CONTACT_N, DEPTH_STEPS, RANGES, STEP_S, Range

Floats = NDArray[np.float64]

CHANNELS = (slice(1, 4), slice(5, 8))
"""Readings of a press whose mean force makes each of its two numbers."""
SITE_MM = 3.5
"""Spacing of the places of hypotheses, mm."""
FINE_MM = 0.7
"""Spacing around a nodule that was found, mm."""
FINE_STEPS = 4
"""Places of this spacing on each side of it."""
MOST_NODULES = 3
SOUGHT_FROM = 3.0
"""Logarithm of the likelihood ratio at a place from which on a nodule is taken away there."""
GUESSES = 3
"""Places that are named beside, as nodules of low probability."""
GUESSED_APART_MM = 10.0
EXPECTED = 1.2
"""Expected number of nodules of a phantom."""
LAYER_MM = 40.0
"""Thickness of the layer in all hypotheses: the middle of its range."""
MISFIT = 0.022
"""Standard deviation of ln(force) that the hypotheses leave open."""
TYPICAL_SD = 0.06
"""Standard deviation of the ground while the rate of breathing is sought."""
LENGTHS_MM, GROUND_SDS, BREATH_SHARES = (11.0, 17.0, 26.0), (0.02, 0.05, 0.09, 0.14), (0.0, 0.05)
"""Grids of the ground's correlation length and standard deviation, and of the breathing left, steps of depth."""
RATES = 161
"""Rates of breathing that are tried."""
LEAST_N = 0.02
"""Smallest force whose logarithm is taken, N."""
_RADII_MM = np.geomspace(0.3, 8.0, 12)
_DISTANCES_MM = np.arange(0.0, 61.0)
_DEPTHS_MM = np.linspace(0.0, 10.0, 101)
_FINER = 2.0 * math.log(FINE_MM / SITE_MM)
"""Logarithm of the area of a fine place over that of a coarse one."""
_MIDDLE = 6.0
"""Stiffness ratio of the computed effect; others scale it."""


def _middles(limits: Range, count: int) -> Floats:
    """Return the middles of equal steps of the logarithm."""
    return np.asarray(np.exp(np.interp((np.arange(count) + 0.5) / count, [0.0, 1.0], np.log(limits))))


SIZES_MM = _middles(RANGES.size_mm, 5)
COVERS_MM = _middles(RANGES.depth_mm, 4)
RATIOS = _middles(RANGES.ratio, 6)
SHAPES = tuple(product(range(len(SIZES_MM)), range(len(COVERS_MM))))
"""Diameter and cover of all hypotheses, as numbers in SIZES_MM and COVERS_MM."""


@dataclass(frozen=True, slots=True)
class Reference:
    """The reference as a detector; `slope` and `offset` correct the logits of its probabilities."""

    slope: float = 1.0
    offset: float = 0.0

    def __call__(self, presses: Presses) -> Answer:
        """Return the answer about the presses on one phantom."""
        probability, found = _search(presses)
        return Answer(
            self._corrected(probability),
            tuple(
                FoundNodule(f.x_mm, f.y_mm, f.size_mm, float(self._corrected(np.array(f.probability)))) for f in found
            ),
        )

    def _corrected(self, probability: Floats) -> Floats:
        held = np.clip(probability, 1e-6, 1.0 - 1e-6)
        return np.asarray(expit(self.slope * logit(held) + self.offset))


def correction(examples: Sequence[tuple[Phantom, Answer]]) -> Reference:
    """Learn the correction of probabilities from answers of the uncorrected reference to phantoms not judged later."""
    places = places_mm()
    stated = logit(np.clip(np.concatenate([answer.probability for _, answer in examples]), 1e-6, 1.0 - 1e-6))
    true = np.concatenate([above_nodule(phantom, places) for phantom, _ in examples]).astype(float)

    def loss(by: Floats) -> float:
        wanted = by[0] * stated + by[1]
        return float(np.mean(np.logaddexp(0.0, wanted) - true * wanted))

    slope, offset = minimize(loss, np.array([1.0, 0.0]), method="Nelder-Mead").x
    return Reference(float(slope), float(offset))


@dataclass(frozen=True, slots=True)
class _Noise:
    """Covariance of the numbers of all presses.

    Attributes:
        root: its Cholesky factor.
        basis: orthonormal columns of whatever has any size: both levels and the breathing, whitened.
        likelihood: logarithm of the likelihood of the numbers.
    """

    root: Floats
    basis: Floats
    likelihood: float

    def whitened(self, numbers: Floats) -> Floats:
        """Return numbers of unit covariance, without levels and breathing; one row or many of numbers."""
        white = solve_triangular(self.root, numbers.T, lower=True)
        return np.asarray(white - self.basis @ (self.basis.T @ white))


@dataclass(frozen=True, slots=True)
class _Effects:
    """What hypotheses would change.

    Attributes:
        profiles: change of both numbers by the distance, (shapes, distances, 2), at the middle ratio.
        scales: factor of each ratio, (shapes, ratios).
    """

    profiles: Floats
    scales: Floats

    def at(self, sites: Floats, places: Floats, shape: int) -> Floats:
        """Return the change of all numbers by one shape at each site, (sites, 2 * presses)."""
        distance = distances_mm(sites, places)
        columns = [np.interp(distance, _DISTANCES_MM, self.profiles[shape, :, k]) for k in range(len(CHANNELS))]
        return np.concatenate(columns, axis=1)


def _search(presses: Presses) -> tuple[Floats, list[FoundNodule]]:
    places = np.stack([presses.x_mm, presses.y_mm], axis=1)
    numbers, variance, curve = _numbers(presses)
    effects = _effects(curve, presses)
    drift = _drift(curve)
    free = _free(presses, numbers, variance)
    grid = places_mm(presses.side_mm)
    line = np.arange(RANGES.margin_mm, presses.side_mm - RANGES.margin_mm + 0.1, SITE_MM)
    sites = grid_mm(line, line)
    prior = math.log(EXPECTED / len(sites))
    nowhere, found = np.ones(len(grid)), []
    for turn in range(MOST_NODULES + 1):
        noise = max(_noises(numbers, variance, places, drift, free), key=lambda noise: noise.likelihood)
        weights = _weights(sites, places, numbers, noise, effects)
        at_site = logsumexp(weights, axis=(1, 2))
        if turn == MOST_NODULES or at_site.max() < SOUGHT_FROM:
            nowhere *= 1.0 - _painted(grid, sites, weights + prior)
            for best in _peaks(at_site, sites):
                fine = _around(sites[best])
                found.append(_nodule(fine, _weights(fine, places, numbers, noise, effects) + prior + _FINER))
            break
        fine = _around(sites[int(np.argmax(at_site))])
        weights = _weights(fine, places, numbers, noise, effects) + prior + _FINER
        nowhere *= 1.0 - _painted(grid, fine, weights)
        found.append(_nodule(fine, weights))
        share = np.exp(weights - logsumexp(weights))
        for shape in range(len(SHAPES)):
            amounts = share[:, shape] @ effects.scales[shape]
            numbers = numbers - amounts @ effects.at(fine, places, shape)
    return 1.0 - nowhere, found


def _around(site: Floats) -> Floats:
    """Return the places of hypotheses around one, (places, 2)."""
    steps = FINE_MM * np.arange(-FINE_STEPS, FINE_STEPS + 1)
    return np.asarray(site + grid_mm(steps, steps))


def _peaks(at_site: Floats, sites: Floats) -> list[int]:
    """Return the likeliest sites, no two near each other."""
    peaks: list[int] = []
    for best in np.argsort(-at_site):
        if all(math.dist(sites[best], sites[other]) > GUESSED_APART_MM for other in peaks):
            peaks.append(int(best))
        if len(peaks) == GUESSES:
            break
    return peaks


def _nodule(sites: Floats, weights: Floats) -> FoundNodule:
    """Return the mean of hypotheses as a nodule."""
    share = np.exp(weights - logsumexp(weights))
    x_mm, y_mm = share.sum(axis=(1, 2)) @ sites
    by_shape = share.sum(axis=(0, 2))
    size_mm = math.exp(sum(by_shape[i] * math.log(SIZES_MM[size]) for i, (size, _) in enumerate(SHAPES)))
    return FoundNodule(float(x_mm), float(y_mm), size_mm, float(expit(logsumexp(weights))))


def _weights(sites: Floats, places: Floats, numbers: Floats, noise: _Noise, effects: _Effects) -> Floats:
    """Return the logarithm of likelihood ratio times weight of each hypothesis, (sites, shapes, ratios)."""
    rest = noise.whitened(numbers)
    found = np.empty((len(sites), len(SHAPES), len(RATIOS)))
    for shape in range(len(SHAPES)):
        whitened = noise.whitened(effects.at(sites, places, shape))
        by, square = rest @ whitened, np.sum(whitened**2, axis=0)
        scale = effects.scales[shape]
        found[:, shape] = np.outer(by, scale) - 0.5 * np.outer(square, scale**2)
    return np.asarray(found - math.log(len(SHAPES) * len(RATIOS)))


def _painted(grid: Floats, sites: Floats, weights: Floats) -> Floats:
    """Return the probability that a nodule of these hypotheses lies beneath each place, (places,)."""
    by_size = np.full((len(sites), len(SIZES_MM)), -np.inf)
    for shape, (size, _) in enumerate(SHAPES):
        by_size[:, size] = np.logaddexp(by_size[:, size], logsumexp(weights[:, shape], axis=1))
    share = np.exp(by_size - np.logaddexp(0.0, logsumexp(by_size)))
    distance = distances_mm(grid, sites)
    painted = np.zeros(len(grid))
    for i, size_mm in enumerate(SIZES_MM):
        painted += (distance < 0.5 * size_mm) @ share[:, i]
    return np.minimum(painted, 1.0)


def _numbers(presses: Presses) -> tuple[Floats, Floats, Floats]:
    """Return the numbers of all presses, (2 * presses,), their variance from noise, and the median course of force."""
    force = presses.force_n
    third = np.diff(force, n=3, axis=1)
    noise_n = max(1.4826 * float(np.nanmedian(np.abs(third))) / math.sqrt(20.0), 1e-3)
    numbers, variance = [], []
    for channel in CHANNELS:
        part = force[:, channel]
        known = np.isfinite(part).sum(axis=1)
        mean = np.where(known, np.nansum(part, axis=1) / np.maximum(known, 1), np.nan)
        mean = np.where(known == part.shape[1], mean, np.nan)
        level = float(np.nanmedian(mean)) if np.isfinite(mean).any() else 5.0
        held = np.maximum(np.where(np.isfinite(mean), mean, level), LEAST_N)
        numbers.append(np.log(held))
        variance.append(np.where(np.isfinite(mean), (noise_n / held) ** 2 / part.shape[1] + MISFIT**2, 1e4))
    course = np.nanmedian(np.where(np.isfinite(force), force, 10.0), axis=0)
    return np.concatenate(numbers), np.concatenate(variance), course


def _drift(curve: Floats) -> Floats:
    """Return the change of both numbers by a surface that rises by one step of depth each step of time, (2,)."""
    steps = np.arange(DEPTH_STEPS)
    slope = np.gradient(np.log(np.maximum(curve, LEAST_N)))
    return np.array([float(np.mean(slope[part] * (steps[part] + 1))) for part in CHANNELS])


def _free(presses: Presses, numbers: Floats, variance: Floats) -> Floats:
    """Return columns of levels and breathing at the likeliest rate, (2 * presses, columns).

    Breathing acts on each number by the surface's rise since contact, in first and second order.
    """
    deviation = np.sqrt(variance + TYPICAL_SD**2)
    levels = np.kron(np.eye(len(CHANNELS)), np.ones((len(presses.x_mm), 1)))

    def columns(per_min: float) -> Floats:
        turn_s = 2.0 * math.pi * per_min / 60.0
        times, start = turn_s * presses.time_s, turn_s * (presses.time_s[:, :1] - STEP_S)
        cosine, sine = np.cos(times) - np.cos(start), np.sin(times) - np.sin(start)
        # The two squares add up to a constant, so that one of them is enough.
        rises = (cosine, sine, cosine * cosine, cosine * sine)
        breathing = [block_diag(*(rise[:, part].mean(axis=1)[:, None] for part in CHANNELS)) for rise in rises]
        return np.concatenate([levels, *breathing], axis=1)

    def explained(per_min: float) -> float:
        basis = np.linalg.qr(columns(per_min) / deviation[:, None])[0]
        return float(np.sum((basis.T @ (numbers / deviation)) ** 2))

    return columns(max(np.linspace(*RANGES.breaths_per_min, RATES), key=explained))


def _noises(numbers: Floats, variance: Floats, places: Floats, drift: Floats, free: Floats) -> Iterator[_Noise]:
    """Yield the covariances that are tried."""
    apart = distances_mm(places, places)
    for length_mm, sd, share in product(LENGTHS_MM, GROUND_SDS, BREATH_SHARES):
        field = np.exp(-0.5 * (apart / length_mm) ** 2)
        covariance = np.kron(np.ones((2, 2)), sd**2 * field)
        covariance += np.kron(share**2 * np.outer(drift, drift), np.eye(len(places)))
        covariance[np.diag_indices_from(covariance)] += variance
        root = cholesky(covariance, lower=True)
        noise = _Noise(root, np.linalg.qr(solve_triangular(root, free, lower=True))[0], 0.0)
        rest = noise.whitened(numbers)
        yield replace(noise, likelihood=float(-0.5 * rest @ rest - np.log(np.diag(root)).sum()))


def _effects(curve: Floats, presses: Presses) -> _Effects:
    """Return the effect of all shapes on ground that has the median course of force."""
    steps_mm = np.nanmedian(presses.depth_mm, axis=0)
    middles = 0.5 * (_DEPTHS_MM[1:] + _DEPTHS_MM[:-1])
    ground = _fitted_ground(curve, steps_mm, middles, presses.probe_mm)
    slope, radius = ground.slope_n_mm(middles), ground.radius_mm(middles)
    plain = _logarithms(slope[None, :], steps_mm)[0]
    shares, scales = _shares()
    profiles = []
    for share in shares:
        taken = np.stack([np.interp(radius, _RADII_MM, row) for row in share])
        changed = slope / (1.0 - np.minimum(taken, LARGEST_SHARE))
        profiles.append(_logarithms(changed, steps_mm) - plain)
    return _Effects(np.array(profiles), scales)


def _logarithms(slope: Floats, steps_mm: Floats) -> Floats:
    """Return the numbers of presses that have these growths of force with depth, (presses, 2)."""
    step = _DEPTHS_MM[1] - _DEPTHS_MM[0]
    force = np.concatenate([np.zeros((len(slope), 1)), np.cumsum(slope * step, axis=1)], axis=1)
    read = np.empty((len(slope), len(steps_mm)))
    for number, course in enumerate(force):
        contact = np.interp(CONTACT_N, course, _DEPTHS_MM)
        read[number] = np.interp(contact + steps_mm, _DEPTHS_MM, course)
    return np.stack([np.log(np.maximum(read[:, part].mean(axis=1), LEAST_N)) for part in CHANNELS], axis=1)


def _fitted_ground(curve: Floats, steps_mm: Floats, middles: Floats, probe_mm: float) -> Ground:
    """Return the ground whose course of force is nearest to the median one."""
    basis = Ground(1.0, 1.5, LAYER_MM, probe_mm).slope_n_mm(middles)
    step = middles[1] - middles[0]

    def misfit(by: Floats) -> Floats:
        slope = math.exp(by[0]) * basis * (middles / 2.0) ** (by[1] - 1.5)
        course = np.concatenate([[0.0], np.cumsum(slope * step)])
        contact = np.interp(CONTACT_N, course, _DEPTHS_MM)
        wanted = np.interp(contact + steps_mm, _DEPTHS_MM, course)
        return np.asarray(np.log(np.maximum(wanted, LEAST_N) / np.maximum(curve, LEAST_N)))

    low, high = (math.log(value) for value in RANGES.ground_kpa)
    fitted = least_squares(
        misfit,
        [0.5 * (low + high), 2.0],
        bounds=([low - 0.5, RANGES.exponent[0]], [high + 0.5, RANGES.exponent[1]]),
    ).x
    return Ground(math.exp(fitted[0]), float(fitted[1]), LAYER_MM, probe_mm)


@cache
def _shares() -> tuple[Floats, Floats]:
    """Return the share taken by each shape, (shapes, distances, radii), and the scale of its effect by ratio."""
    shares, scales = [], []
    for size, cover in SHAPES:
        by_ratio = [
            taken_share(
                Sphere(0.0, 0.0, float(SIZES_MM[size]), float(COVERS_MM[cover]), float(ratio)),
                LAYER_MM,
                _RADII_MM[None, :],
                _DISTANCES_MM[:, None],
            )
            for ratio in (_MIDDLE, *RATIOS)
        ]
        shares.append(by_ratio[0])
        peaks = [-math.log1p(-float(np.interp(4.0, _RADII_MM, share[0]))) for share in by_ratio]
        scales.append([peak / max(peaks[0], 1e-9) for peak in peaks[1:]])
    return np.array(shares), np.array(scales)
