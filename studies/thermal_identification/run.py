"""Thermal identification of material and temperature: speed, accuracy, cost, and failures of each method."""

import os
import platform
from dataclasses import dataclass
from importlib.metadata import version
from typing import Any

import numpy as np

from common.scenes.materials import materials
from remote_site.thermal.material_table import MaterialTable
from remote_site.thermal.touch_hypotheses import FOREIGN
from sim_sensors.physics.ssr_converter import NOISE_C
from studies.compared import Compared
from studies.pieces import HERE, Piece, ReportShare, Work, chunks, one_thread, part_of, results_of
from studies.running import Progress, tables_of
from studies.thermal_identification.answers import Answered, knowledge_of
from studies.thermal_identification.bound import bounds
from studies.thermal_identification.cost import BASELINE, cost_by_materials, costs
from studies.thermal_identification.maps import Axes, cell_rows, map_cells
from studies.thermal_identification.pieces import ONE, Calibration, Examples, by_reference, calibrate, examine, examples
from studies.thermal_identification.reference import Reference, train
from studies.thermal_identification.shares import errors, reliability, shares
from studies.thermal_identification.situations import EQUAL_K, FOUR, SECONDS, STAGGERED_K, TWELVE, Situation, touched

FINGERS = (2, 3, 5)
REFERENCE, REFERENCE_TWO = "reference", "reference, 2 staggered"
WITH_STRANGERS = "1 finger, strangers among them"
_CHUNK = 250
_TEST_CHUNK, _HAND_CHUNK = 30, 10
_COST_CALIBRATION_S = 2.05
"""Duration of the touches that calibrate the largest table, s; only the cost of that table matters."""
_SEEDS = {"calibration": 1, "learning": 100, "test": 2, "hands": 3, "maps": 4, "cost": 5}
tables = tables_of(
    *("accuracy", "errors", "reliability", "bounds", "difference", "contact", "spread", "untrained"),
    *("cost", "cost_by_materials"),
)
COMPARED = (
    Compared("accuracy", "right", "more", ("materials", "method", "t_s"), counted="touches"),
    Compared("accuracy", "wrong", "less", ("materials", "method", "t_s"), counted="touches"),
    Compared("accuracy", "named", "more", ("materials", "method", "t_s"), counted="touches"),
    Compared("accuracy", "object_stated", "more", ("materials", "method", "t_s"), counted="touches"),
    Compared("accuracy", "object_rms_k", "less", ("materials", "method", "t_s"), absolute=0.05, relative=0.2),
    Compared("cost", "ratio_all", "less", ("method",), relative=0.3),
)


@dataclass(frozen=True, slots=True)
class Sizes:
    """Size of the study; touches are counted per material.

    Attributes:
        calibration: touches for calibration.
        learning: touches for training the reference, with four and with twelve materials, and hands of two fingers with
            four materials. With 0 hands there is no reference of two fingers.
        test: judged touches of one finger, with four and with twelve materials; 0 leaves out twelve materials.
        hands: judged hands, with four and with twelve materials; 0 for none.
        times_s, hand_times_s, reference_times_s: times of the judged answers, s after contact.
        maps: axes of the maps.
        cost_touches: touches behind a cost.
        cost_calibration: touches that calibrate the largest table, whose accuracy does not matter.
        cost_materials: numbers of materials.
        cost_s: costed part of a touch, s after contact.
        seconds: duration of a touch for judging or learning, s.
        calibration_s: duration of a touch for calibration, s.
    """

    learning: tuple[int, int, int]
    test: tuple[int, int]
    hands: tuple[int, int]
    hand_times_s: tuple[float, ...]
    reference_times_s: tuple[float, ...]
    maps: Axes
    cost_touches: int
    cost_calibration: int
    calibration: int = 25
    times_s: tuple[float, ...] = (0.25, 0.5, 1.0, 1.5, 2.0, 3.0, 5.0, 7.0)
    cost_materials: tuple[int, ...] = (4, 8, 12, 24)
    cost_s: float = 2.0
    seconds: float = SECONDS
    calibration_s: float = SECONDS


QUICK = Sizes(
    learning=(400, 60, 0),
    test=(16, 3),
    hands=(4, 0),
    hand_times_s=(0.25, 0.5, 1.0, 1.5),
    reference_times_s=(0.5, 1.0, 2.0, 3.0, 7.0),
    maps=Axes(
        differences_k=(-4.0, 0.0, 3.0, 10.0),
        noises_k=(NOISE_C, 0.1),
        changes=((0.5, 0.0), (1.5, 0.0), (1.0, 0.3)),
        spreads=(0.15, 0.5),
        foreign=6,
        touches=2,
        times_s=(0.5, 1.0, 2.0, 3.0, 5.0),
        seconds=5.05,
    ),
    cost_touches=4,
    cost_calibration=8,
)
FULL = Sizes(
    learning=(1250, 1000, 1000),
    test=(150, 40),
    hands=(24, 5),
    hand_times_s=(0.25, 0.5, 1.0, 1.5, 2.0, 3.0),
    reference_times_s=(0.5, 1.0, 1.5, 2.0, 3.0, 5.0, 7.0),
    maps=Axes(
        differences_k=(-8.0, -4.0, -2.0, -1.0, 0.0, 1.0, 2.0, 4.0, 8.0, 12.0),
        noises_k=(NOISE_C, 0.05, 0.15),
        changes=(*((at_s, 0.0) for at_s in (0.3, 0.6, 1.0, 2.0, 4.0)), *((1.0, share) for share in (0.3, 0.6, 2.0))),
        spreads=(0.05, 0.15, 0.3, 0.5, 0.8),
        foreign=18,
        touches=8,
        times_s=(0.5, 1.0, 1.5, 2.0, 3.0, 5.0, 7.0),
    ),
    cost_touches=20,
    cost_calibration=12,
)


def run(quick: bool, seed: int, progress: Progress, work: Work = HERE) -> dict[str, Any]:
    """Measure everything; the costs are measured in this process after all other work.

    A quick run takes less than two minutes on two processors instead of less than twenty.
    """
    return measure(QUICK if quick else FULL, seed, progress, work)


def measure(sizes: Sizes, seed: int, progress: ReportShare = lambda _: None, work: Work = HERE) -> dict[str, Any]:
    """Measure a study of these sizes."""
    prepared = _prepare(sizes, seed, work, part_of(progress, 0.0, 0.35))
    judged, references = _judge(sizes, seed, prepared, work, part_of(progress, 0.35, 0.95))
    with one_thread():
        cost = _cost(sizes, seed, prepared, references)
    progress(1.0)
    return {
        "machine": {
            "processors": os.cpu_count(),
            "python": platform.python_version(),
            "numpy": np.__version__,
            "scikit-learn": version("scikit-learn"),
        },
        "calibration_touches": sizes.calibration,
        "learning_touches": {"4": sizes.learning[0], "12": sizes.learning[1], "4, two fingers": sizes.learning[2]},
        **judged,
        "cost_baseline": BASELINE,
        **cost,
    }


@dataclass(frozen=True, slots=True)
class _Prepared:
    """Preparations of the study.

    Attributes:
        by_count: calibration by number of materials.
        by_noise: table with four materials by noise of a reading, K.
        largest: table with the most materials, for its cost.
        learning: examples for training the references.
        bounds: rows of the information limit.
    """

    by_count: dict[int, Calibration]
    by_noise: dict[float, str]
    largest: str
    learning: dict[str, Examples]
    bounds: list[dict[str, Any]]


def _materials(sizes: Sizes) -> dict[int, tuple[str, ...]]:
    """Return the sets of materials to distinguish, by their number."""
    return {len(names): names for names, touches in zip((FOUR, TWELVE), sizes.test, strict=True) if touches}


def _prepare(sizes: Sizes, seed: int, work: Work, progress: ReportShare) -> _Prepared:
    calibration_seed, learning_seed = (_seed(seed, what) for what in ("calibration", "learning"))
    noises_k = [noise_k for noise_k in sizes.maps.noises_k if noise_k != NOISE_C]
    largest = (*TWELVE, *(name for name in materials() if name not in TWELVE))[: max(sizes.cost_materials)]

    def calibration(names: tuple[str, ...], noise_k: float, times_s: tuple[float, ...] = ()) -> Piece:
        return calibrate, (names, sizes.calibration, calibration_seed, noise_k, sizes.calibration_s, times_s)

    sets = _materials(sizes)
    pieces: dict[str, list[Piece]] = {
        "largest": [(calibrate, (largest, sizes.cost_calibration, calibration_seed, NOISE_C, _COST_CALIBRATION_S, ()))],
        "sets": [calibration(names, NOISE_C, sizes.times_s) for names in sets.values()],
        "noises": [calibration(FOUR, noise_k) for noise_k in noises_k],
    }
    learning = {
        "4": (FOUR, sizes.learning[0], EQUAL_K[:1], 0),
        "12": (TWELVE, sizes.learning[1] if len(TWELVE) in sets else 0, EQUAL_K[:1], 0),
        "two": (FOUR, sizes.learning[2], STAGGERED_K[:2], 1000),
    }
    for what, (names, touches, preheats_k, more) in learning.items():
        times_s = [t for t in sizes.reference_times_s if what != "two" or t <= sizes.hand_times_s[-1]]
        pieces[what] = [
            (
                examples,
                (Situation(name, learning_seed + more + n, part, preheats_k, seconds=sizes.seconds), times_s),
            )
            for name in names
            for n, part in enumerate(map(len, chunks(range(touches), _CHUNK)))
        ]
    plates = {"equal": EQUAL_K, "staggered": STAGGERED_K}
    pieces["bounds"] = [(bounds, (name, plates_k, sizes.times_s)) for name in FOUR for plates_k in plates.values()]
    done = results_of(pieces, work, progress)
    by_count = dict(zip(sets, done["sets"], strict=True))
    noisy = zip(noises_k, done["noises"], strict=True)
    return _Prepared(
        by_count,
        {NOISE_C: by_count[len(FOUR)].table} | {noise_k: each.table for noise_k, each in noisy},
        done["largest"][0].table,
        {what: Examples.together(done[what]) for what in learning if done[what]},
        [
            {"plates": which} | row
            for which, rows in zip((*plates,) * len(FOUR), done["bounds"], strict=True)
            for row in rows
        ],
    )


def _judge(
    sizes: Sizes, seed: int, prepared: _Prepared, work: Work, progress: ReportShare
) -> tuple[dict[str, list[dict[str, Any]]], dict[float, Reference]]:
    """Return all tables but the costs, and the references for one finger and four materials, by time."""
    keys = [(what, t_s) for what, each in prepared.learning.items() for t_s in each.rows]
    pieces: dict[str, list[Piece]] = {
        "references": [(train, (prepared.learning[what].rows[t_s], *prepared.learning[what][1:])) for what, t_s in keys]
    }
    for place, (count, names) in enumerate(_materials(sizes).items()):
        pieces[f"hands {count}"] = _hand_pieces(sizes, seed, names, sizes.hands[place], prepared.by_count[count])
        pieces[f"one {count}"] = _one_pieces(sizes, seed, names, sizes.test[place], prepared.by_count[count])
    cells = map_cells(sizes.maps, prepared.by_noise, _seed(seed, "maps"))
    pieces |= {name: [piece for cell in each for piece in cell.pieces] for name, each in cells.items()}
    results = results_of(pieces, work, progress)
    references = dict(zip(keys, results["references"], strict=True))
    answers: dict[int, list[Answered]] = {}
    for count in prepared.by_count:
        ones, hands = results[f"one {count}"], results[f"hands {count}"]
        answers[count] = [answer for each, _ in (*ones, *hands) for answer in each]
        tested = Examples.together([each for _, each in ones])
        for t_s in sizes.reference_times_s:
            answers[count] += by_reference(references[str(count), t_s], REFERENCE, tested, t_s)
        if count == len(FOUR) and "two" in prepared.learning and hands:
            staggered = Examples.together([each for _, each in hands[len(hands) // 2 :]])
            for t_s in staggered.rows:
                answers[count] += by_reference(references["two", t_s], REFERENCE_TWO, staggered, t_s)
    strangers = [answer for each in results["untrained"] for answers_k in each for answer in answers_k]
    rows = {
        "accuracy": [row for count, each in answers.items() for row in shares(each, materials=count)],
        "errors": [row for count, each in answers.items() for row in errors(each, materials=count)],
        "reliability": [
            *(row for count, each in answers.items() for row in reliability(each, materials=count)),
            *_with_strangers(answers[len(FOUR)], strangers),
        ],
        "bounds": prepared.bounds,
        **{name: cell_rows(each, results[name]) for name, each in cells.items()},
    }
    return rows, {t_s: reference for (what, t_s), reference in references.items() if what == str(len(FOUR))}


def _with_strangers(answers: list[Answered], strangers: list[Answered]) -> list[dict[str, Any]]:
    """Return the reliability of one finger's probabilities with the prior's share of uncalibrated materials."""
    ones = [answer for answer in answers if answer.method == ONE]
    rows = reliability(ones, strangers, FOREIGN, materials=len(FOUR))
    return [row | {"method": WITH_STRANGERS} for row in rows]


def _hand_pieces(sizes: Sizes, seed: int, names: tuple[str, ...], hands: int, calibration: Calibration) -> list[Piece]:
    """Return pieces with hands of equal plates, then of staggered ones; the reference gets their first two fingers."""
    last_s = sizes.hand_times_s[-1]
    learned = 2, [t for t in sizes.reference_times_s if t <= last_s]
    return [
        (
            examine,
            (
                Situation(name, _seed(seed, "hands") + number, part, plates_k, seconds=last_s + 0.05),
                Calibration(calibration.table, ()),
                {f"{fingers} {plates}": fingers for fingers in FINGERS},
                sizes.hand_times_s,
                learned,
            ),
        )
        for plates, plates_k in (("equal", EQUAL_K), ("staggered", STAGGERED_K))
        for name in names
        for number, part in enumerate(map(len, chunks(range(hands), _HAND_CHUNK)))
    ]


def _one_pieces(sizes: Sizes, seed: int, names: tuple[str, ...], touches: int, calibration: Calibration) -> list[Piece]:
    """Return pieces with touches of one finger."""
    learned = 1, sizes.reference_times_s
    return [
        (
            examine,
            (
                Situation(name, _seed(seed, "test") + number, part, seconds=sizes.seconds),
                calibration,
                {ONE: 1},
                sizes.times_s,
                learned,
            ),
        )
        for name in names
        for number, part in enumerate(map(len, chunks(range(touches), _TEST_CHUNK)))
    ]


def _cost(sizes: Sizes, seed: int, prepared: _Prepared, references: dict[float, Reference]) -> dict[str, Any]:
    """Measure the costs; no other work may run meanwhile."""
    hands = [
        hand
        for name in FOUR
        for hand in touched(
            Situation(
                name,
                _seed(seed, "cost"),
                max(sizes.cost_touches // len(FOUR), 1),
                STAGGERED_K,
                seconds=sizes.cost_s + 0.05,
            )
        )
    ]
    t_s, readings = min(references), round(100 * sizes.cost_s)
    row = prepared.learning[str(len(FOUR))].rows[t_s][:1]
    largest = MaterialTable.model_validate_json(prepared.largest)
    knowledge = knowledge_of(prepared.by_count[len(FOUR)].table)
    return {
        "cost": costs(knowledge, hands, (1, *FINGERS), references[t_s], row, readings),
        "cost_by_materials": cost_by_materials(largest, hands, sizes.cost_materials, readings),
    }


def _seed(seed: int, what: str) -> int:
    """Return the seed of a part; seeds of different parts never coincide."""
    return 100_000 * seed + 10_000 * list(_SEEDS).index(what) + _SEEDS[what]
