"""Texture: surfaces told apart, roughness freed of speed and force, grooves missed and invented, and changes seen.

All strokes are simulated, over the paper's six surfaces, at 20..150 mm/s and 0.5..5 N drawn at random. Every method
learns from the same strokes, and is judged by others.
"""

from collections.abc import Mapping, Sequence
from time import perf_counter
from typing import Any, NamedTuple

import numpy as np

from remote_site.surface_class import SurfaceTable
from sim_sensors.simulated_stroke import simulate_stroke
from sim_sensors.surface import GROOVE_DEPTH_M
from sim_sensors.texture_touch import NOISE_V
from studies.binomial_interval import clopper_pearson
from studies.paper_texture import PaperRoughness, paper_felt
from studies.registry import Tell
from studies.texture_figure import plot
from studies.texture_methods import METHODS, Learned, answers, learn
from studies.texture_strokes import Drawn, changes, felt_blocks, grooves_counted, strokes, stroking
from teletaction.make_tables import STROKED

__all__ = ["plot", "run", "tables"]

TIMES_S = (0.1, 0.25, 0.5, 1.0, 1.5)
SEEN_M, SEEN_S = 0.050, 0.3
"""A change counts as seen within the longer of both."""
GROOVED = ("closely_grooved_pvc", "widely_grooved_pvc")
SPEEDS_MM_S = (20.0, 50.0, 80.0, 110.0, 150.0)
DEPTHS_M = (5e-6, 10e-6, 20e-6, 40e-6, 80e-6, 250e-6)
NOISES_V = (NOISE_V, 3.0 * NOISE_V, 10.0 * NOISE_V, 30.0 * NOISE_V)
BASELINE = "one numpy.fft.rfft of 200 samples"
BASELINE_RUNS = 2000


class Sizes(NamedTuple):
    """Strokes over each surface to learn from and to be judged by; changes; strokes for each case of grooves."""

    learn: int
    judge: int
    changes: int
    grooves: int


FULL, QUICK = Sizes(16, 100, 300, 6), Sizes(2, 4, 8, 1)


def run(quick: bool, seed: int, tell: Tell) -> dict[str, Any]:
    """All parts; `quick` takes fewer strokes of each."""
    return {"quick": quick, **measure(QUICK if quick else FULL, seed, tell)}


def measure(sizes: Sizes, seed: int, tell: Tell) -> dict[str, Any]:
    """All parts with so many strokes of each."""
    tell("learning")
    learned = learn(list(strokes(sizes.learn, TIMES_S[-1], 1000 + seed)), TIMES_S)
    table = learned.fit.table
    tell("telling surfaces apart")
    accuracy, roughness, cost = _judge(list(strokes(sizes.judge, TIMES_S[-1], 2000 + seed)), learned)
    tell("changes of surface")
    seen = _changes(list(changes(sizes.changes, 3000 + seed)), table)
    tell("grooves")
    grooves = _grooves(table, sizes.grooves, 4000 + seed)
    tell("latch-up and drift")
    return {
        "law": learned.fit.law.law.model_dump(),
        "accuracy": accuracy,
        "roughness": roughness,
        "scatter": _scatter(roughness),
        "cost": {"baseline": BASELINE, **cost},
        "changes": seen,
        "grooves": grooves,
        "courses": _courses(table, seed),
    }


def tables(data: Mapping[str, Any]) -> dict[str, list[dict[str, Any]]]:
    """One for each part but the courses."""
    return {
        "accuracy": data["accuracy"],
        "roughness": data["roughness"],
        "scatter": data["scatter"],
        "cost": data["cost"]["methods"],
        "changes": [{key: value for key, value in data["changes"].items() if not isinstance(value, list)}],
        "grooves": data["grooves"],
    }


def _judge(
    drawn: Sequence[Drawn], learned: Learned
) -> tuple[list[dict[str, Any]], list[dict[str, Any]], dict[str, Any]]:
    """Accuracy by method and time; roughness of every stroke, before and after normalisation; cost."""
    right = {(method, time_s): 0 for method in METHODS for time_s in TIMES_S}
    wrong: dict[tuple[str, float], dict[str, int]] = {key: {} for key in right}
    rows, spent, unit_s = [], [], _baseline_s()
    for one in drawn:
        found, took_s = answers(one, learned, TIMES_S)
        spent.append(took_s)
        for key, surface in found.items():
            right[key] += surface == one.surface
            if surface != one.surface:
                pair = f"{one.surface} for {surface}"
                wrong[key][pair] = wrong[key].get(pair, 0) + 1
        blocks = felt_blocks(one, learned.fit.table)
        course = paper_felt(one.even, [block.mode for block in blocks])
        felt = [block.texture.roughness_v for block in stroking(blocks)[::1] if block.texture.valid]
        rows.append(
            {
                "surface": one.surface,
                "speed_mm_s": round(one.speed_mm_s, 1),
                "force_n": round(one.force_n, 2),
                "before_v": course[-1].mean_v,
                "after_v": float(np.sqrt(np.mean(np.square(felt[len(felt) // 3 :])))),
            }
        )
    count = len(drawn)
    accuracy = [
        {"method": method, "time_s": time_s, "right": hits, "strokes": count, **_shares(hits, count)}
        | {"wrong": "; ".join(f"{n} {pair}" for pair, n in sorted(wrong[method, time_s].items(), key=lambda x: -x[1]))}
        for (method, time_s), hits in right.items()
    ]
    middle_s = np.median(spent, axis=0)
    cost = [
        {
            "method": method,
            "baselines_a_second": round(float(took_s / unit_s), 1),
            "of_one_core": float(took_s),
            "five_fingers_of_one_core": float(5.0 * took_s),
        }
        for method, took_s in zip(METHODS, middle_s, strict=True)
    ]
    return accuracy, rows, {"baseline_us": 1e6 * unit_s, "methods": cost}


def _shares(hits: int, count: int) -> dict[str, float]:
    low, high = clopper_pearson(hits, count)
    return {"share": hits / count, "low": low, "high": high}


def _baseline_s() -> float:
    """Time of one baseline, s."""
    values, spent = np.random.default_rng(0).standard_normal(200), []
    for _ in range(BASELINE_RUNS):
        begin_s = perf_counter()
        np.fft.rfft(values)
        spent.append(perf_counter() - begin_s)
    return float(np.median(spent))


def _scatter(rows: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Of each surface: standard deviation over mean of its roughness, and largest over smallest."""
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


def _changes(drawn: Sequence[Drawn], table: SurfaceTable) -> dict[str, Any]:
    """How many changes of surface are seen, how late, and how many are told where there is none."""
    seen = false = recognised = 0
    late_m, missed = [], []
    for one in drawn:
        border_s = one.trace.border_s
        assert border_s is not None
        blocks = felt_blocks(one, table)
        window_s = max(1e3 * SEEN_M / one.speed_mm_s, SEEN_S)
        told = [block.texture.changed_s - border_s for block in blocks if block.texture.changed_s is not None]
        hits = [after_s for after_s in told if 0.0 <= after_s <= window_s]
        seen += bool(hits)
        false += len(told) - len(hits)
        if hits:
            late_m.append(1e-3 * one.speed_mm_s * hits[0])
        else:
            missed.append(f"{one.surface} to {one.then}, {one.speed_mm_s:.0f} mm/s, {one.force_n:.1f} N")
        within = [block for block in blocks if block.end_s <= border_s + window_s]
        recognised += within[-1].texture.best == one.then
    count = len(drawn)
    return {
        "strokes": count,
        "seen": seen,
        **_shares(seen, count),
        "recognised": recognised,
        "told_but_not_there": false,
        "metres_stroked": 0.14 * count,
        "late_mm": [round(1e3 * float(np.quantile(late_m, part)), 1) for part in (0.5, 0.95)],
        "missed": missed,
    }


def _grooves(table: SurfaceTable, repeats: int, seed: int) -> list[dict[str, Any]]:
    """Missed and invented by the paper's and the shipped method: against speed, depth and noise, one at a time."""
    cases: list[tuple[str, float, dict[str, float]]] = [
        *(("speed_mm_s", value, {"speed_mm_s": value}) for value in SPEEDS_MM_S),
        *(("groove_depth_m", value, {"groove_depth_m": value}) for value in DEPTHS_M),
        *(("noise_v", value, {"noise_v": value}) for value in NOISES_V),
    ]
    rows = []
    for number, (what, value, how) in enumerate(cases):
        counts = {method: np.zeros(3, dtype=int) for method in METHODS[:2]}
        chance = np.random.default_rng([seed, number])
        for repeat in range(repeats):
            for surface in GROOVED:
                speed_mm_s = how.get("speed_mm_s", float(chance.uniform(20.0, 150.0)))
                force_n = float(chance.uniform(0.56, 4.5))
                trace = simulate_stroke(
                    surface,
                    seed + 1000 * number + repeat,
                    speed_mm_s,
                    force_n,
                    groove_depth_m=how.get("groove_depth_m", GROOVE_DEPTH_M),
                    noise_v=how.get("noise_v", NOISE_V),
                )
                one = Drawn(surface, None, speed_mm_s, force_n, trace)
                blocks = felt_blocks(one, table)
                begin_s = stroking(blocks)[0].begin_s
                told = {
                    METHODS[1]: [impulse.time_s for block in blocks for impulse in block.texture.impulses],
                    METHODS[0]: list(paper_felt(one.even, [block.mode for block in blocks])[-1].patterns_s),
                }
                for method, times_s in told.items():
                    counts[method] += grooves_counted(one, begin_s, times_s)
        for method, (crossed, missed, invented) in counts.items():
            rows.append(
                {
                    "against": what,
                    "value": value,
                    "method": method,
                    "crossed": int(crossed),
                    "missed": int(missed),
                    "invented": int(invented),
                    "share": float((missed + invented) / max(crossed, 1)),
                }
            )
    return rows


def _courses(table: SurfaceTable, seed: int) -> list[dict[str, Any]]:
    """Smooth to rough, where the paper's hold latches; and rough to smooth, where its mean drifts."""
    found = []
    for before, after in (("plain_pvc", "sandpaper"), ("sandpaper", "plain_pvc")):
        trace = simulate_stroke(before, 5000 + seed, 60.0, 1.5, length_m=0.24, then=after)
        one = Drawn(before, after, 60.0, 1.5, trace)
        felt = stroking(felt_blocks(one, table))
        paper, course = PaperRoughness(), []
        for block in felt:
            first = int(np.searchsorted(one.even.time_s, block.begin_s))
            paper.step(one.even.signal_v[first : first + 10])
            course.append((paper.mean_v, paper.pattern))
        assert trace.border_s is not None
        found.append(
            {
                "before": before,
                "after": after,
                "after_border_s": [round(block.end_s - trace.border_s, 4) for block in felt],
                "paper_v": [mean_v for mean_v, _ in course],
                "held": [held for _, held in course],
                "shipped_v": [block.texture.roughness_v if block.texture.valid else None for block in felt],
            }
        )
    return found
