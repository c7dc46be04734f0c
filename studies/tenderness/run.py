"""Tenderness: simulated patients answer to presses; the centre of the tender place, and presses above their threshold.

The usual patients have a reaction time of 0.3 to 1.2 s, a threshold that varies by 20 %, and some wrong answers. The
other conditions show where the method fails.
"""

import math
from collections.abc import Iterator, Sequence
from statistics import median
from typing import Any

from studies.compared import Compared
from studies.pieces import HERE, Piece, Work, chunks, rows_of
from studies.running import Progress, tables_of
from studies.tenderness.examiner import examine
from studies.tenderness.patients import Kind, Patient

USUAL = "usual"
KINDS = (
    Kind(USUAL),
    Kind("two places", places=2),
    Kind("slow reaction", reaction_s=(1.2, 2.0)),
    Kind("drifting reaction", drift=0.6),
    Kind("lasting pain", lasting_s=1.0),
    Kind("threshold noise 40 %", noise=0.4),
    Kind("wrong answers 2 %", wrong=0.02),
    Kind("few presses", presses_a_side=4, rounds=1),
)
PATIENTS, QUICK_PATIENTS = 200, 8
OTHERS, QUICK_OTHERS = 8, 1
"""Patients of every other condition."""
GOAL_MM, GOAL_WITHIN, GOAL_EXCEEDED = 8.0, 0.95, 0.05
CHUNK = 4
"""Patients of a piece of work."""
_SEEDS_APART = 10_000
tables = tables_of("conditions", "patients")
COMPARED = (
    Compared("conditions", "within_goal", "more", ("condition",), counted="patients"),
    Compared("conditions", "exceeded", "less", ("condition",), absolute=0.01),
)


def run(quick: bool, seed: int, progress: Progress, work: Work = HERE) -> dict[str, Any]:
    """Examine all patients; a row for each, and a row for each condition."""
    usual, others = (QUICK_PATIENTS, QUICK_OTHERS) if quick else (PATIENTS, OTHERS)
    first = _SEEDS_APART * seed
    pieces: list[Piece] = []
    for number in range(len(KINDS)):
        seeds = range(first, first + (usual if number == 0 else others))
        pieces += [(_rows, (number, part)) for part in chunks(seeds, CHUNK)]
    found = rows_of({"patients": pieces}, work, progress)
    conditions = [_condition(kind.name, found["patients"]) for kind in KINDS]
    goal = {"place_mm": GOAL_MM, "within": GOAL_WITHIN, "exceeded": GOAL_EXCEEDED}
    return {"conditions": conditions, "goal": goal, "problems": list(_problems(conditions[0])), **found}


def _rows(number: int, seeds: Sequence[int]) -> Iterator[dict[str, Any]]:
    kind = KINDS[number]
    for seed in seeds:
        patient = Patient(kind, seed)
        done = examine(patient, kind, seed)
        place = done.place()
        error_mm = None
        if place is not None:
            error_mm = 1e3 * min(math.dist((place.x_m, place.y_m), centre) for centre in patient.centres_m)
        yield {
            "condition": kind.name,
            "seed": seed,
            "reaction_s": patient.reaction_s,
            "threshold_n": patient.threshold_n,
            "place_error_mm": error_mm,
            "place_sd_mm": None if place is None else 1e3 * place.sd_m,
            "probability": None if place is None else place.probability,
            "found_threshold_n": None if place is None else place.threshold_n,
            "found_reaction_s": done.limit.reaction.mean_s,
            "reaction_sd_s": done.limit.reaction.sd_s,
            "limit_n": done.limit.limit_n if math.isfinite(done.limit.limit_n) else None,
            "presses": done.presses,
            "presses_after": done.after,
            "exceeded": done.exceeded,
            "ended_limits": done.ended_limits,
            "seconds": done.t_s,
        }


def _condition(name: str, every: list[dict[str, Any]]) -> dict[str, Any]:
    rows = [row for row in every if row["condition"] == name]
    errors = sorted(math.inf if row["place_error_mm"] is None else row["place_error_mm"] for row in rows)
    after = sum(row["presses_after"] for row in rows)
    apart = [abs(row["found_reaction_s"] - row["reaction_s"]) for row in rows]
    limits = [row["limit_n"] / row["threshold_n"] for row in rows if row["limit_n"] is not None]
    return {
        "condition": name,
        "patients": len(rows),
        "within_goal": sum(error <= GOAL_MM for error in errors) / len(rows),
        "place_error_mm": median(errors) if math.isfinite(median(errors)) else None,
        "exceeded": sum(row["exceeded"] for row in rows) / after if after else 0.0,
        "worst_exceeded": max(row["exceeded"] / max(1, row["presses_after"]) for row in rows),
        "reaction_error_s": median(apart),
        "limit_share": median(limits) if limits else None,
        "presses": median(row["presses"] for row in rows),
        "ended_limits": median(row["ended_limits"] for row in rows),
    }


def _problems(usual: dict[str, Any]) -> Iterator[str]:
    if usual["within_goal"] < GOAL_WITHIN:
        yield f"the centre is within {GOAL_MM:g} mm in {100 * usual['within_goal']:.1f} % of the patients"
    if usual["exceeded"] > GOAL_EXCEEDED:
        yield f"{100 * usual['exceeded']:.1f} % of the presses after the first report exceed the threshold"
