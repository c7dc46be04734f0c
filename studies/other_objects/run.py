"""Objects warmer or colder than those of calibration, and thin ones: errors of the temperature and their stated ±."""

from dataclasses import dataclass
from typing import Any

from studies.compared import Compared
from studies.pieces import HERE, Piece, ReportShare, Work, chunks, part_of, results_of
from studies.running import Progress, tables_of
from studies.second_world.touches import USUAL, Objects
from studies.second_world.worlds import CHUNK, FINGERS, LIFTED_S, World, calibration_hands, judged_hands
from studies.thermal_identification.answers import Answered, by_fingers, knowledge_of
from studies.thermal_identification.shares import shares
from studies.thermal_identification.situations import FOUR, calibrated

WARM = Objects("6 to 14 K warmer", (6.0, 14.0))
OBJECTS = (USUAL, WARM, Objects("5 to 10 K colder", (-10.0, -5.0)), Objects("sheets of 1 mm", thickness_m=1e-3))
"""Judged objects. Skin in a room is 10 K warmer."""
LABELLED, UNLABELLED, BOTH = "within 3 K", "within 3 K, temperatures unknown", "within 3 K, and warmer"
CALIBRATIONS = (LABELLED, UNLABELLED, BOTH)
"""Objects of each calibration."""
WARM_PREHEAT_K = 18.0
"""Plate above ambient for warm objects of calibration, K; it must differ from them."""
WARM_SHARE = 0.4
"""Share of warm objects in the last calibration."""
LASTS_S = 7.05
"""Time in contact of a calibration touch, s."""
FIRST_KIND = 10
"""First kind of sensor of a seed; the study `second-world` uses smaller ones."""
tables = tables_of("shares")
_ROW = ("world", "calibration", "objects", "method", "t_s")
COMPARED = (
    Compared("shares", "wrong", "less", _ROW, counted="touches"),
    Compared("shares", "named", "more", _ROW, counted="touches"),
    Compared("shares", "object_stated", "more", _ROW, counted="touches"),
    Compared("shares", "object_within_sd", "more", _ROW, counted="object_errors"),
    Compared("shares", "object_rms_k", "less", _ROW, absolute=0.1, relative=0.2),
)


@dataclass(frozen=True, slots=True)
class Sizes:
    """Size of the study.

    Attributes:
        kinds: number of kinds of sensors in each world.
        calibration: calibration touches of each material.
        test: judged touches of each material and sort of objects.
        times_s: times of the judged answers, s after contact.
    """

    kinds: int
    calibration: int
    test: int
    times_s: tuple[float, ...]


QUICK = Sizes(1, 10, 2, (1.0, 3.0, 6.0))
FULL = Sizes(3, 25, 8, (0.5, 1.0, 2.0, 3.0, 5.0, 6.0))


def run(quick: bool, seed: int, progress: Progress, work: Work = HERE) -> dict[str, Any]:
    """Measure everything; a quick run has few kinds of sensors and touches."""
    return measure(QUICK if quick else FULL, seed, progress, work)


def measure(sizes: Sizes, seed: int, progress: ReportShare = lambda _: None, work: Work = HERE) -> dict[str, Any]:
    """Measure a study of these sizes."""
    worlds: tuple[World, ...] = ("A", "B")
    sensors = [(world, 1000 * seed + FIRST_KIND + kind) for world in worlds for kind in range(sizes.kinds)]
    calibrating: dict[tuple[World, int], list[Piece]] = {
        sensor: [(calibrate, (*sensor, how, sizes.calibration)) for how in CALIBRATIONS] for sensor in sensors
    }
    known = results_of(calibrating, work, part_of(progress, 0.0, 0.25))
    judging: dict[tuple[tuple[World, int], Objects], list[Piece]] = {
        (sensor, objects): [
            (answer, (*sensor, name, part, objects, dict(zip(CALIBRATIONS, known[sensor], strict=True)), sizes.times_s))
            for name in FOUR
            for part in chunks(range(sizes.test), CHUNK)
        ]
        for sensor in sensors
        for objects in OBJECTS
    }
    found: dict[tuple[World, str, str], list[Answered]] = {}
    for ((world, _), objects), judged in results_of(judging, work, part_of(progress, 0.25, 1.0)).items():
        for by_calibration in judged:
            for how, answers in by_calibration.items():
                found.setdefault((world, how, objects.name), []).extend(answers)
    return {
        "kinds": sizes.kinds,
        "calibration": sizes.calibration,
        "shares": [
            row
            for (world, how, objects), answers in found.items()
            for row in shares(answers, world=world, calibration=how, objects=objects)
        ],
    }


def calibrate(world: World, kind: int, how: str, touches: int) -> str:
    """Return the table that the product's calibration makes of a kind of sensor, as JSON."""
    warm = round(WARM_SHARE * touches) if how == BOTH else 0
    hands = {name: calibration_hands(world, kind, name, touches - warm, LASTS_S) for name in FOUR}
    if warm:
        for name in FOUR:
            hands[name] += calibration_hands(world, kind, name, warm, LASTS_S, WARM, WARM_PREHEAT_K, touches - warm)
    return calibrated(hands, labelled=how != UNLABELLED).model_dump_json()


def answer(
    world: World,
    kind: int,
    name: str,
    numbers: range,
    objects: Objects,
    known: dict[str, str],
    times_s: tuple[float, ...],
) -> dict[str, list[Answered]]:
    """Return the answers to touches of these objects by each calibration."""
    hands = judged_hands(world, kind, name, numbers, times_s[-1] + LIFTED_S, objects)
    return {
        how: [each for hand in hands for each in by_fingers(knowledge_of(table), hand, FINGERS, times_s)]
        for how, table in known.items()
    }
