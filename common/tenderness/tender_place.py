"""Finds the most tender place from presses with and without a report of pain.

Model: the threshold is lowest at a centre and rises with the distance r to a background,

    T(r) = T0 (R - (R - 1) exp(-r^2 / (2 w^2))).

The logarithm of the threshold has the same spread in each press. A report of pain is a sample of it. A press
without a report says that the threshold was above its peak force. Some answers are wrong. All parameters are on a
grid, and the result is the mean over it.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np
from scipy.special import ndtr

from common.tenderness.presses import Floats, Press
from common.tenderness.reaction import REACTIONS_S, ReactionTime

SPREAD = 0.2
"""Standard deviation of the logarithm of a patient's threshold between presses."""
FALSE_SHARE, MISSED_SHARE = 0.02, 0.05
"""Share of reports without a cause, and of painful presses without a report."""
WIDTHS_M = (0.007, 0.010, 0.015)
RATIOS = (1.6, 2.5, 4.5)
THRESHOLDS_N = np.geomspace(0.4, 12.0, 16)
"""Thresholds at the centre, N."""
CELLS = 16
"""Cells of the grid of centres along each side."""
MARGIN_M = 0.006
"""Width of the grid beyond the touched places, m."""
_FALSE_DENSITY = 0.4
"""Probability density of ln(force) of a report without a cause."""
_LEAST_N = 0.05


@dataclass(frozen=True, slots=True)
class TenderPlace:
    """The most tender place.

    Attributes:
        x_m, y_m: its centre, m.
        sd_m: standard deviation of the centre in each direction, m.
        threshold_n: median of the patient's threshold there, N.
        low_n, high_n: limits of its 90 % interval, N.
        probability: that one place is more tender than its surroundings, 0..1.
    """

    x_m: float
    y_m: float
    sd_m: float
    threshold_n: float
    low_n: float
    high_n: float
    probability: float


def tender_place(presses: Sequence[Press], reaction: ReactionTime) -> TenderPlace | None:
    """Return the most tender place; None without a reported pain."""
    painful = [press for press in presses if press.painful]
    quiet = [press for press in presses if not press.painful]
    if not painful:
        return None
    places = np.array([list(zip(press.x_m, press.y_m, strict=True)) for press in (*painful, *quiet)])
    forces = [press.forces_n(press.risen_s - REACTIONS_S) for press in painful]
    weights = reaction.probabilities
    log_force = [np.log(np.maximum(each, _LEAST_N)) for each in forces]
    means = [weights @ each for each in log_force]
    spread = np.array(
        [SPREAD**2 + weights @ (each.max(axis=1) - weights @ each.max(axis=1)) ** 2 for each in log_force]
    )
    peaks = [np.log(np.maximum(press.peak_n, _LEAST_N)) for press in quiet]
    ln_force = np.array([*means, *peaks])
    touched = np.array([press.peak_n for press in (*painful, *quiet)]) > _LEAST_N
    centres = _centres(places[touched])
    away = ((places[None] - centres[:, None, None]) ** 2).sum(axis=-1)
    scores = np.empty((len(WIDTHS_M), len(RATIOS), THRESHOLDS_N.size, len(centres)))
    for (i, width), (j, ratio) in product(enumerate(WIDTHS_M), enumerate(RATIOS)):
        relative = np.log(ratio - (ratio - 1.0) * np.exp(-0.5 * away / width**2))
        over = (ln_force[None] - relative).max(axis=-1)
        scores[i, j] = _scores(over, np.sqrt(spread))
    flat = _scores(ln_force.max(axis=-1)[None], np.sqrt(spread))
    highest = max(scores.max(), flat.max())
    likely = np.exp(scores - highest)
    place, even = likely.mean(), np.exp(flat - highest).mean()
    at = likely.sum(axis=(0, 1, 2)) / likely.sum()
    middle = at @ centres
    sd_m = np.sqrt(0.5 * (at @ ((centres - middle) ** 2).sum(axis=-1)))
    below = np.cumsum(likely.sum(axis=(0, 1, 3))) / likely.sum()
    low_n, threshold_n, high_n = np.interp([0.05, 0.5, 0.95], below, THRESHOLDS_N)
    return TenderPlace(*map(float, (*middle, sd_m, threshold_n, low_n, high_n, place / (place + even))))


def _scores(over: Floats, spread: Floats) -> Floats:
    """Return log-likelihoods, shape (thresholds, centres).

    Args:
        over: ln(force) above the relative threshold, shape (centres, presses), presses with a report first.
        spread: standard deviation of ln(threshold) of each report.
    """
    count = spread.size
    rows = []
    for threshold_n in THRESHOLDS_N:
        above = over - np.log(threshold_n)
        reported = np.exp(-0.5 * (above[:, :count] / spread) ** 2) / (spread * np.sqrt(2.0 * np.pi))
        silent = ndtr(-above[:, count:] / SPREAD)
        rows.append(
            np.log((1.0 - FALSE_SHARE) * reported + FALSE_SHARE * _FALSE_DENSITY).sum(axis=1)
            + np.log((1.0 - MISSED_SHARE) * silent + MISSED_SHARE).sum(axis=1)
        )
    return np.array(rows)


def _centres(places: Floats) -> Floats:
    low, high = places.min(axis=0) - MARGIN_M, places.max(axis=0) + MARGIN_M
    x_m, y_m = (np.linspace(low[axis], high[axis], CELLS) for axis in (0, 1))
    return np.stack(np.meshgrid(x_m, y_m, indexing="ij"), axis=-1).reshape(-1, 2)
