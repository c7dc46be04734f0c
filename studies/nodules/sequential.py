"""Presses random phantoms one after another, each at a place that is chosen from the presses before.

Two rasters, random places, and the places that `operator_site.palpation.next_press` proposes are compared on the same
phantoms, with the same noise of the first, second and each further press. Chosen places begin with a raster of
FIRST_A_SIDE.
"""

import math
from collections.abc import Iterator, Sequence
from itertools import product
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import isotonic_regression

from operator_site.palpation.next_press import next_presses
from operator_site.palpation.nodule_search import NoduleSearch
from sim_sensors.tissue.ground import force_at
from studies.nodules.detector import detect, numbers_of
from studies.nodules.judge import NEAREST_MM, area_under_curve, finite_median, judge, place_error_mm
from studies.nodules.phantoms import Phantom, Presses, draw_phantom, grid_mm, readings
from studies.nodules.ranges import DEPTH_STEPS, RANGES

Floats = NDArray[np.float64]
FIRST_A_SIDE = 4
"""Presses along one side of the raster that begins every sequence of chosen places."""
RASTERS = ((4, 4), (4, 5), (5, 5), (5, 6), (6, 6), (6, 7), (7, 7), (7, 8), (8, 8))
"""Rows and columns of the judged rasters; the others are judged after as many presses."""
MOST = max(a * b for a, b in RASTERS)
EDGE_MM = 2.0
"""Least distance of a chosen place from the edge of the square, mm."""
RASTER, INNER, RANDOM, NEXT = "raster", "inner raster", "random", "next press"
WAYS = (RASTER, INNER, RANDOM, NEXT)
"""Ways to choose places. An inner raster leaves RIM_MM along the edge, where no phantom has the middle of a nodule."""
RIM_MM = 6.0
"""Width of the rim that an inner raster leaves, mm."""
AT = (30, 60)
"""Numbers of presses of a raster whose AUC the other ways are to reach."""
DRAWS = 1000
"""Draws of the phantoms for an interval."""
_NUMBERS = [a * b for a, b in RASTERS]
_PITCH_MM = 1.0
_DEEPEST_MM = 10.0
_STREAM = 0x5E


class PressedPhantom:
    """A phantom whose ground and noise are drawn once, for presses at any places.

    Courses of force lie on a grid of _PITCH_MM, and are interpolated between its places.
    """

    def __init__(self, phantom: Phantom) -> None:
        """Draw ground and noise from the phantom's seed."""
        rng = np.random.default_rng([phantom.seed, _STREAM])
        line = np.arange(0.0, RANGES.side_mm + _PITCH_MM, _PITCH_MM)
        places = grid_mm(line, line)
        self.phantom = phantom
        self._depths_mm, force = force_at(phantom.ground, phantom.spheres, places[:, 0], places[:, 1], _DEEPEST_MM)
        # A squared exponential is a product of one factor for each axis.
        along = np.exp(-0.5 * ((line[:, None] - line) / phantom.ground_length_mm) ** 2)
        root = np.linalg.cholesky(along + 1e-8 * np.eye(len(line)))
        ground = phantom.ground_sd * root @ rng.standard_normal((len(line), len(line))) @ root.T
        self._courses = force.reshape(len(line), len(line), -1) * np.exp(ground)[..., None]
        self._away_mm = phantom.place_noise_mm * rng.standard_normal((MOST, 2))
        self._phase = float(rng.uniform(0.0, 2.0 * math.pi))
        self._noise = rng.standard_normal((2, MOST, DEPTH_STEPS))

    def press(self, places_mm: Floats) -> Presses:
        """Return the readings of presses at these places, (n, 2), mm, in this order; at most MOST."""
        count = len(places_mm)
        at = np.clip((places_mm + self._away_mm[:count]) / _PITCH_MM, 0.0, len(self._courses) - 1.001)
        (i, j), (a, b) = at.astype(int).T, (at % 1.0).T[..., None]
        near = (1.0 - b) * self._courses[i, j] + b * self._courses[i, j + 1]
        far = (1.0 - b) * self._courses[i + 1, j] + b * self._courses[i + 1, j + 1]
        courses = (1.0 - a) * near + a * far
        return readings(self.phantom, places_mm, self._depths_mm, courses, self._phase, self._noise[:, :count])


def raster_mm(rows: int, columns: int, rim_mm: float = 0.0) -> Floats:
    """Return the places of a raster over the square without its rim, (rows * columns, 2), mm."""
    side_mm = RANGES.side_mm - 2.0 * rim_mm
    x, y = (rim_mm + (np.arange(number) + 0.5) * side_mm / number for number in (rows, columns))
    return grid_mm(x, y)


def chosen_mm(pressed: PressedPhantom, way: str) -> Floats:
    """Return MOST places that are chosen one after another, (MOST, 2), mm.

    Args:
        pressed: the phantom.
        way: RANDOM or NEXT.
    """
    rng = np.random.default_rng([pressed.phantom.seed, _STREAM, 1])
    places = raster_mm(FIRST_A_SIDE, FIRST_A_SIDE)
    low_m, high_m = np.full(2, 1e-3 * EDGE_MM), np.full(2, 1e-3 * (RANGES.side_mm - EDGE_MM))
    while len(places) < MOST:
        if way == RANDOM:
            new = rng.uniform(1e3 * low_m, 1e3 * high_m)[None, :]
        else:
            new = 1e3 * next_presses(NoduleSearch(numbers_of(pressed.press(places))), low_m, high_m)
        places = np.concatenate([places, new])
    return places


def judged_sequence(seed: int) -> Iterator[dict[str, Any]]:
    """Yield a row for each way and judged number of presses on the phantom of a seed.

    It has the scores of nodules and of control sites, the place error of each nodule, None where nothing was found, mm,
    and the way between presses since the first, m.
    """
    pressed = PressedPhantom(draw_phantom(seed))
    for way in WAYS:
        chosen = chosen_mm(pressed, way) if way in (RANDOM, NEXT) else None
        rim_mm = RIM_MM if way == INNER else 0.0
        for rows, columns in RASTERS:
            places = raster_mm(rows, columns, rim_mm) if chosen is None else chosen[: rows * columns]
            judged = judge(pressed.phantom, detect(pressed.press(places)))
            nodules = [site for site in judged.sites if site.sphere is not None]
            errors = [place_error_mm(site) for site in nodules]
            yield {
                "phantom": seed,
                "way": way,
                "presses": len(places),
                "nodules": [site.score for site in nodules],
                "controls": [site.score for site in judged.sites if site.sphere is None],
                "place_mm": [error if math.isfinite(error) else None for error in errors],
                "moved_m": 1e-3 * float(np.hypot(*np.diff(places, axis=0).T).sum()),
            }


def curves(rows: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return a row for each way and number of presses: AUC of all nodules, place errors, and way."""
    found = []
    for way in WAYS:
        for presses in _NUMBERS:
            mine = [row for row in rows if (row["way"], row["presses"]) == (way, presses)]
            errors = [math.inf if e is None else e for row in mine for e in row["place_mm"]]
            scores, controls = ([score for row in mine for score in row[name]] for name in ("nodules", "controls"))
            found.append(
                {
                    "way": way,
                    "presses": presses,
                    "phantoms": len(mine),
                    "nodules": len(scores),
                    "auc": area_under_curve(scores, controls),
                    "within_3_mm": float(np.mean(np.array(errors) <= NEAREST_MM)),
                    "place_median_mm": finite_median(errors),
                    "moved_m": float(np.mean([row["moved_m"] for row in mine])),
                }
            )
    return found


def saved(rows: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return the share of presses that each way saves at the AUC of a raster of AT presses, with an interval of 90 %.

    The AUC over the number of presses is made monotone (isotonic regression), and is linear between judged numbers. A
    way that misses the AUC with MOST presses counts as using MOST. The interval is over new draws of the phantoms. A
    draw without a nodule has no AUC and is left out.
    """
    wins = {way: [_Wins(rows, way, presses) for presses in _NUMBERS] for way in WAYS}
    weights = _weights(wins[RASTER][0].nodules)
    curve = _curve(wins[RASTER], weights[0])
    found = []
    for at, way in product(AT, WAYS[1:]):
        needed = [_needed(wins, way, at, weight) for weight in weights]
        low, high = np.quantile(1.0 - np.array(needed[1:]) / at, (0.05, 0.95))
        found.append(
            {
                "raster_presses": at,
                "auc": float(np.interp(at, _NUMBERS, curve)),
                "way": way,
                "presses": needed[0],
                "saved": 1.0 - needed[0] / at,
                "saved_from": float(low),
                "saved_to": float(high),
            }
        )
    return found


def gains(rows: Sequence[dict[str, Any]]) -> list[dict[str, Any]]:
    """Return the AUC of a way minus that of another, a mean over the numbers of presses from AT[0] on.

    The standard error is over new draws of the phantoms, which both ways share.
    """
    wins = {way: [_Wins(rows, way, presses) for presses in _NUMBERS if presses >= AT[0]] for way in WAYS}
    weights = _weights(wins[RASTER][0].nodules)
    means = {way: np.array([np.mean([one.auc(weight) for one in wins[way]]) for weight in weights]) for way in WAYS}
    found = []
    for way, other in ((INNER, RASTER), (RANDOM, RASTER), (NEXT, RASTER), (NEXT, INNER)):
        gain = means[way] - means[other]
        found.append({"way": way, "over": other, "gain": float(gain[0]), "standard_error": float(gain[1:].std())})
    return found


class _Wins:
    """Comparisons of all nodules with all control sites, by phantom: any draw of phantoms has its AUC at once."""

    def __init__(self, rows: Sequence[dict[str, Any]], way: str, presses: int) -> None:
        mine = [row for row in rows if (row["way"], row["presses"]) == (way, presses)]
        self.nodules = np.array([len(row["nodules"]) for row in mine], dtype=float)
        self._controls = np.array([len(row["controls"]) for row in mine], dtype=float)
        scores, controls = (np.concatenate([row[name] for row in mine]) for name in ("nodules", "controls"))
        won = (scores[:, None] > controls) + 0.5 * (scores[:, None] == controls)
        self._won = _belongs(self.nodules) @ won @ _belongs(self._controls).T

    def auc(self, weight: Floats) -> float:
        """Return the AUC with a weight of each phantom."""
        return float(weight @ self._won @ weight / ((weight @ self.nodules) * (weight @ self._controls)))


def _weights(nodules: Floats) -> Floats:
    """Return weights of the phantoms, (1 + draws, phantoms): all once, then DRAWS new draws that have a nodule."""
    phantoms = len(nodules)
    drawn = np.random.default_rng(0).multinomial(phantoms, np.full(phantoms, 1.0 / phantoms), DRAWS).astype(float)
    return np.concatenate([np.ones((1, phantoms)), drawn[drawn @ nodules > 0.0]])


def _belongs(counts: Floats) -> Floats:
    """Return which item belongs to which phantom, (phantoms, items), 0 or 1."""
    owner = np.repeat(np.arange(len(counts)), counts.astype(int))
    return np.asarray(np.arange(len(counts))[:, None] == owner, dtype=np.float64)


def _curve(wins: Sequence[_Wins], weight: Floats) -> Floats:
    return np.asarray(isotonic_regression([one.auc(weight) for one in wins]).x)


def _needed(wins: dict[str, list[_Wins]], way: str, at: int, weight: Floats) -> float:
    """Return the smallest number of presses that reaches the AUC of a raster of `at`, at most MOST."""
    goal = float(np.interp(at, _NUMBERS, _curve(wins[RASTER], weight)))
    curve = _curve(wins[way], weight)
    fine = np.linspace(_NUMBERS[0], _NUMBERS[-1], 10 * (_NUMBERS[-1] - _NUMBERS[0]) + 1)
    reached = np.flatnonzero(np.interp(fine, _NUMBERS, curve) >= goal - 1e-12)
    return float(fine[reached[0]]) if len(reached) else float(MOST)
