"""Judge any detector of nodules on the random phantoms: AUC in each cell, place, order of size, and calibration.

A nodule's score is the highest probability within its outline, or within 3 mm of its centre. Control sites are circles
of drawn sizes, well away from all nodules. AUC is the share of pairs of a nodule and a control site in which the
nodule has the higher score; ties count half. In a cell both are of one class of size. The overall AUC has all pairs.
"""

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from itertools import chain, combinations, pairwise, product
from typing import Any

import numpy as np
from numpy.typing import NDArray

from sim_sensors.tissue.contrast import Sphere
from studies.nodules.phantoms import Phantom, Presses, grid_mm
from studies.nodules.ranges import DEPTH_EDGES_MM, RANGES, RATIO_EDGES, SIZE_EDGES_MM, Range

Floats = NDArray[np.float64]

PITCH_MM = 2.5
"""Spacing of the places at which a detector gives a probability, mm."""
CONTROLS = 6
"""Control sites of a phantom."""
CLEAR_MM = 8.0
"""Least gap between the outlines of a control site and a nodule, mm."""
NEAREST_MM = 3.0
"""Least radius of the circle that is searched for a score, and the place error that counts as good, mm."""
FOUND_MM = 10.0
"""Largest distance from a nodule's centre at which an answer can be that nodule, mm."""
DIFFERENT = 1.5
"""Ratio of two diameters from which on their order is judged."""
GOOD_AUC = 0.95
"""AUC of the reference from which on place and order of size are judged in a cell."""
BINS = (0.0, 0.05, 0.2, 0.4, 0.6, 0.8, 0.95, 1.0)
"""Edges of the classes of stated probability."""


@dataclass(frozen=True, slots=True)
class FoundNodule:
    """A nodule that a detector found: centre and diameter, mm, and the probability that there is one, 0..1."""

    x_mm: float
    y_mm: float
    size_mm: float
    probability: float


@dataclass(frozen=True, slots=True)
class Answer:
    """A detector's answer about one phantom.

    Attributes:
        probability: probability that a nodule lies beneath each of `places_mm`, (places,), 0..1.
        found: nodules, in any order; one of low probability costs nothing.
    """

    probability: Floats
    found: tuple[FoundNodule, ...]


Detector = Callable[[Presses], Answer]
"""A detector: from the presses on one phantom to its answer."""


@dataclass(frozen=True, slots=True)
class Site:
    """A judged circle: its class of size, score, and nodule; None for a control site."""

    size_class: int
    score: float
    sphere: Sphere | None
    found: FoundNodule | None


@dataclass(frozen=True, slots=True)
class Judged:
    """What a detector said about one phantom.

    Attributes:
        seed: of the phantom.
        sites: its nodules and control sites.
        stated: number of places in each class of stated probability.
        true: number of those that lie above a nodule.
        mean: sum of the stated probabilities of each class.
    """

    seed: int
    sites: tuple[Site, ...]
    stated: tuple[int, ...]
    true: tuple[int, ...]
    mean: tuple[float, ...]


def places_mm(side_mm: float = RANGES.side_mm) -> Floats:
    """Return the places at which a detector gives a probability, (places, 2), mm."""
    line = (np.arange(round(side_mm / PITCH_MM)) + 0.5) * PITCH_MM
    return grid_mm(line, line)


def judge(phantom: Phantom, answer: Answer) -> Judged:
    """Judge the answer about one phantom.

    Raises:
        ValueError: the answer has another number of places than `places_mm`, or a probability outside 0..1.
    """
    places = places_mm()
    probability = answer.probability
    if probability.shape != (len(places),) or not np.all((probability >= 0.0) & (probability <= 1.0)):
        raise ValueError(f"a detector gives {len(places)} probabilities from 0 to 1, not an array {probability.shape}")
    sites = []
    for sphere in phantom.spheres:
        score = _score(places, probability, sphere.x_mm, sphere.y_mm, sphere.size_mm)
        sites.append(Site(size_class(sphere.size_mm), score, sphere, _nearest(sphere, answer.found)))
    for x_mm, y_mm, size_mm in control_sites(phantom):
        score = _score(places, probability, x_mm, y_mm, size_mm)
        sites.append(Site(size_class(size_mm), score, None, None))
    above = above_nodule(phantom, places)
    bins = np.clip(np.digitize(probability, BINS) - 1, 0, len(BINS) - 2)
    count = len(BINS) - 1
    return Judged(
        phantom.seed,
        tuple(sites),
        tuple(np.bincount(bins, minlength=count).tolist()),
        tuple(np.bincount(bins[above], minlength=count).tolist()),
        tuple(np.bincount(bins, weights=probability, minlength=count).tolist()),
    )


def above_nodule(phantom: Phantom, places: Floats) -> NDArray[np.bool_]:
    """Return which places lie above a nodule, (places,)."""
    above = np.zeros(len(places), dtype=bool)
    for sphere in phantom.spheres:
        above |= np.hypot(places[:, 0] - sphere.x_mm, places[:, 1] - sphere.y_mm) < 0.5 * sphere.size_mm
    return above


def control_sites(phantom: Phantom) -> list[tuple[float, float, float]]:
    """Draw the control sites of a phantom: x, y and diameter, mm. All detectors get the same ones."""
    rng = np.random.default_rng([phantom.seed, 0xC0])
    sites: list[tuple[float, float, float]] = []
    for _ in range(20 * CONTROLS):
        x_mm, y_mm = rng.uniform(RANGES.margin_mm, RANGES.side_mm - RANGES.margin_mm, 2).tolist()
        size_mm = float(np.exp(rng.uniform(*np.log(RANGES.size_mm))))
        gaps = (math.hypot(x_mm - s.x_mm, y_mm - s.y_mm) - 0.5 * (size_mm + s.size_mm) for s in phantom.spheres)
        if all(gap >= CLEAR_MM for gap in gaps):
            sites.append((x_mm, y_mm, size_mm))
        if len(sites) == CONTROLS:
            break
    return sites


def size_class(size_mm: float) -> int:
    """Return the number of the class of a diameter, mm, from 0 on."""
    place = int(np.searchsorted(SIZE_EDGES_MM, size_mm, side="right")) - 1
    return min(max(place, 0), len(SIZE_EDGES_MM) - 2)


def cells() -> list[dict[str, Range]]:
    """Return the ranges of depth, size and ratio of all cells."""
    ranges = [list(pairwise(edges)) for edges in (DEPTH_EDGES_MM, SIZE_EDGES_MM, RATIO_EDGES)]
    return [{"depth_mm": d, "size_mm": s, "ratio": r} for d, s, r in product(*ranges)]


def area_under_curve(scores: Sequence[float], controls: Sequence[float]) -> float | None:
    """Return the share of pairs in which the score is above the control, ties counting half; None without a pair."""
    if not scores or not controls:
        return None
    ordered = np.sort(controls)
    below = np.searchsorted(ordered, scores, side="left") + np.searchsorted(ordered, scores, side="right")
    return float(0.5 * below.mean() / len(ordered))


def standard_error(scores: Sequence[Sequence[float]], controls: Sequence[Sequence[float]]) -> float | None:
    """Return the standard error of an AUC over draws of the phantoms (Obuchowski 1997).

    Sites of one phantom are not independent: they have its ground, breathing and noise in common.

    Args:
        scores: scores of each phantom's nodules.
        controls: scores of each phantom's control sites.

    Returns:
        The standard error; None unless two phantoms have a nodule and two have a control site.
    """
    return _standard_error(_won(scores, controls), scores, controls)


def _won(scores: Sequence[Sequence[float]], controls: Sequence[Sequence[float]]) -> Floats:
    """Return which nodules have a higher score than which control sites, (nodules, controls); ties count half."""
    nodules, places = np.array([*chain(*scores)])[:, None], np.array([*chain(*controls)])
    return np.asarray((nodules > places) + 0.5 * (nodules == places))


def _standard_error(
    won: Floats, scores: Sequence[Sequence[float]], controls: Sequence[Sequence[float]]
) -> float | None:
    """Return the standard error of the mean of `won`, (nodules, controls), which is an AUC or a difference of two."""
    with_nodule, with_control = (sum(map(bool, each)) for each in (scores, controls))
    if min(with_nodule, with_control) < 2:
        return None
    above = _by_phantom(won.mean(axis=1) - won.mean(), scores)
    below = _by_phantom(won.mean(axis=0) - won.mean(), controls)
    variance = with_nodule / (with_nodule - 1) * np.dot(above, above)
    variance += with_control / (with_control - 1) * np.dot(below, below)
    variance += 2.0 * len(scores) / (len(scores) - 1) * np.dot(above, below)
    return math.sqrt(max(0.0, float(variance)))


def _by_phantom(deviation: Floats, sites: Sequence[Sequence[float]]) -> Floats:
    """Return the sum of the deviations of each phantom's sites over the number of all sites, (phantoms,)."""
    owner = np.repeat(np.arange(len(sites)), [len(each) for each in sites])
    return np.asarray(np.bincount(owner, deviation, len(sites)) / len(deviation))


def by_cell(judged: Sequence[Judged]) -> list[dict[str, Any]]:
    """Return a row for each cell: AUC and its standard error, place errors, and the share within 3 mm."""
    rows = []
    for cell in cells():
        scores, controls = _scores(judged, cell)
        nodules = [site for one in judged for site in one.sites if site.sphere and _in_cell(site.sphere, cell)]
        errors = [place_error_mm(site) for site in nodules]
        rows.append(
            {
                **_ends(cell),
                "nodules": len(errors),
                "auc": area_under_curve([*chain(*scores)], [*chain(*controls)]),
                "auc_se": standard_error(scores, controls),
                "place_median_mm": finite_median(errors),
                "within_3_mm": float(np.mean(np.array(errors) <= NEAREST_MM)) if errors else None,
            }
        )
    return rows


def differences(detected: Sequence[Judged], reference: Sequence[Judged]) -> list[dict[str, Any]]:
    """Return the AUC of a detector less that of the reference on the same sites, with its standard error, by cell.

    The last row is over all nodules, and has no ends.
    """
    rows = []
    for cell in (*cells(), None):
        (scores, controls), other = _scores(detected, cell), _scores(reference, cell)
        won = _won(scores, controls) - _won(*other)
        rows.append(
            {
                **({} if cell is None else _ends(cell)),
                "nodules": len(won),
                "difference": float(won.mean()) if won.size else None,
                "difference_se": _standard_error(won, scores, controls),
            }
        )
    return rows


def _ends(cell: dict[str, Range]) -> dict[str, float]:
    return {f"{name}_from": low for name, (low, _) in cell.items()} | {
        f"{name}_to": high for name, (_, high) in cell.items()
    }


def _scores(judged: Sequence[Judged], cell: dict[str, Range] | None) -> tuple[list[list[float]], list[list[float]]]:
    """Return the scores of each phantom's nodules in a cell, and of its control sites of the cell's class of size.

    Without a cell, those of all.
    """
    size = None if cell is None else size_class(cell["size_mm"][0])
    scores = [
        [site.score for site in one.sites if site.sphere and (cell is None or _in_cell(site.sphere, cell))]
        for one in judged
    ]
    controls = [
        [site.score for site in one.sites if site.sphere is None and size in {None, site.size_class}] for one in judged
    ]
    return scores, controls


def overall(judged: Sequence[Judged], good: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Return the figures of all phantoms, and of the cells in which the reference is good.

    Args:
        judged: the answers to all phantoms.
        good: rows of `by_cell` of the reference; the cells with an AUC of at least `GOOD_AUC` count.
    """
    sites = [site for each in judged for site in each.sites]
    nodules = [site for site in sites if site.sphere is not None]
    limits = [
        {name: (row[f"{name}_from"], row[f"{name}_to"]) for name in ("depth_mm", "size_mm", "ratio")}
        for row in good
        if row["auc"] is not None and row["auc"] >= GOOD_AUC
    ]
    there = [site for site in nodules if site.sphere and any(_in_cell(site.sphere, cell) for cell in limits)]
    errors = np.array([place_error_mm(site) for site in there])
    return {
        "phantoms": len(judged),
        "nodules": len(nodules),
        "auc": area_under_curve([s.score for s in nodules], [s.score for s in sites if s.sphere is None]),
        "good_cells": len(limits),
        "good_nodules": len(there),
        "within_3_mm": float(np.mean(errors <= NEAREST_MM)) if len(errors) else None,
        "size_order": _size_order(there),
    }


def reliability(judged: Iterable[Judged]) -> list[dict[str, Any]]:
    """Return a row for each class of stated probability: its mean, and the share of places above a nodule."""
    each = list(judged)
    rows = []
    for index, (low, high) in enumerate(pairwise(BINS)):
        count = sum(one.stated[index] for one in each)
        stated = sum(one.mean[index] for one in each) / count if count else None
        true = sum(one.true[index] for one in each) / count if count else None
        rows.append({"from": low, "to": high, "places": count, "stated": stated, "true": true})
    return rows


def _score(places: Floats, probability: Floats, x_mm: float, y_mm: float, size_mm: float) -> float:
    near = np.hypot(places[:, 0] - x_mm, places[:, 1] - y_mm) <= max(0.5 * size_mm, NEAREST_MM)
    return float(probability[near].max())


def _nearest(sphere: Sphere, found: Sequence[FoundNodule]) -> FoundNodule | None:
    """Return the likeliest found nodule within reach of a true one."""
    near = [one for one in found if math.hypot(one.x_mm - sphere.x_mm, one.y_mm - sphere.y_mm) <= FOUND_MM]
    return max(near, key=lambda one: one.probability, default=None)


def place_error_mm(site: Site) -> float:
    """Return the distance of the found nodule from the true one, mm; infinite where none was found."""
    if site.sphere is None or site.found is None:
        return math.inf
    return math.hypot(site.found.x_mm - site.sphere.x_mm, site.found.y_mm - site.sphere.y_mm)


def finite_median(errors: Sequence[float]) -> float | None:
    """Return the median; None without errors, or where half of the nodules were not found."""
    median = float(np.median(errors)) if errors else math.inf
    return median if math.isfinite(median) else None


def _in_cell(sphere: Sphere, cell: dict[str, Range]) -> bool:
    values = {"depth_mm": sphere.depth_mm, "size_mm": sphere.size_mm, "ratio": sphere.ratio}
    return all(low <= values[name] < high for name, (low, high) in cell.items())


def _size_order(sites: Sequence[Site]) -> dict[str, Any]:
    """Return the share of pairs of different size whose order is right, and their number; not found counts as wrong."""
    nodules = [(site.sphere.size_mm, site.found) for site in sites if site.sphere is not None]
    right = total = 0
    for (small_mm, small), (large_mm, large) in combinations(sorted(nodules, key=lambda nodule: nodule[0]), 2):
        if large_mm >= DIFFERENT * small_mm:
            total += 1
            right += small is not None and large is not None and small.size_mm < large.size_mm
    return {"pairs": total, "right": right / total if total else None}
