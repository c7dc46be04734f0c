"""The shipped thermal identification on sensors and objects of a second, independent world."""

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

from studies.compared import Compared
from studies.pieces import HERE, Piece, ReportShare, Work, part_of, results_of
from studies.running import Progress, tables_of
from studies.second_world.figure import plot
from studies.second_world.touches import Kind, simulate_touches
from studies.thermal_identification.answers import Answered, by_fingers, knowledge_of
from studies.thermal_identification.pieces import Examples, by_network, learn
from studies.thermal_identification.shares import errors, reliability, shares
from studies.thermal_identification.situations import FOUR, STAGGERED_K, TWELVE, calibrated

__all__ = ["measure", "plot", "run", "tables"]

FINGERS = {"1 finger": 1, "2 staggered": 2, "5 staggered": 5}
"""Number of fingers of each method."""
NETWORK = "network"
LIFTED_S = 0.4
"""Time in contact beyond the last answer, s. The answers count from a force of 0.3 N."""
tables = tables_of("accuracy", "by_material", "by_kind", "errors", "reliability")
COMPARED = (
    Compared("accuracy", "right", "more", ("materials", "method", "t_s"), counted="touches"),
    Compared("accuracy", "wrong", "less", ("materials", "method", "t_s"), counted="touches"),
    Compared("accuracy", "object_rms_k", "less", ("materials", "method", "t_s"), absolute=0.05, relative=0.2),
)


@dataclass(frozen=True, slots=True)
class Set:
    """Materials to distinguish, and the size of the study of them; touches are counted per kind and material.

    Attributes:
        names: the materials.
        kinds: number of kinds of sensors.
        calibration: touches for calibration.
        learning: touches for training the network of one finger.
        test: judged touches, of five fingers each.
    """

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


QUICK = Sizes((Set(FOUR, 2, 10, 40, 4),), (0.5, 1.0, 2.0, 3.0, 5.0))
FULL = Sizes((Set(FOUR, 6, 25, 250, 25), Set(TWELVE, 2, 25, 100, 10)), (0.5, 1.0, 2.0, 3.0, 5.0, 7.0, 10.0))


def run(quick: bool, seed: int, progress: Progress, work: Work = HERE) -> dict[str, Any]:
    """Measure everything.

    Args:
        quick: few kinds of sensors and touches.
        seed: seed of every touch.
        progress: receives the share done, 0..1.
        work: runs the pieces.
    """
    return measure(QUICK if quick else FULL, seed, progress, work)


def measure(sizes: Sizes, seed: int, progress: ReportShare = lambda _: None, work: Work = HERE) -> dict[str, Any]:
    """Measure a study of these sizes."""
    answers: dict[int, list[Answered]] = {}
    by_kind: list[dict[str, Any]] = []
    for number, each in enumerate(sizes.sets):
        part = part_of(progress, number / len(sizes.sets), (number + 1) / len(sizes.sets))
        found = _judge(each, [1000 * seed + kind for kind in range(each.kinds)], sizes.times_s, part, work)
        answers[len(each.names)] = [answer for mine in found.values() for answer in mine]
        by_kind += [row for kind, mine in found.items() for row in shares(mine, materials=len(each.names), kind=kind)]
    return {
        "sets": [asdict(each) for each in sizes.sets],
        "accuracy": [row for count, each in answers.items() for row in shares(each, materials=count)],
        "by_kind": by_kind,
        "by_material": [
            row
            for count, each in answers.items()
            for name in dict.fromkeys(one.truth for one in each)
            for row in shares([one for one in each if one.truth == name], materials=count, material=name)
        ],
        "errors": [row for count, each in answers.items() for row in errors(each, materials=count)],
        "reliability": [row for count, each in answers.items() for row in reliability(each, materials=count)],
    }


def _judge(
    each: Set, kinds: Sequence[int], times_s: Sequence[float], progress: ReportShare, work: Work
) -> dict[int, list[Answered]]:
    """Return the answers of all methods about one set of materials, by kind of sensor."""
    cases = [(kind, name) for kind in kinds for name in each.names]
    pieces: dict[str, list[Piece]] = {
        "tables": [(calibrate, (kind, each.names, each.calibration, times_s[-1] + LIFTED_S)) for kind in kinds],
        "learning": [(examples, (*case, each.learning, times_s)) for case in cases],
    }
    prepared = results_of(pieces, work, part_of(progress, 0.0, 0.5))
    tables = dict(zip(kinds, prepared["tables"], strict=True))
    learned = _by_kind(cases, prepared["learning"])
    pieces = {
        "networks": [
            (learn, (learned[kind].rows[t_s], learned[kind].materials, learned[kind].above_k, kind))
            for kind in kinds
            for t_s in times_s
        ],
        "answers": [(examine, (kind, name, each.test, tables[kind], times_s)) for kind, name in cases],
    }
    judged = results_of(pieces, work, part_of(progress, 0.5, 1.0))
    networks = iter(judged["networks"])
    tested = _by_kind(cases, [touches for _, touches in judged["answers"]])
    found: dict[int, list[Answered]] = {kind: [] for kind in kinds}
    for (kind, _), (answers, _) in zip(cases, judged["answers"], strict=True):
        found[kind] += answers
    for kind in kinds:
        for t_s in times_s:
            found[kind] += by_network(next(networks), NETWORK, tested[kind], t_s)
    return found


def _by_kind(cases: Sequence[tuple[int, str]], parts: Sequence[Examples]) -> dict[int, Examples]:
    """Join the examples of each kind of sensor."""
    grouped: dict[int, list[Examples]] = {}
    for (kind, _), part in zip(cases, parts, strict=True):
        grouped.setdefault(kind, []).append(part)
    return {kind: Examples.together(each) for kind, each in grouped.items()}


def calibrate(kind: int, names: Sequence[str], touches: int, seconds: float) -> str:
    """Return the table that the product's calibration makes of a kind of sensor, as JSON.

    Each of the kind's units makes a fifth of the touches. Labels have the object's temperature.
    """
    drawn = Kind.draw(kind)
    units = [Kind(drawn.sensor, (unit,)) for unit in drawn.units]
    hands = {
        name: [
            hand
            for seed, unit in enumerate(units, start=10)
            for hand in simulate_touches(unit, name, seed, touches // len(units), seconds=seconds)
        ]
        for name in names
    }
    return calibrated(hands).model_dump_json()


def examples(kind: int, name: str, touches: int, times_s: Sequence[float]) -> Examples:
    """Return touches of the kind's first unit as examples for training."""
    hands = list(simulate_touches(Kind.draw(kind), name, 1, touches, seconds=times_s[-1] + LIFTED_S))
    return Examples.of(hands, 1, times_s)


def examine(
    kind: int, name: str, touches: int, table: str, times_s: Sequence[float]
) -> tuple[list[Answered], Examples]:
    """Return the estimator's answers to new touches, and the same touches as the network's examples."""
    seconds, knowledge = times_s[-1] + LIFTED_S, knowledge_of(table)
    hands = list(simulate_touches(Kind.draw(kind), name, 2, touches, preheats_k=STAGGERED_K, seconds=seconds))
    answers = [answer for hand in hands for answer in by_fingers(knowledge, hand, FINGERS, times_s)]
    return answers, Examples.of(hands, 1, times_s)
