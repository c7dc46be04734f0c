"""Recorded touches of a soft fabric sensor: metal or wood, this estimator beside a linear classifier.

One set (a day, a placement) is left out in turn. Both methods learn from the others and judge the same noisy readings
of its touches. Cooled wood counts as wood. The operating curve shows how soon the estimator names a touch, and how many
wrongly, by rules of different caution. Flaws of the data:

- The recordings were smoothed by a centred filter over 0.5 s before they were published. Each time after contact thus
  sees up to 0.25 s ahead, for both methods. Noise (NOISE_K) and the steps of 12 bits over 0-100 C are added here.
- There are only two materials, always the same pieces. Wood was cooled, metal never was. A method may take cold for
  wood.
- The unheated sensor reads lower before it touches cooled wood: `both` has seen a part of the answer at contact.
- The room temperature is that of the set, the same for all of its touches. It is the median of the set's unheated
  readings before contact. The heated sensor alone would have it from a room thermometer.
- Two of three touches are of wood: naming wood each time is right in 67 %. Every method is therefore judged with two
  priors: materials as frequent as in its calibration (`counted`, as the estimator answers), and equally likely
  (`even`). An even prior aims at `balanced`, the mean of metal's share and wood's.
"""

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
from numpy.typing import NDArray

from remote_site.thermal.calibration.thermal_calibration import calibrate_thermal
from remote_site.thermal.material_table import MaterialTable
from remote_site.thermal.recorded.identify_thermal import identify_thermal
from remote_site.thermal.touch_start import RecordedTouch, find_touch
from remote_site.traces.trace_files import ThermalTrace, read_thermal
from studies.compared import Compared
from studies.counting import grouped
from studies.pieces import HERE, Piece, Work, part_of, results_of
from studies.running import Progress, Unavailable, data_folder, tables_of
from studies.thermal_identification.answers import Answered, by_fingers, knowledge_of
from studies.thermal_identification.operating_curve import RULES, operating_curve
from studies.thermal_identification.situations import Hand

Array = NDArray[np.float64]
Row = dict[str, Any]

TIMES_S = (0.5, 1.5, 4.0)
"""Judged times after first contact (force > 0.3 N), s."""
NAMED_UNTIL_S = 6.0
"""Time after first contact up to which a name counts, s."""
NOISE_K = 0.05
STEP_K = 100.0 / 4095.0
METAL, WOOD = "metal", "wood"
HEATED, HELPED, BOTH = "heated", "heated, calibrated beside the unheated one", "both"
PRIORS = ("counted", "even")
_BEFORE_S, _BLOCK_S, _READING_S = 0.25, 0.25, 0.01
_SHRINKAGE = 0.003
"""Share of each feature's variance that is added to it, so that the pooled covariance of few touches can be
inverted."""
_NAME = re.compile(r"set(\d+)_(\w+)_\d+")
tables = tables_of("accuracy", "errors", "names")
COMPARED = (
    Compared("accuracy", "share", "more", ("method", "sensors", "prior", "t_s"), counted="touches"),
    Compared("names", "named_6_s", "more", ("method", "caution"), counted="touches"),
    Compared("names", "wrong", "less", ("method", "caution"), counted="touches"),
)


@dataclass(frozen=True, slots=True)
class Touch:
    """One recording with added noise: its file, its set, its class, its material, and the room temperature, C."""

    file: str
    group: int
    kind: str
    material: str
    trace: ThermalTrace
    room_c: float


def run(quick: bool, seed: int, progress: Progress, work: Work = HERE) -> dict[str, Any]:
    """Leave each set out in turn and judge its touches, of the recordings `thermal_contact/setNN_CLASS_K.csv`.

    Args:
        quick: judge the first set only; all others are still learned from.
        seed: seed of the noise.

    Raises:
        Unavailable: there are no such recordings.
        ValueError: a recording cannot be read.
    """
    touches = read_touches(data_folder("thermal_contact"), seed)
    groups = sorted({touch.group for touch in touches})[: 1 if quick else None]
    split = [([t for t in touches if t.group != group], [t for t in touches if t.group == group]) for group in groups]
    learning: dict[str, list[Piece]] = {
        "alone": [(learn_table, (learned, False)) for learned, _ in split],
        "beside": [(learn_table, (learned, True)) for learned, _ in split],
        "linear": [(judge_linear, each) for each in split],
    }
    found = results_of(learning, work, part_of(progress, 0.0, 0.8))
    tables_by_set = list(zip(split, found["alone"], found["beside"], strict=True))
    judging: list[Piece] = [
        (judge_estimator, (table, learned, judged, sensors))
        for (learned, judged), alone, beside in tables_by_set
        for sensors, table in ((HEATED, alone), (HELPED, beside), (BOTH, beside))
    ]
    judged = work(judging, part_of(progress, 0.8, 1.0))
    answers = [row for rows in found["linear"] for row in rows] + [row for rows, _ in judged for row in rows]
    named = [one for _, each in judged for one in each]
    return {
        "noise_k": NOISE_K,
        "sets": groups,
        "always_wood": sum(t.material == WOOD for t in touches if t.group in groups)
        / sum(t.group in groups for t in touches),
        "accuracy": accuracy(answers),
        "errors": [answer for answer in answers if answer["said"] != answer["material"]],
        "names": operating_curve(named),
        "answers": answers,
    }


def accuracy(answers: Sequence[Row]) -> list[Row]:
    """Right answers of each method, sensors, prior and time, with the errors of each class."""
    keys = ("method", "sensors", "prior", "t_s")
    rows = []
    for cell, mine in grouped(answers, *keys).items():
        right = [answer["said"] == answer["material"] for answer in mine]
        by_class = {
            name: [hit for hit, answer in zip(right, mine, strict=True) if answer["class"] == name]
            for name in ("metal", "wood", "cooled_wood")
        }
        rows.append(
            {
                **dict(zip(keys, cell, strict=True)),
                "touches": len(mine),
                "right": sum(right),
                "share": sum(right) / len(mine),
                "balanced": _balanced(mine, right),
                **{f"{name}_wrong": len(hits) - sum(hits) for name, hits in by_class.items()},
            }
        )
    return rows


def _balanced(answers: Sequence[Mapping[str, Any]], right: Sequence[bool]) -> float:
    """Mean over the materials of the share that is right, whatever the number of touches of each."""
    of_material: dict[str, list[bool]] = {}
    for answer, hit in zip(answers, right, strict=True):
        of_material.setdefault(answer["material"], []).append(hit)
    return sum(sum(hits) / len(hits) for hits in of_material.values()) / len(of_material)


def read_touches(folder: Path, seed: int) -> list[Touch]:
    """All recordings, with noise and steps added; raises ValueError as `run`."""
    named = [(path, match) for path in sorted(folder.glob("*.csv")) if (match := _NAME.fullmatch(path.stem))]
    if not named:
        raise Unavailable(f"{folder}: no recordings named setNN_CLASS_K.csv")
    random = np.random.default_rng(seed)
    traces = [read_thermal(path) for path, _ in named]
    before: dict[int, list[float]] = {}
    for (_, match), trace in zip(named, traces, strict=True):
        before.setdefault(int(match[1]), []).append(float(np.median(_beside(trace)[: _count(_BEFORE_S)])))
    return [
        Touch(
            file=path.name,
            group=int(match[1]),
            kind=match[2],
            material=METAL if METAL in match[2] else WOOD,
            trace=replace(
                trace,
                sensor_c=_noisy(trace.sensor_c, random),
                ambient_c=None,
                reference_c=_noisy(_beside(trace), random),
            ),
            room_c=float(np.median(before[int(match[1])])),
        )
        for (path, match), trace in zip(named, traces, strict=True)
    ]


def linear_features(trace: ThermalTrace, t_s: float, sensors: str) -> Array:
    """Reading at contact, then means over blocks up to `t_s` after contact: readings relative to it, force.

    Raises:
        ValueError: the trace has no contact, or ends before.
    """
    first = trace.contact()
    if first is None:
        raise ValueError(f"{trace.name}: column force_n: no contact")
    if first + 1 + _count(t_s) > len(trace.time_s):
        raise ValueError(f"{trace.name}: fewer than {t_s:g} s of contact")
    edges = first + 1 + np.linspace(0, _count(t_s), max(round(t_s / _BLOCK_S), 1) + 1).round().astype(int)
    signals = [trace.sensor_c] + ([_beside(trace)] if sensors == BOTH else [])
    features: list[float] = []
    for signal in signals:
        start_c = float(signal[max(first - _count(_BEFORE_S), 0) : first + 1].mean())
        features += [start_c, *(_block_means(signal, edges) - start_c)]
    return np.array([*features, *_block_means(trace.force_n, edges)])


def linear_score(features: Array, metal: NDArray[np.bool_], judged: Array) -> Array:
    """Linear discriminant (Fisher 1936): ln odds of metal for each judged row, both materials equally likely."""
    means = features[metal].mean(axis=0), features[~metal].mean(axis=0)
    away = features - np.where(metal[:, None], *means)
    covariance = away.T @ away / (len(features) - 2)
    covariance[np.diag_indices(len(covariance))] *= 1.0 + _SHRINKAGE
    direction = np.linalg.solve(covariance, means[0] - means[1])
    return np.asarray((judged - 0.5 * (means[0] + means[1])) @ direction)


def _ln_odds(touches: Sequence[Touch]) -> float:
    """Return ln odds of metal among touches."""
    metal = sum(touch.material == METAL for touch in touches)
    return math.log(metal / (len(touches) - metal))


def judge_linear(learned: Sequence[Touch], judged: Sequence[Touch]) -> list[Row]:
    """Return the answers of the linear classifier."""
    metal, ln_odds = np.array([touch.material == METAL for touch in learned]), _ln_odds(learned)
    found: list[Row] = []
    for sensors in (HEATED, BOTH):
        for t_s in TIMES_S:
            features = np.stack([linear_features(touch.trace, t_s, sensors) for touch in learned])
            asked = np.stack([linear_features(touch.trace, t_s, sensors) for touch in judged])
            for touch, score in zip(judged, linear_score(features, metal, asked), strict=True):
                found += _answers("linear", sensors, touch, t_s, float(score) + ln_odds, ln_odds)
    return found


def learn_table(learned: Sequence[Touch], beside: bool) -> str:
    """Return the table that the product's calibration makes, as JSON; `beside` adds the unheated sensor."""
    with TemporaryDirectory() as scratch:
        folder = Path(scratch) / "learned"
        folder.mkdir()
        for touch in learned:
            _write(folder / touch.file, touch, beside=beside)
        lines = [f"{touch.file},{touch.material}\n" for touch in learned]
        (folder / "labels.csv").write_text("file,material\n" + "".join(lines), "utf-8")
        return calibrate_thermal(folder, Path(scratch) / "table.json").table.model_dump_json()


def judge_estimator(
    table: str, learned: Sequence[Touch], judged: Sequence[Touch], sensors: str
) -> tuple[list[Row], list[Answered]]:
    """Return the answers of the product's command at TIMES_S, and the last ones by each rule of naming."""
    ln_odds = _ln_odds(learned)
    found: list[Row] = []
    named: list[Answered] = []
    with TemporaryDirectory() as scratch:
        for touch in judged:
            path = Path(scratch) / touch.file
            _write(path, touch, beside=sensors == BOTH, until_s=TIMES_S[-1])
            for line in identify_thermal(MaterialTable.model_validate_json(table), [path], TIMES_S):
                if not line["final"]:
                    found += _answers("estimator", sensors, touch, line["t_s"], _ln_odds_of(line), ln_odds)
            hand = Hand(touch.material, math.nan, (_contact(touch, beside=sensors == BOTH),))
            named += by_fingers(knowledge_of(table), hand, {sensors: 1}, (NAMED_UNTIL_S,), RULES)
    return found, named


def _contact(touch: Touch, *, beside: bool) -> RecordedTouch:
    """Return the touch from its contact on, at the set's room temperature, without the unheated sensor or `beside` it.

    Raises:
        ValueError: the trace has no contact.
    """
    trace = touch.trace
    room_c = np.full(len(trace.time_s), touch.room_c)
    found = find_touch(replace(trace, ambient_c=room_c, reference_c=trace.reference_c if beside else None))
    if found is None:
        raise ValueError(f"{touch.file}: column force_n: no contact")
    return found


def _answers(method: str, sensors: str, touch: Touch, t_s: float, score: float, ln_odds: float) -> Iterator[Row]:
    for prior, less in zip(PRIORS, (0.0, ln_odds), strict=True):
        yield {
            "method": method,
            "sensors": sensors,
            "prior": prior,
            "t_s": t_s,
            "file": touch.file,
            "class": touch.kind,
            "material": touch.material,
            "said": METAL if score > less else WOOD,
            "ln_odds_metal": round(score - less, 3),
        }


def _ln_odds_of(line: Row) -> float:
    """Ln odds of metal from a line of `identify thermal`; a material that is no candidate has the remaining share."""
    probability = dict(line["candidates"])
    left = max(1e-4, 1.0 - sum(probability.values()))
    return float(np.log(max(probability.get(METAL, left), 1e-4) / max(probability.get(WOOD, left), 1e-4)))


def _write(path: Path, touch: Touch, *, beside: bool, until_s: float = np.inf) -> None:
    """Write the touch as a trace file, up to `until_s` after contact."""
    trace = touch.trace
    first = trace.contact() or 0
    kept = trace.time_s <= trace.time_s[first] + until_s + 0.5 * _READING_S
    columns = {"time_s": trace.time_s, "sensor_c": trace.sensor_c, "force_n": trace.force_n}
    columns["ambient_c"] = np.full(len(trace.time_s), touch.room_c)
    if beside:
        columns["reference_c"] = _beside(trace)
    np.savetxt(path, np.column_stack(list(columns.values()))[kept], "%.4f", ",", header=",".join(columns), comments="")


def _noisy(reading_c: Array, random: np.random.Generator) -> Array:
    return np.asarray(np.round((reading_c + random.normal(0.0, NOISE_K, len(reading_c))) / STEP_K) * STEP_K)


def _block_means(signal: Array, edges: NDArray[np.intp]) -> Array:
    return np.array([signal[a:b].mean() for a, b in pairwise(edges)])


def _beside(trace: ThermalTrace) -> Array:
    if trace.reference_c is None:
        raise ValueError(f"{trace.name}: column reference_c is missing")
    return trace.reference_c


def _count(seconds: float) -> int:
    return round(seconds / _READING_S)
