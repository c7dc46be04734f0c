"""Stiffness of recorded presses: prediction, repeats, and what would be shown, beside classic methods.

A robot pressed silicone, meat and pig liver in ten steps of 0.2 to 0.3 mm, and moved over an object while its force
swung at 2 Hz. The recordings are by others. No truth is stated with them, so that the bars are about prediction and
repetition:

- The three deepest samples of a press are predicted from the first seven.
- The same places of a silicone kidney were pressed twice, to 2 and to 3 mm. The second is cut at 2 mm. Pairs are judged
  by the whole standard deviation, and by the part of it that differs between presses of one file.
- A shown model is a spring. It is too hard where it gives more than the recorded force and 0.1 N. The law's tangent
  at the deepest sample is judged on the samples of its fit, and the live estimate while its stiffness is known.
- Maps of some presses are compared with lumps that are inferred from the denser recording (`map_bars`).
- A window of the stream is one period of the force. The probe moves on between windows. A window is compared with the
  mean of its neighbours, by a robust standard deviation. A plain regression is judged in the same way. The odd and the
  even samples of each window are compared, too, because the tissue does not change between them.

Constants of the law were chosen with these recordings. Other recordings are kept aside to judge it.
"""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from studies.compared import Compared
from studies.counting import grouped
from studies.palpation.map_bars import SETS, chosen_one_by_one, judged_maps, map_means, read_palpated
from studies.palpation.presses import LAW, answered, predicted, repeated
from studies.palpation.recordings import MATERIALS, STREAMS, read_set, read_stream
from studies.palpation.shown import REGRESSION, STEPPED, shown, streamed
from studies.pieces import HERE, Piece, Work, rows_of
from studies.running import Progress, data_folder, tables_of

Row = dict[str, Any]

PREDICTION_BARS = {"silicone": (0.08, 0.05), "meat": (0.12, 0.07), "liver": (0.19, 0.13)}
"""Honest and ambitious median error of the predicted samples of each material."""
SAME_PLACES = ("kidney_bar_t1", "kidney_bar_t2")
SHOWN_SETS = ("liver2_r1", "liver2_r2")
COMPARED = (
    Compared("bars", "value", "same", ("bar", "of"), absolute=0.01),
    Compared("repeats", "cv", "less", ("method",), absolute=0.002),
)
MAP_DRAWS, MAP_STARTS = 40, 8
"""Random choices of presses of each map, and starts of the presses that are chosen one by one."""
MAP_BARS = (
    ("auc_lump", 30, 0.90, 0.95),
    ("auc_lump", 60, 0.97, 0.985),
    ("dice", 120, 0.80, 0.85),
)
"""Score of maps of random presses, number of presses, honest and ambitious least mean."""
tables = tables_of("bars", "answers", "prediction", "repeats", "shown", "stream", "maps", "map_means")


def run(quick: bool, seed: int, progress: Progress, work: Work = HERE) -> dict[str, Any]:
    """Judge all sets of presses and both streams; everything is deterministic.

    Args:
        quick: one set of each material, and one stream.
        seed: unused.

    Raises:
        Unavailable: there are no such recordings.
        ValueError: a recording cannot be read.
    """
    folder = data_folder("palpation")
    material_of = {name: material for material, names in MATERIALS.items() for name in names[-1 if quick else 0 :]}
    presses = {name: read_set(folder, name) for name in dict.fromkeys([*material_of, *SAME_PLACES, *SHOWN_SETS])}
    maps = [read_palpated(folder, name) for name in list(SETS)[: 1 if quick else None]]
    streams = {name: read_stream(folder, name) for name in STREAMS[: 1 if quick else None]}
    pieces: dict[str, list[Piece]] = {
        "answers": [(answered, (name, presses[name])) for name in material_of],
        "prediction": [(predicted, (name, material, presses[name])) for name, material in material_of.items()],
        "repeats": [(repeated, tuple(presses[name] for name in SAME_PLACES))],
        "shown": [(shown, (name, presses[name])) for name in SHOWN_SETS],
        "stream": [(streamed, (name, stream)) for name, stream in streams.items()],
        "maps": [(judged_maps, (palpated, 4 if quick else MAP_DRAWS)) for palpated in maps]
        + [(chosen_one_by_one, (palpated, one)) for palpated in maps for one in range(1 if quick else MAP_STARTS)],
    }
    found = rows_of(pieces, work, progress)
    errors = list(_errors(found.pop("prediction")))
    prediction = [{key: value for key, value in row.items() if key != "percentiles"} for row in errors]
    found["map_means"] = map_means(found["maps"])
    found["maps"] = [row for row in found["maps"] if row["seed"] is None]
    data = {"answers": found["answers"], "prediction": prediction, "errors": errors, **found}
    return {"bars": list(_bars(data)), **data}


def _errors(presses: Sequence[Row]) -> Iterator[Row]:
    """Yield the errors of each material and method, of all samples together."""
    for (material, method), mine in grouped(presses, "material", "method").items():
        values = np.concatenate([row["errors"] for row in mine])
        outside = [row["outside_2_sd"] for row in mine if row["outside_2_sd"] is not None]
        yield {
            "material": material,
            "method": method,
            "presses": len(mine),
            "error_p50": float(np.median(values)),
            "error_p90": float(np.quantile(values, 0.9)),
            "outside_2_sd": sum(outside) / len(values) if outside else None,
            "percentiles": np.percentile(values, np.arange(101)).round(5).tolist(),
        }


def _bars(data: Mapping[str, Any]) -> Iterator[Row]:
    """Yield a row for each bar; the value reaches it within `least` and `most`, and is ambitious within the others."""
    answers = data["answers"]
    missing = sum(row["failed"] for row in answers) / sum(row["presses"] for row in answers)
    yield _bar("presses without an answer", "all", missing, (0.0, 0.0), (0.0, 0.0))
    for row in data["prediction"]:
        if row["method"] == LAW:
            honest, ambitious = PREDICTION_BARS[row["material"]]
            of = row["material"]
            yield _bar("error of the deepest 3 from the first 7", of, row["error_p50"], (0.0, honest), (0.0, ambitious))
    (same,) = (row for row in data["repeats"] if row["method"] == LAW)
    yield _bar("same place twice: CV", "kidney", same["cv"], (0.0, 0.055), (0.0, 0.04))
    yield _bar("same place twice: ICC", "kidney", same["icc"], (0.85, 1.0), (0.92, 1.0))
    yield _bar("pairs outside 2 stated sd", "kidney", same["outside_2_sd"], (0.02, 0.13), (0.03, 0.07))
    for row in data["shown"]:
        if row["way"] != STEPPED:
            yield _bar(f"too hard: {row['way']}", row["set"], row["too_hard"], (0.0, 0.2), (0.0, 0.05))
    for row in data["stream"]:
        if row["method"] != REGRESSION:
            yield _bar(f"windows known: {row['method']}", row["stream"], row["known"], (0.8, 1.0), (0.98, 1.0))
            yield _bar(f"windows, CV: {row['method']}", row["stream"], row["cv"], (0.0, 0.025), (0.0, 0.015))

    for score, presses, honest, ambitious in MAP_BARS:
        for row in data["map_means"]:
            if (row["way"], row["presses"]) == ("random", presses):
                yield _bar(f"map, {score}, {presses} presses", row["set"], row[score], (honest, 1.0), (ambitious, 1.0))
    for row in data["maps"]:
        if row["way"] == "single presses, cut":
            yield _bar("map, AUC of single presses", row["set"], row["auc_value"], (0.95, 1.0), (0.985, 1.0))
        elif row["way"] == "all presses":
            called = row["called"] if row["called_false"] <= 0.01 else 0.0
            yield _bar("called stiff, at most 1 % false", row["set"], called, (0.75, 1.0), (0.90, 1.0))


def _bar(bar: str, of: str, value: float, honest: tuple[float, float], ambitious: tuple[float, float]) -> Row:
    reached = [name for name, (least, most) in (("honest", honest), ("ambitious", ambitious)) if least <= value <= most]
    return {
        "bar": bar,
        "of": of,
        "value": value,
        "honest_from": honest[0],
        "honest_to": honest[1],
        "ambitious_from": ambitious[0],
        "ambitious_to": ambitious[1],
        "reached": reached[-1] if reached else None,
    }
