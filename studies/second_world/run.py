"""The shipped thermal identification in two worlds of sensors and objects, beside a learned reference."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

from studies.compared import Compared
from studies.pieces import HERE, Piece, ReportShare, Work, chunks, part_of, results_of
from studies.running import Progress, tables_of
from studies.second_world.figure import reference_of
from studies.second_world.worlds import (
    CHUNK,
    FINGERS,
    LIFTED_S,
    UNITS,
    World,
    calibration_hands,
    judged_hands,
    learning_hands,
)
from studies.thermal_identification.answers import SHIPPED_RULE, Answered, by_fingers, knowledge_of
from studies.thermal_identification.operating_curve import RULES, operating_curve
from studies.thermal_identification.pieces import Examples, by_reference
from studies.thermal_identification.reference import train
from studies.thermal_identification.shares import errors, reliability, shares
from studies.thermal_identification.situations import FOUR, TWELVE, calibrated

STRANGERS = ("copper", "glass", "rubber", "skin_dermis")
"""Materials that are touched too where they were not calibrated."""
STRANGE_TOUCHES = 5
"""Number of touches of each of them by each kind of sensor."""
tables = tables_of("accuracy", "errors", "reliability", "names")
_ROW = ("world", "materials", "method", "t_s")
COMPARED = (
    Compared("accuracy", "right", "more", _ROW, counted="touches"),
    Compared("accuracy", "wrong", "less", _ROW, counted="touches"),
    Compared("accuracy", "named", "more", _ROW, counted="touches"),
    Compared("accuracy", "object_stated", "more", _ROW, counted="touches"),
    Compared("accuracy", "object_within_sd", "more", _ROW, counted="object_errors"),
    Compared("accuracy", "object_rms_k", "less", _ROW, absolute=0.05, relative=0.2),
)


@dataclass(frozen=True, slots=True)
class Set:
    """Materials to distinguish in one world, and the size of the study of them, touches by kind and material.

    Attributes:
        world: the world.
        names: the materials.
        kinds: number of kinds of sensors.
        calibration: touches of one finger for calibration.
        learning: touches of five fingers from which the reference learns, in fifths.
        test: judged touches of five fingers.
    """

    world: World
    names: tuple[str, ...]
    kinds: int
    calibration: int
    learning: int
    test: int


@dataclass(frozen=True, slots=True)
class Sizes:
    """Size of the study: its sets of materials, and the times of the judged answers, s after contact."""

    sets: tuple[Set, ...]
    times_s: tuple[float, ...]


QUICK = Sizes((Set("A", FOUR, 1, 10, 100, 4), Set("B", FOUR, 1, 10, 100, 4)), (0.5, 1.0, 2.0, 3.0, 5.0))
"""The reference learns from ten times the touches of calibration, as with the four materials of a full run."""
FULL = Sizes(
    (
        Set("A", FOUR, 4, 25, 250, 25),
        Set("B", FOUR, 4, 25, 250, 25),
        Set("A", TWELVE, 2, 25, 100, 10),
        Set("B", TWELVE, 2, 25, 100, 10),
    ),
    (0.5, 1.0, 2.0, 3.0, 5.0, 7.0, 10.0),
)


def run(quick: bool, seed: int, progress: Progress, work: Work = HERE) -> dict[str, Any]:
    """Measure everything; a quick run has few kinds of sensors and touches."""
    return measure(QUICK if quick else FULL, seed, progress, work)


def measure(sizes: Sizes, seed: int, progress: ReportShare = lambda _: None, work: Work = HERE) -> dict[str, Any]:
    """Measure a study of these sizes."""
    cases = [(each, 1000 * seed + kind) for each in sizes.sets for kind in range(each.kinds)]
    answers: dict[tuple[str, int], list[Answered]] = {}
    last: dict[tuple[str, int], tuple[list[Answered], list[Answered]]] = {}
    for (case, _), mine in zip(cases, _judge(cases, sizes.times_s, progress, work), strict=True):
        key = case.world, len(case.names)
        for one in mine:
            if one.truth in case.names and one.rule in (None, SHIPPED_RULE):
                answers.setdefault(key, []).append(one)
            if one.t_s == sizes.times_s[-1]:
                last.setdefault(key, ([], []))[one.truth not in case.names].append(one)
    sets: list[tuple[dict[str, Any], list[Answered]]] = [
        ({"world": world, "materials": count}, each) for (world, count), each in answers.items()
    ]
    return {
        "sets": [asdict(each) for each in sizes.sets],
        "accuracy": [row for where, each in sets for row in shares(each, **where)],
        "errors": [row for where, each in sets for row in errors(each, **where)],
        "reliability": [row for where, each in sets for row in reliability(each, **where)],
        "names": [
            row for (world, count), each in last.items() for row in operating_curve(*each, world=world, materials=count)
        ],
    }


_Case = tuple[Set, int]
"""One kind of sensor, by its number, in a set of materials."""


def _judge(cases: Sequence[_Case], times_s: Sequence[float], progress: ReportShare, work: Work) -> list[list[Answered]]:
    """Return the answers of all methods in each case."""
    seconds = times_s[-1] + LIFTED_S
    calibrating: dict[tuple[str, _Case], list[Piece]] = {
        ("table", (each, kind)): [(calibrate, (each.world, kind, each.names, each.calibration, seconds))]
        for each, kind in cases
    }
    learning: dict[tuple[str, _Case], list[Piece]] = {
        ("learned", (each, kind)): [
            (examples, (each.world, kind, name, turn, each.learning // UNITS, times_s))
            for name in each.names
            for turn in range(UNITS)
        ]
        for each, kind in cases
    }
    prepared = results_of(calibrating | learning, work, part_of(progress, 0.0, 0.4))

    def judging(case: _Case, names: Sequence[str], touches: int) -> list[Piece]:
        (each, kind), (table,) = case, prepared["table", case]
        parts = chunks(range(touches), CHUNK)
        return [(examine, (each.world, kind, name, part, table, times_s)) for name in names for part in parts]

    strange = {case: [name for name in STRANGERS if name not in case[0].names] for case in cases}
    known = {("known", case): judging(case, case[0].names, case[0].test) for case in cases}
    others = {("strange", case): judging(case, strange[case], STRANGE_TOUCHES) for case in cases}
    judged = results_of(known | others, work, part_of(progress, 0.4, 0.8))
    referring: dict[_Case, list[Piece]] = {}
    for case in cases:
        learned = Examples.together(prepared["learned", case])
        tested = Examples.together([touches for _, touches in judged["known", case]])
        referring[case] = [
            (refer, (learned.part(fingers, t_s), tested.part(fingers, t_s), method))
            for method, fingers in FINGERS.items()
            for t_s in times_s
        ]
    referred = results_of(referring, work, part_of(progress, 0.8, 1.0))
    own = {case: [answers for answers, _ in judged["known", case] + judged["strange", case]] for case in cases}
    return [[answer for answers in own[case] + referred[case] for answer in answers] for case in cases]


def calibrate(world: World, kind: int, names: Sequence[str], touches: int, seconds: float) -> str:
    """Return the table that the product's calibration makes of a kind of sensor, as JSON.

    Labels have the object's temperature.
    """
    hands = {name: calibration_hands(world, kind, name, touches, seconds) for name in names}
    return calibrated(hands).model_dump_json()


def examples(world: World, kind: int, name: str, turn: int, touches: int, times_s: Sequence[float]) -> Examples:
    """Return touches of five fingers as examples for the reference."""
    hands = learning_hands(world, kind, name, turn, touches, times_s[-1] + LIFTED_S)
    return Examples.of(hands, UNITS, times_s)


def examine(
    world: World, kind: int, name: str, numbers: Sequence[int], table: str, times_s: Sequence[float]
) -> tuple[list[Answered], Examples]:
    """Return the estimator's answers to new touches, and the same touches as the reference's examples."""
    hands, knowledge = judged_hands(world, kind, name, numbers, times_s[-1] + LIFTED_S), knowledge_of(table)
    answers = [answer for hand in hands for answer in by_fingers(knowledge, hand, FINGERS, times_s, RULES)]
    return answers, Examples.of(hands, UNITS, times_s)


def refer(learned: Examples, tested: Examples, method: str) -> list[Answered]:
    """Return the answers of a reference of one time and number of fingers; `method` is that of the estimator."""
    ((t_s, rows),) = learned.rows.items()
    return by_reference(train(rows, learned.materials, learned.above_k), reference_of(method), tested, t_s)
