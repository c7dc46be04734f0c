"""Counts answers by status and correctness, and computes temperature errors and the reliability of probabilities."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from studies.thermal_identification.answers import Answered

BINS = (0.0, 0.5, 0.7, 0.8, 0.9, 0.95, 0.99, 0.999, 1.0)
"""Edges of the bins of probability for reliability."""
WITHIN_SD = 1.96
"""Number of standard deviations that hold 95 % of the errors if the claimed standard deviations are right."""
SETTLED_S = 0.5
"""Time after contact from which reliability is counted, s."""
_KINDS = ("identified", "ambiguous", "deciding", "unknown", "unidentifiable")


def shares(answers: Iterable[Answered], **where: Any) -> list[dict[str, Any]]:
    """Return a row for each method and time; shares are 0..1 of all touches.

    `identified`, `ambiguous`, `deciding`, `unknown` and `unidentifiable` add up to 1. `wrong` is the part of
    `identified` that names another material. All are None for a method without statuses. `named_s` is the median time
    to the first named material, over touches with one. Temperature errors leave out touches without a stated
    temperature; `object_stated` is the share of the others. `object_within_sd` is the share of errors within the
    claimed 95 % interval, of `object_errors` errors, and should be 0.95.
    """
    groups: dict[tuple[str, float], list[Answered]] = {}
    for answer in answers:
        groups.setdefault((answer.method, answer.t_s), []).append(answer)
    return [{**where, **_row(each)} for each in groups.values()]


def _row(each: Sequence[Answered]) -> dict[str, Any]:
    count = len(each)
    answered = any(one.best is not None for one in each)
    right = sum(one.best == one.truth for one in each)
    stated = each[0].status is not None
    identified = [one for one in each if one.status == "identified"]
    errors = np.array([one.error_k for one in each if one.error_k is not None])
    scaled = np.array([one.error_k / one.sd_k for one in each if one.error_k is not None and one.sd_k])
    named = [one.named_s for one in each if one.named_s is not None]
    return {
        "method": each[0].method,
        "t_s": each[0].t_s,
        "touches": count,
        "right": _share(right, count) if answered else None,
        **{kind: _share(sum(one.status == kind for one in each), count) if stated else None for kind in _KINDS},
        "wrong": _share(sum(one.best != one.truth for one in identified), count) if stated else None,
        "named": _share(len(named), count) if stated else None,
        "named_s": round(float(np.median(named)), 3) if named else None,
        "object_stated": _share(len(errors), count),
        "object_rms_k": round(float(np.sqrt(np.mean(errors**2))), 3) if len(errors) else None,
        "object_median_k": round(float(np.median(np.abs(errors))), 3) if len(errors) else None,
        "object_errors": len(scaled),
        "object_within_sd": round(float(np.mean(np.abs(scaled) < WITHIN_SD)), 3) if len(scaled) else None,
    }


def reliability(
    answers: Sequence[Answered], strangers: Sequence[Answered] = (), stranger_share: float = 0.0, **where: Any
) -> list[dict[str, Any]]:
    """Return a row for each method and bin of probability: claimed probability and right share.

    Args:
        answers: answers about calibrated materials.
        strangers: answers about uncalibrated materials by the same method, weighted to `stranger_share` of all.
        stranger_share: prior share of uncalibrated materials, 0..1, for which the probabilities should be right.
        where: further columns.
    """
    asked, strange = ([one for one in each if _counts(one)] for each in (answers, strangers))
    weight = stranger_share / (1.0 - stranger_share) * len(asked) / max(len(strange), 1)
    groups: dict[tuple[str, int], list[tuple[Answered, float]]] = {}
    for one, counts in (*((one, 1.0) for one in asked), *((one, weight) for one in strange)):
        place = min(int(np.searchsorted(BINS, one.probability or 0.0, side="right")) - 1, len(BINS) - 2)
        groups.setdefault((one.method, place), []).append((one, counts))
    rows = []
    for (method, place), each in sorted(groups.items()):
        whole = sum(counts for _, counts in each)
        rows.append(
            {
                **where,
                "method": method,
                "from": BINS[place],
                "to": BINS[place + 1],
                "answers": len(each),
                "claimed": _share(sum((one.probability or 0.0) * counts for one, counts in each), whole),
                "right": _share(sum(counts for one, counts in each if one.best == one.truth), whole),
            }
        )
    return rows


def _counts(one: Answered) -> bool:
    return one.probability is not None and one.t_s >= SETTLED_S


def errors(answers: Iterable[Answered], **where: Any) -> list[dict[str, Any]]:
    """Return confusions: a row for each method, time, material and wrong name with the status `identified`."""
    counted: dict[tuple[str, float, str, str], int] = {}
    for one in answers:
        if one.status == "identified" and one.best is not None and one.best != one.truth:
            key = (one.method, one.t_s, one.truth, one.best)
            counted[key] = counted.get(key, 0) + 1
    return [
        {**where, "method": method, "t_s": t_s, "material": truth, "named": best, "touches": count}
        for (method, t_s, truth, best), count in sorted(counted.items())
    ]


def _share(part: float, whole: float) -> float:
    return round(part / whole, 4)
