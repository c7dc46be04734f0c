"""Simulated nodules: detection in random phantoms by the detector, and by a reference that knows the generator.

Other phantoms are pressed one place after another, to judge where the detector proposes to press next (`sequential`).

`judge_detector` gives the same figures for any other detector, on the same phantoms and presses.
"""

from collections.abc import Iterator, Sequence
from dataclasses import asdict
from typing import Any

from studies.compared import Compared
from studies.nodules.detector import detect
from studies.nodules.judge import (
    GOOD_AUC,
    Answer,
    Detector,
    Judged,
    by_cell,
    differences,
    judge,
    overall,
    reliability,
)
from studies.nodules.phantoms import Phantom, draw_phantom, press
from studies.nodules.ranges import PHANTOMS, RANGES
from studies.nodules.reference import Reference, correction
from studies.nodules.sequential import curves, gains, judged_sequence, saved
from studies.pieces import HERE, Piece, ReportShare, Work, chunks, part_of, rows_of
from studies.running import Progress, tables_of

LEARNED = 200
"""Phantoms on which the reference learns the correction of its probabilities."""
QUICK_PHANTOMS, QUICK_LEARNED = 24, 16
"""Judged and learned phantoms of a quick run."""
SEQUENCES, QUICK_SEQUENCES = 200, 4
"""Phantoms that are pressed one place after another, and those of a quick run."""
CHUNK = 10
"""Phantoms of a piece of work."""
_LEARNING_SEED = 1_000_000
"""Seeds from here on are of phantoms that are not judged."""
_SEQUENCE_SEED = 3_000_100
"""Seeds from here on are of phantoms that are pressed one place after another; nothing was chosen with them."""
_SEEDS_APART = 1000
DETECTOR = "detector_"
"""Beginning of the names of the detector's figures; those of the reference have no such beginning."""
tables = tables_of(
    *("cells", "nodules", "reliability", "differences", "sequences", "saved", "gains"),
    *(DETECTOR + name for name in ("cells", "nodules", "reliability")),
)
_CELL = ("depth_mm_from", "size_mm_from", "ratio_from")
COMPARED = (
    Compared("cells", "auc", "more", _CELL, absolute=0.05),
    Compared("overall", "auc", "more", absolute=0.02),
    Compared("overall", "within_3_mm", "more", counted="good_nodules"),
    Compared("detector_cells", "auc", "more", _CELL, absolute=0.05),
    Compared("detector_overall", "auc", "more", absolute=0.02),
    Compared("sequences", "auc", "more", ("way", "presses"), absolute=0.05),
)


def run(quick: bool, seed: int, progress: Progress, work: Work = HERE) -> dict[str, Any]:
    """Judge the reference and the detector.

    Args:
        quick: few phantoms.
        seed: source of all phantoms; 0 gives the judged ones.
    """
    phantoms, learned = (QUICK_PHANTOMS, QUICK_LEARNED) if quick else (PHANTOMS, LEARNED)
    reference = learn(learned, work, part_of(progress, 0.0, 0.3))
    seeds = judged_seeds(seed, phantoms)
    judged = judge_detector(reference, seeds, work, part_of(progress, 0.3, 0.6))
    detected = judge_detector(detect, seeds, work, part_of(progress, 0.6, 0.7))
    first = _SEQUENCE_SEED + _SEEDS_APART * seed
    pressed = range(first, first + (QUICK_SEQUENCES if quick else SEQUENCES))
    rows = _all([(judged_sequence, (one,)) for one in pressed], work, part_of(progress, 0.7, 1.0))
    good = by_cell(judged)
    return figures(judged, good) | {
        **{DETECTOR + name: value for name, value in figures(detected, good).items() if name != "good_auc"},
        "differences": differences(detected, judged),
        "sequences": curves(rows),
        "saved": saved(rows),
        "gains": gains(rows),
        "ranges": asdict(RANGES),
        "correction": {"slope": reference.slope, "offset": reference.offset, "phantoms": learned},
    }


def judge_detector(
    detector: Detector, seeds: Sequence[int], work: Work = HERE, progress: ReportShare = lambda _: None
) -> list[Judged]:
    """Judge any detector on the phantoms of these seeds; all are reported.

    Args:
        detector: the detector. To run on other processors it must be picklable, such as a function of a module.
        seeds: of the phantoms, such as `judged_seeds()`.
        work: runs the pieces.
        progress: receives the share done, 0..1.

    Raises:
        ValueError: an answer is malformed.
    """
    return _all([(_judged, (detector, part)) for part in chunks(seeds, CHUNK)], work, progress)


def judged_seeds(seed: int = 0, phantoms: int = PHANTOMS) -> range:
    """Return the seeds of the judged phantoms."""
    return range(_SEEDS_APART * seed, _SEEDS_APART * seed + phantoms)


def learn(phantoms: int, work: Work, progress: ReportShare) -> Reference:
    """Return the reference, with probabilities corrected on phantoms that are not judged."""
    seeds = range(_LEARNING_SEED, _LEARNING_SEED + phantoms)
    return correction(_all([(_answered, (part,)) for part in chunks(seeds, CHUNK)], work, progress))


def _all(pieces: list[Piece], work: Work, progress: ReportShare) -> list[Any]:
    """Run pieces; return all that they yield."""
    return rows_of({"all": pieces}, work, progress)["all"]


def figures(judged: Sequence[Judged], good: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Return all figures of a detector.

    Args:
        judged: its answers to the phantoms.
        good: rows of `by_cell` of the reference; place and order of size are judged where its AUC is `GOOD_AUC`.
    """
    return {
        "good_auc": GOOD_AUC,
        "cells": by_cell(judged),
        "overall": overall(judged, good),
        "reliability": reliability(judged),
        "nodules": [row for each in judged for row in _nodules(each)],
    }


def _nodules(judged: Judged) -> Iterator[dict[str, Any]]:
    """Yield a row for each true nodule of a phantom."""
    for site in judged.sites:
        if site.sphere is not None:
            found = site.found
            yield {
                "phantom": judged.seed,
                **asdict(site.sphere),
                "score": site.score,
                "found_x_mm": None if found is None else found.x_mm,
                "found_y_mm": None if found is None else found.y_mm,
                "found_size_mm": None if found is None else found.size_mm,
                "probability": None if found is None else found.probability,
            }


def _judged(detector: Detector, seeds: Sequence[int]) -> Iterator[Judged]:
    for seed in seeds:
        phantom = draw_phantom(seed)
        yield judge(phantom, detector(press(phantom)))


def _answered(seeds: Sequence[int]) -> Iterator[tuple[Phantom, Answer]]:
    for seed in seeds:
        phantom = draw_phantom(seed)
        yield phantom, Reference()(press(phantom))
