"""Chooses where to press next: the place that is expected to say most about where lumps are.

A press lowers the variance of the excess at all places that are correlated with it, by an amount that is known before
the press. The choice maximises the sum of these amounts. Each place counts by how undecided it is: by the entropy of
its lump probability, and by a floor that also sends presses into ground without one.
"""

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray

from operator_site.palpation.lump_probability import FEWEST_PLACES, LumpMap
from operator_site.palpation.stiffness_field import StiffnessField

Floats = NDArray[np.float64]
FLOOR = 0.3
"""Weight of a decided place; an undecided one has up to 1 more."""
MOST_CANDIDATES = 400
"""Maximum number of candidates and of weighed places."""
_STEP_M = 2e-3


def next_presses(field: StiffnessField, low_m: ArrayLike, high_m: ArrayLike, number: int = 1) -> Floats:
    """Return the next places in a rectangle, (number, 2), m, the most informative first.

    Each is chosen as if the ones before had been pressed, so that several fingers can share them.

    Args:
        field: the field of the presses so far.
        low_m, high_m: near left and far right corner of the rectangle, (2,), m.
        number: number of places.
    """
    candidates = _candidates(np.asarray(low_m, dtype=np.float64), np.asarray(high_m, dtype=np.float64))
    return candidates[best(field, candidates, number)]


def best(field: StiffnessField, candidates_m: Floats, number: int = 1) -> list[int]:
    """Return the indices of the most informative candidates, (n, 2), m; each candidate is also a weighed place."""
    whole, excess = field.covariances(candidates_m)
    weight = FLOOR + _entropy(field, candidates_m)
    chosen: list[int] = []
    for _ in range(min(number, len(candidates_m))):
        seen = np.maximum(np.diag(whole), 0.0) + field.press_sd**2
        gain = weight @ np.square(excess) / seen
        gain[chosen] = -np.inf
        one = int(gain.argmax())
        chosen.append(one)
        share = whole[one] / seen[one]
        whole, excess = whole - np.outer(whole[:, one], share), excess - np.outer(excess[:, one], share)
    return chosen


def _entropy(field: StiffnessField, places_m: Floats) -> Floats:
    """Return the entropy of the lump probability of each place, 0..1 bit; 1 while there is no probability."""
    if len(field.places_m) < FEWEST_PLACES:
        return np.ones(len(places_m))
    p = np.clip(LumpMap(field).probability(places_m), 1e-9, 1.0 - 1e-9)
    return np.asarray(-(p * np.log2(p) + (1.0 - p) * np.log2(1.0 - p)))


def _candidates(low_m: Floats, high_m: Floats) -> Floats:
    """Return a lattice of at most MOST_CANDIDATES places inside a rectangle; a line in the middle of a narrow one."""
    step_m = max(_STEP_M, math.sqrt(float(np.prod(high_m - low_m)) / MOST_CANDIDATES))
    while True:
        axes = [_inside(low, high, step_m) for low, high in zip(low_m.tolist(), high_m.tolist(), strict=True)]
        if math.prod(map(len, axes)) <= MOST_CANDIDATES:
            return np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
        step_m *= 1.1


def _inside(low_m: float, high_m: float, step_m: float) -> Floats:
    """Return the multiples of a step from one place of an axis to another; the middle without one."""
    multiples = step_m * np.arange(math.floor(low_m / step_m), math.ceil(high_m / step_m) + 1)
    inside = multiples[(multiples >= low_m) & (multiples <= high_m)]
    return np.asarray(inside if len(inside) else [0.5 * (low_m + high_m)], dtype=np.float64)
