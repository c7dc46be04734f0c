"""Reference that learns from many labelled touches, without a model of heat.

It assumes that a reading changes in proportion to the difference between plate and object. The logarithm of the change
per kelvin is normally distributed for each material, over pieces and contacts; fingers of a hand share a part of it.
Means and covariances are learned by expectation maximisation, and the posterior of material and temperature follows
from Bayes' rule. A calibration has a tenth of the touches or fewer.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import Akima1DInterpolator

from remote_site.thermal.touch_start import RecordedTouch
from studies.thermal_identification.situations import Hand

Array = NDArray[np.float64]

BLOCKS = 8
"""Number of block means of the readings; blocks grow with time, as heat spreads with its square root."""
FIRST = 5
"""Number of readings in the first block."""
EARLY = 15
"""Number of readings in the mean of the early force."""
ROUNDS, NEWTON_STEPS = 8, 4
"""Numbers of rounds of expectation maximisation, and of Newton's steps to the likeliest response."""
LARGEST_STEP = 1.0
"""Largest step of the logarithm of a response."""
LEAST_DIFFERENCE_K = 1.5
"""Least difference between plate and object of a touch that counts in the fit of the means, K."""
RIDGE = 1e-9
"""Penalty of a coefficient, as a share of its column's mean square."""
FIRST_NOISE_K, FIRST_SPREAD = 0.01, 0.2
"""Standard deviations of noise, K, and of ln response at the start of learning."""
LEAST_NOISE_K2, LEAST_SPREAD2 = 1e-5, 1e-8
"""Least variances of noise, K2, and of ln response."""
LEAST_RESPONSE = 1e-3
"""Least response at the start of learning."""
COARSE, FINE = 31, 601
"""Numbers of temperatures at which the likelihood is computed, and to which its logarithm is interpolated."""


def features(hands: Sequence[Hand], fingers: int, t_s: float) -> Array:
    """Return features (hands, fingers, f) of the readings up to `t_s`.

    Each finger has block means of the fall, K, the plate above ambient, K, its slope, K/s, and the mean force of the
    first readings and of all, N.
    """
    return np.array([[_features(one, t_s) for one in hand.fingers[:fingers]] for hand in hands])


def _features(touch: RecordedTouch, t_s: float) -> Array:
    count, from_s = round(t_s * 100.0), touch.first + 1
    ends = np.round(np.linspace(np.sqrt(FIRST), np.sqrt(count), BLOCKS) ** 2).astype(np.intp)
    edges = np.concatenate(([0], ends))
    fallen_k = touch.start_c - touch.trace.sensor_c[from_s : from_s + count]
    force_n = touch.trace.force_n[from_s : from_s + count]
    blocks_k = np.add.reduceat(fallen_k, edges[:-1]) / np.diff(edges)
    above_k = touch.start_c - (touch.ambient_c or 0.0)
    return np.concatenate((blocks_k, [above_k, touch.slope_k_s, force_n[:EARLY].mean(), force_n.mean()]))


@dataclass(frozen=True, slots=True)
class _Responses:
    """Distribution of the ln responses of one material; b blocks.

    Attributes:
        mean: coefficients (3, b) of one and both forces.
        own: covariance (b, b) of one finger's.
        shared: covariance (b, b) of what the fingers of a hand share.
        added: coefficients (3, b) of one, plate and slope in what is added to the fall, K.
        noise: covariance (b, b) of the block means, K2.
    """

    mean: Array
    own: Array
    shared: Array
    added: Array
    noise: Array

    @classmethod
    def first(cls, fallen_k: Array, difference_k: Array) -> Self:
        """Return the start of learning, from falls (n, fingers, b) and differences (n, fingers), K."""
        response = np.einsum("nf,nfb->b", difference_k, fallen_k) / (difference_k**2).sum()
        mean, one = np.zeros((3, BLOCKS)), np.eye(BLOCKS)
        mean[0] = np.log(np.maximum(response, LEAST_RESPONSE))
        spread = FIRST_SPREAD**2 * one
        return cls(mean, spread, 0.1 * spread, np.zeros((3, BLOCKS)), FIRST_NOISE_K**2 * one)

    def explain(self, rows: Array, middle: Array, difference_k: Array) -> tuple[Array, Array, Array]:
        """Find the likeliest ln responses to falls.

        Args:
            rows: features (n, fingers, f).
            middle: mean of the features beside the block means.
            difference_k: differences (n, t, fingers) between plate and object, K, for t temperatures of the object.

        Returns:
            Likeliest ln responses less their means (n, t, fingers * b), their covariances, and the ln likelihood (n, t)
            up to a constant of all materials.
        """
        fingers = rows.shape[1]
        beside, forces = _columns(rows, middle)
        usual = (forces @ self.mean).reshape(len(rows), 1, -1)
        fallen_k = (rows[..., :BLOCKS] - beside @ self.added).reshape(len(rows), 1, -1)
        prior = np.linalg.inv(np.kron(np.eye(fingers), self.own) + np.kron(np.ones((fingers, fingers)), self.shared))
        precision = np.kron(np.eye(fingers), np.linalg.inv(self.noise))
        slope_k = np.repeat(difference_k, BLOCKS, axis=-1)
        away: Array = np.zeros(slope_k.shape)
        for _ in range(NEWTON_STEPS):
            change = slope_k * np.exp(usual + away)
            curvature = prior + change[..., :, None] * precision * change[..., None, :]
            downhill = change * ((fallen_k - change) @ precision) - away @ prior
            away += np.clip(np.linalg.solve(curvature, downhill[..., None])[..., 0], -LARGEST_STEP, LARGEST_STEP)
        change = slope_k * np.exp(usual + away)
        curvature = prior + change[..., :, None] * precision * change[..., None, :]
        left = fallen_k - change
        ln = np.linalg.slogdet(prior)[1] + np.linalg.slogdet(precision)[1] - np.linalg.slogdet(curvature)[1]
        ln = ln - ((away @ prior) * away).sum(axis=-1) - ((left @ precision) * left).sum(axis=-1)
        return away, np.asarray(np.linalg.inv(curvature)), np.asarray(0.5 * ln)

    def learn(self, rows: Array, middle: Array, difference_k: Array) -> Self:
        """Return the distribution after one more round, from touches of known differences (n, fingers), K."""
        count, fingers = difference_k.shape
        away, covariance, _ = (each[:, 0] for each in self.explain(rows, middle, difference_k[:, None]))
        beside, forces = _columns(rows, middle)
        usual = forces @ self.mean
        ln_response = usual + away.reshape(count, fingers, BLOCKS)
        mean, more, rest = _fit(forces, beside, difference_k, usual, ln_response)
        rest = rest.reshape(count, -1)
        moment = (rest.T @ rest / count + covariance.mean(axis=0)).reshape(fingers, BLOCKS, fingers, BLOCKS)
        both = np.einsum("fbfc->bc", moment) / fingers
        pairs = max(fingers * (fingers - 1), 1)
        shared = _positive((np.einsum("fbgc->bc", moment) - fingers * both) / pairs, 0.0)
        own = _positive(both - shared, LEAST_SPREAD2)
        change = difference_k[..., None] * np.exp(ln_response)
        left = rows[..., :BLOCKS] - change - beside @ self.added
        flat = change.reshape(count, -1)
        doubt = (flat[:, :, None] * covariance * flat[:, None, :]).mean(axis=0)
        noise = np.einsum("nfb,nfc->bc", left, left) / count
        noise += np.einsum("fbfc->bc", doubt.reshape(fingers, BLOCKS, fingers, BLOCKS))
        return replace(self, mean=mean, own=own, shared=shared, added=self.added + more, noise=noise / fingers)


@dataclass(frozen=True, slots=True)
class Reference:
    """Trained distributions for one time after contact and one number of fingers.

    Attributes:
        names: materials.
        middle: mean of the features beside the block means.
        range_k: range of the object's temperature above ambient, K; every temperature in it is equally likely.
        responses: distribution of each material.
    """

    names: tuple[str, ...]
    middle: Array
    range_k: tuple[float, float]
    responses: tuple[_Responses, ...]

    def judge(self, rows: Array) -> tuple[Array, Array, Array]:
        """Return the probability of each material (n, m), and the temperature above ambient and its sd (n,), K."""
        coarse_k, fine_k = (np.linspace(*self.range_k, count) for count in (COARSE, FINE))
        difference_k = rows[:, None, :, BLOCKS] - coarse_k[:, None]
        ln = np.stack([each.explain(rows, self.middle, difference_k)[2] for each in self.responses], axis=1)
        ln = Akima1DInterpolator(coarse_k, ln, axis=-1)(fine_k)
        weight = np.exp(ln - ln.max(axis=(1, 2), keepdims=True))
        weight /= weight.sum(axis=(1, 2), keepdims=True)
        at_k = weight.sum(axis=1)
        mean_k = at_k @ fine_k
        return weight.sum(axis=2), mean_k, np.sqrt(np.maximum(at_k @ fine_k**2 - mean_k**2, 1e-6))


def train(rows: Array, materials: Sequence[str], above_k: Sequence[float]) -> Reference:
    """Train a reference on touches.

    Args:
        rows: features (n, fingers, f) of `features`.
        materials: true materials (n,).
        above_k: true temperatures of the object above ambient (n,), K.
    """
    names, label, true_k = tuple(dict.fromkeys(materials)), np.array(materials), np.array(above_k)
    middle = rows[..., BLOCKS:].mean(axis=(0, 1))
    difference_k = rows[..., BLOCKS] - true_k[:, None]
    parts = [(rows[label == name], difference_k[label == name]) for name in names]
    found = [_Responses.first(each[..., :BLOCKS], apart_k) for each, apart_k in parts]
    for _ in range(ROUNDS):
        found = [one.learn(each, middle, apart_k) for one, (each, apart_k) in zip(found, parts, strict=True)]
        # the sensor's noise does not depend on the material
        noise = _positive(np.mean([one.noise for one in found], axis=0), LEAST_NOISE_K2)
        found = [replace(one, noise=noise) for one in found]
    return Reference(names, middle, (float(true_k.min()), float(true_k.max())), tuple(found))


def _columns(rows: Array, middle: Array) -> tuple[Array, Array]:
    """Return one, plate and slope (n, fingers, 3), and one and both forces (n, fingers, 3), around their means."""
    one = np.ones((*rows.shape[:2], 1))
    plate, forces = np.split(rows[..., BLOCKS:] - middle, 2, axis=-1)
    return np.concatenate((one, plate), axis=-1), np.concatenate((one, forces), axis=-1)


def _fit(
    forces: Array, beside: Array, difference_k: Array, usual: Array, ln_response: Array
) -> tuple[Array, Array, Array]:
    """Fit ln responses (n, fingers, b) by least squares.

    Returns:
        Coefficients (3, b) of the forces, those (3, b) by which more is added to the fall, and what is left.
    """
    counts = (np.abs(difference_k) > LEAST_DIFFERENCE_K)[..., None]
    per_k = np.where(counts, np.exp(-usual) / np.where(counts, difference_k[..., None], 1.0), 0.0)
    columns = np.concatenate(
        (forces[:, :, None] * np.ones((BLOCKS, 1)), beside[:, :, None] * per_k[..., None]), axis=-1
    )
    counted = columns * counts[..., None]
    square = np.einsum("nfbi,nfbj->bij", counted, counted)
    scale = np.sqrt(np.einsum("bii->bi", square)) + 1e-12
    square = square / (scale[:, :, None] * scale[:, None, :]) + RIDGE * np.eye(scale.shape[1])
    wanted = np.einsum("nfbi,nfb->bi", counted, ln_response) / scale
    found = np.linalg.solve(square, wanted[..., None])[..., 0] / scale
    return found[:, :3].T, found[:, 3:].T, ln_response - np.einsum("nfbi,bi->nfb", columns, found)


def _positive(matrix: Array, least: float) -> Array:
    """Return the matrix with its eigenvalues raised to `least`."""
    values, vectors = np.linalg.eigh(0.5 * (matrix + matrix.T))
    return np.asarray((vectors * np.maximum(values, least)) @ vectors.T)
