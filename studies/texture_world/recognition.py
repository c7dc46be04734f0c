"""Names textures by five labelled strokes each, beside two classic baselines, and keeps out strangers."""

from collections.abc import Iterator, Mapping, Sequence
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import NDArray

from remote_site.texture.calibration.motion_spectrum_fit import fit_spectra
from remote_site.texture.motion_spectrum import MotionSpectra, StrokeSpectrum
from studies.texture.baselines import classifiers
from studies.texture_world.models import TextureModel
from studies.texture_world.strokes import LONGEST_S, Stroke, stroke_over

Array = NDArray[np.float64]
Row = dict[str, Any]
LABELLED = 5
"""Number of labelled strokes of each texture."""
SECONDS = (0.15, 0.25, 0.5, 1.0, 2.0, LONGEST_S)
"""Durations of the judged strokes, s."""
SHIPPED, NEIGHBOUR, DISCRIMINANT = (
    "shipped",
    "nearest neighbour, band energies",
    "linear discriminant, spectrum and motion",
)
METHODS = (SHIPPED, NEIGHBOUR, DISCRIMINANT)
FOLDS = 5
"""Number of groups of textures; each group in turn is never calibrated."""
TOP = 3


def strokes_of(models: Sequence[TextureModel], each: int, seed: int) -> list[list[Stroke]]:
    """Return `each` strokes over each texture."""
    return [[stroke_over(model, seed, place, number) for number in range(each)] for place, model in enumerate(models)]


def named(models: Sequence[TextureModel], judged: int, seed: int) -> Iterator[Row]:
    """Yield the ranks of the true texture by each method at each duration, a row for each judged stroke.

    The shipped method learns from whole strokes. A baseline learns from strokes as short as the judged ones, which
    favours it.
    """
    drawn = strokes_of(models, LABELLED + judged, seed)
    spectra = fitted(drawn)
    true = np.arange(len(models)).repeat(judged)
    for seconds in SECONDS:
        learned = [[one.spectrum(seconds) for one in strokes[:LABELLED]] for strokes in drawn]
        asked = [one.spectrum(seconds) for strokes in drawn for one in strokes[LABELLED:]]
        scores = dict(_classic(learned, asked))
        scores[SHIPPED] = np.array([spectra.rank(one).probabilities for one in asked])
        for method, score in scores.items():
            for place, one, rank in zip(true.tolist(), asked, ranks(score, true), strict=True):
                yield {
                    "method": method,
                    "seconds": seconds,
                    "material": models[place].material,
                    "ln_speed": float(one.motion[1]),
                    "ln_force": float(one.motion[2]),
                    "rank": int(rank),
                }


def ranks(score: Array, true: NDArray[np.intp]) -> NDArray[np.intp]:
    """Return the rank of the true texture of each stroke, 0 for the first; it is behind textures with the same score.

    Probabilities of unlikely textures are all 0.
    """
    own = score[np.arange(len(true)), true][:, None]
    return np.asarray((score >= own).sum(axis=1) - 1)


def fitted(drawn: Sequence[Sequence[Stroke]]) -> MotionSpectra:
    """Fit the shipped spectra to the first five strokes of each texture; labels are the textures' places."""
    labels = [f"{place:03d}" for place in range(len(drawn)) for _ in range(LABELLED)]
    fit = fit_spectra([one.spectrum(LONGEST_S) for strokes in drawn for one in strokes[:LABELLED]], labels)
    assert fit is not None, "five strokes of two textures suffice"
    return fit.spectra


def _classic(learned: Sequence[Sequence[StrokeSpectrum]], asked: Sequence[StrokeSpectrum]) -> Mapping[str, Array]:
    """Return the scores of both baselines, strokes x textures."""
    labels = np.repeat(np.arange(len(learned)), LABELLED)
    bands, moved = _features([one for strokes in learned for one in strokes])
    asked_bands, asked_moved = _features(asked)
    scale = bands.std(axis=0)
    tree = import_module("sklearn.neighbors").NearestNeighbors(n_neighbors=len(bands)).fit(bands / scale)
    distance, place = tree.kneighbors(asked_bands / scale)
    nearest = np.full((len(asked), len(learned)), -np.inf)
    for row, own, far in zip(nearest, labels[place], distance, strict=True):
        np.maximum.at(row, own, -far)
    discriminant = classifiers()["linear discriminant"].fit(np.hstack([bands, moved]), labels)
    return {
        NEIGHBOUR: nearest,
        DISCRIMINANT: discriminant.decision_function(np.hstack([asked_bands, asked_moved])),
    }


def _features(strokes: Sequence[StrokeSpectrum]) -> tuple[Array, Array]:
    """Return band energies, and ln speed and ln force."""
    return np.array([one.ln_power for one in strokes]), np.array([one.motion[1:] for one in strokes])


def strangers(models: Sequence[TextureModel], judged: int, seed: int, folds: int, known: str) -> Iterator[Row]:
    """Yield counts of strokes called unknown, at each duration, with one group of textures after the other apart.

    Args:
        models: all textures.
        judged: number of judged strokes of each texture.
        seed: of strokes and groups.
        folds: number of groups that are set apart, at most FOLDS.
        known: `many`: the other groups are calibrated; `few`: only the group is.
    """
    drawn = strokes_of(models, LABELLED + judged, seed)
    asked = [[{t: one.spectrum(t) for t in SECONDS} for one in strokes[LABELLED:]] for strokes in drawn]
    groups = np.array_split(np.random.default_rng(seed).permutation(len(models)), FOLDS)
    for group in groups[:folds]:
        own = sorted(group.tolist() if known == "few" else set(range(len(models))) - set(group.tolist()))
        others = sorted(set(range(len(models))) - set(own))
        spectra = fitted([drawn[place] for place in own])
        for seconds in SECONDS:
            mine = [(place, spectra.rank(one[seconds])) for place in own for one in asked[place]]
            theirs = [spectra.rank(one[seconds]) for place in others for one in asked[place]]
            yield {
                "known_textures": known,
                "seconds": seconds,
                "own": len(mine),
                "own_unknown": sum(not found.known for _, found in mine),
                "own_right": sum(found.known and own[found.best] == place for place, found in mine),
                "strange": len(theirs),
                "strange_unknown": sum(not found.known for found in theirs),
            }
