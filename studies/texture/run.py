"""Texture identification: surfaces, roughness normalised by speed and force, grooves, and changes of surface.

All strokes are simulated over the paper's six surfaces, at random speeds of 20..150 mm/s and forces of 0.5..5 N. All
methods learn from the same strokes and are judged by others.
"""

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from itertools import product
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np

from remote_site.texture.surface_table import SurfaceTable
from sim_sensors.physics.texture_touch import NOISE_V
from studies.compared import Compared
from studies.counting import share
from studies.pieces import HERE, Piece, Work, chunks, one_thread, part_of, rows_of
from studies.running import Progress
from studies.texture.methods import METHODS, PAPER, SHIPPED, Learned, answers, learn
from studies.texture.paper_method import PaperRoughness, paper_states
from studies.texture.strokes import Asked, changes, grooves_counted, stroke_blocks, strokes, stroking
from teletaction.make_tables import STROKED

TIMES_S = (0.1, 0.25, 0.5, 1.0, 1.5)
SEEN_M, SEEN_S = 0.050, 0.3
"""Distance, m, and time, s, after a change; it counts as detected within the longer of both."""
GROOVED = ("closely_grooved_pvc", "widely_grooved_pvc")
SPEEDS_MM_S = (20.0, 50.0, 80.0, 110.0, 150.0)
DEPTHS_M = (5e-6, 10e-6, 20e-6, 40e-6, 80e-6, 250e-6)
NOISES_V = (NOISE_V, 3.0 * NOISE_V, 10.0 * NOISE_V, 30.0 * NOISE_V)
CASES = (
    *(("speed_mm_s", value) for value in SPEEDS_MM_S),
    *(("groove_depth_m", value) for value in DEPTHS_M),
    *(("noise_v", value) for value in NOISES_V),
)
"""Parameter and value of each case of groove detection; one parameter varies at a time."""
COURSES = (("plain_pvc", "sandpaper"), ("sandpaper", "plain_pvc"))
COSTED = 12
"""Number of strokes behind each median cost, two over each surface."""
_IN_A_PIECE = 20
BASELINE = "one numpy.fft.rfft of 200 samples"
BASELINE_RUNS = 2000
COMPARED = (
    Compared("accuracy", "share", "more", ("method", "time_s"), {"method": SHIPPED}, counted="strokes"),
    Compared("scatter", "scatter", "less", ("surface",), {"normalised": True}, absolute=0.01, relative=0.2),
    Compared("grooves", "share", "less", ("against", "value"), {"method": SHIPPED}, counted="crossed"),
    Compared("changes", "share", "more", counted="strokes"),
    Compared("changes", "told_but_not_there", "less", absolute=3.0, relative=1.0),
    Compared("cost.methods", "baselines_a_second", "less", ("method",), {"method": SHIPPED}, relative=0.3),
)


class Sizes(NamedTuple):
    """Numbers of strokes: per surface to learn from and to judge by, with a change, and per case of grooves."""

    learn: int
    judge: int
    changes: int
    grooves: int


FULL, QUICK = Sizes(16, 100, 300, 6), Sizes(2, 4, 8, 1)


def run(quick: bool, seed: int, progress: Progress, work: Work = HERE) -> dict[str, Any]:
    """Run all parts, with fewer strokes if `quick`; measure the costs in this process after all other work."""
    return measure(QUICK if quick else FULL, seed, progress, work)


def measure(sizes: Sizes, seed: int, progress: Progress, work: Work = HERE) -> dict[str, Any]:
    """Run all parts with these numbers of strokes."""
    learned: Learned = work([(_learn, (sizes.learn, seed))], part_of(progress, 0.0, 0.1))[0]
    table = learned.fit.table
    asked, changed = list(strokes(sizes.judge, TIMES_S[-1], 2000 + seed)), list(changes(sizes.changes, 3000 + seed))
    pieces: dict[str, list[Piece]] = {
        "judged": [(_judge, (some, learned)) for some in chunks(asked, _IN_A_PIECE)],
        "changes": [(_change, (some, table)) for some in chunks(changed, _IN_A_PIECE)],
        "grooves": [(_grooves, (table, number, sizes.grooves, 4000 + seed)) for number in range(len(CASES))],
        "courses": [(_course, (table, *pair, seed)) for pair in COURSES],
    }
    found = rows_of(pieces, work, part_of(progress, 0.1, 0.95))
    roughness = [row for _, row in found["judged"]]
    with one_thread():
        cost = _cost(asked[:COSTED], learned)
    progress(1.0)
    return {
        "law": learned.fit.law.law.model_dump(),
        "accuracy": _accuracy([one.surface for one in asked], [names for names, _ in found["judged"]]),
        "roughness": roughness,
        "scatter": _scatter(roughness),
        "cost": {"baseline": BASELINE, **cost},
        "changes": _changes(found["changes"]),
        "grooves": found["grooves"],
        "courses": found["courses"],
    }


def tables(data: Mapping[str, Any]) -> dict[str, list[dict[str, Any]]]:
    """Return a table for each part except the courses."""
    return {
        "accuracy": data["accuracy"],
        "roughness": data["roughness"],
        "scatter": data["scatter"],
        "cost": data["cost"]["methods"],
        "changes": [{key: value for key, value in data["changes"].items() if not isinstance(value, list)}],
        "grooves": data["grooves"],
    }


def _learn(each: int, seed: int) -> Learned:
    return learn([one.drawn() for one in strokes(each, TIMES_S[-1], 1000 + seed)], TIMES_S)


def _judge(asked: Sequence[Asked], learned: Learned) -> Iterator[tuple[dict[tuple[str, float], str], dict[str, Any]]]:
    """Yield the answers of each method to each stroke, and its roughness before and after normalisation."""
    for each in asked:
        one = each.drawn()
        names, _ = answers(one, learned, TIMES_S)
        blocks = stroke_blocks(one, learned.fit.table)
        course = paper_states(one.even, [block.mode for block in blocks])
        after_v = [block.texture.roughness_v for block in stroking(blocks) if block.texture.valid]
        yield (
            names,
            {
                "surface": each.surface,
                "speed_mm_s": round(each.speed_mm_s, 1),
                "force_n": round(each.force_n, 2),
                "before_v": course[-1].mean_v,
                "after_v": float(np.sqrt(np.mean(np.square(after_v[len(after_v) // 3 :])))),
            },
        )


def _accuracy(true: Sequence[str], named: Sequence[Mapping[tuple[str, float], str]]) -> list[dict[str, Any]]:
    """Return a row for each method and time."""
    rows = []
    for method, time_s in product(METHODS, TIMES_S):
        said = [(surface, names[method, time_s]) for surface, names in zip(true, named, strict=True)]
        hits = sum(surface == name for surface, name in said)
        wrong = Counter(f"{surface} for {name}" for surface, name in said if surface != name)
        rows.append(
            {"method": method, "time_s": time_s, "right": hits, "strokes": len(said), **share(hits, len(said))}
            | {"wrong": "; ".join(f"{count} {pair}" for pair, count in wrong.most_common())}
        )
    return rows


def _cost(asked: Sequence[Asked], learned: Learned) -> dict[str, Any]:
    """Return the median time of each method for a second of signal, in seconds and in baselines."""
    unit_s = _baseline_s()
    middle_s = np.median([answers(one.drawn(), learned, TIMES_S)[1] for one in asked], axis=0)
    cost = [
        {
            "method": method,
            "baselines_a_second": round(float(took_s / unit_s), 1),
            "of_one_core": float(took_s),
            "five_fingers_of_one_core": float(5.0 * took_s),
        }
        for method, took_s in zip(METHODS, middle_s, strict=True)
    ]
    return {"baseline_us": 1e6 * unit_s, "methods": cost}


def _baseline_s() -> float:
    """Return the time of one baseline, s."""
    values, spent = np.random.default_rng(0).standard_normal(200), []
    for _ in range(BASELINE_RUNS):
        begin_s = perf_counter()
        np.fft.rfft(values)
        spent.append(perf_counter() - begin_s)
    return float(np.median(spent))


def _scatter(rows: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Return for each surface the coefficient of variation of its roughness, and largest over smallest."""
    found = []
    for surface in STROKED:
        for which in ("before_v", "after_v"):
            values = np.array([row[which] for row in rows if row["surface"] == surface])
            found.append(
                {
                    "surface": surface,
                    "normalised": which == "after_v",
                    "mean_v": float(values.mean()),
                    "scatter": float(values.std() / values.mean()),
                    "largest_over_smallest": float(values.max() / values.min()),
                }
            )
    return found


def _change(asked: Sequence[Asked], table: SurfaceTable) -> Iterator[dict[str, Any]]:
    """Yield for each stroke over a border the delay of the detected change, if any, and the false detections."""
    for one in asked:
        drawn = one.drawn()
        border_s = drawn.trace.border_s
        assert border_s is not None
        blocks = stroke_blocks(drawn, table)
        window_s = max(1e3 * SEEN_M / one.speed_mm_s, SEEN_S)
        detected = [block.texture.changed_s - border_s for block in blocks if block.texture.changed_s is not None]
        hits = [after_s for after_s in detected if 0.0 <= after_s <= window_s]
        within = [block for block in blocks if block.end_s <= border_s + window_s]
        yield {
            "stroke": f"{one.surface} to {one.then}, {one.speed_mm_s:.0f} mm/s, {one.force_n:.1f} N",
            "late_m": 1e-3 * one.speed_mm_s * hits[0] if hits else None,
            "false": len(detected) - len(hits),
            "recognised": within[-1].texture.best == one.then,
        }


def _changes(strokes: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Return the numbers of detected and false changes of surface, and the delay of the detected ones."""
    late_m = [one["late_m"] for one in strokes if one["late_m"] is not None]
    return {
        "strokes": len(strokes),
        "seen": len(late_m),
        **share(len(late_m), len(strokes)),
        "recognised": sum(one["recognised"] for one in strokes),
        "told_but_not_there": sum(one["false"] for one in strokes),
        "metres_stroked": 0.14 * len(strokes),
        "late_mm": [round(1e3 * float(np.quantile(late_m, part)), 1) for part in (0.5, 0.95)],
        "missed": [one["stroke"] for one in strokes if one["late_m"] is None],
    }


def _grooves(table: SurfaceTable, number: int, repeats: int, seed: int) -> Iterator[dict[str, Any]]:
    """Yield the missed and false grooves of the paper's and the shipped method in one of CASES."""
    what, value = CASES[number]
    how = {what: value}
    counts = {method: np.zeros(3, dtype=int) for method in (PAPER, SHIPPED)}
    chance = np.random.default_rng([seed, number])
    for repeat in range(repeats):
        for surface in GROOVED:
            speed_mm_s = how.get("speed_mm_s", float(chance.uniform(20.0, 150.0)))
            force_n = float(chance.uniform(0.56, 4.5))
            asked = Asked(surface, None, seed + 1000 * number + repeat, speed_mm_s, force_n)
            one = asked.drawn(**{name: value for name, value in how.items() if name != "speed_mm_s"})
            blocks = stroke_blocks(one, table)
            begin_s = stroking(blocks)[0].begin_s
            detected = {
                SHIPPED: [impulse.time_s for block in blocks for impulse in block.texture.impulses],
                PAPER: list(paper_states(one.even, [block.mode for block in blocks])[-1].patterns_s),
            }
            for method, times_s in detected.items():
                counts[method] += grooves_counted(one, begin_s, times_s)
    for method, (crossed, missed, invented) in counts.items():
        yield {
            "against": what,
            "value": value,
            "method": method,
            "crossed": int(crossed),
            "missed": int(missed),
            "invented": int(invented),
            "share": float((missed + invented) / max(crossed, 1)),
        }


def _course(table: SurfaceTable, before: str, after: str, seed: int) -> Iterator[dict[str, Any]]:
    """Stroke from one surface to another; yield the course that shows the paper's latching hold and drifting mean."""
    one = Asked(before, after, 5000 + seed, 60.0, 1.5, 0.24).drawn()
    stroked = stroking(stroke_blocks(one, table))
    paper, course = PaperRoughness(), []
    for block in stroked:
        first = int(np.searchsorted(one.even.time_s, block.begin_s))
        paper.step(one.even.signal_v[first : first + 10])
        course.append((paper.mean_v, paper.pattern))
    assert one.trace.border_s is not None
    yield {
        "before": before,
        "after": after,
        "after_border_s": [round(block.end_s - one.trace.border_s, 4) for block in stroked],
        "paper_v": [mean_v for mean_v, _ in course],
        "held": [held for _, held in course],
        "shipped_v": [block.texture.roughness_v if block.texture.valid else None for block in stroked],
    }
