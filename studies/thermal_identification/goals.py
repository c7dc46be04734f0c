"""Compares the results of thermal identification with its goals."""

from collections.abc import Mapping
from typing import Any

from studies.thermal_identification.maps import FAR_LN

SHORTFALL = 0.03
WRONG = 0.005
UNKNOWN = 0.90


def goals(data: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Return a row for each goal: description, limit, result, number of touches, and whether it is met.

    A share of 0.005 needs several hundred touches. The share of wrong answers counts all times and methods, so one
    touch counts more than once. The worst of several times is worse than the expected value at each.
    """
    rows = []
    by_place = {(row["materials"], row["method"], row["t_s"]): row for row in data["accuracy"]}
    for count in sorted({row["materials"] for row in data["accuracy"]}):
        beside = [
            (reference["right"] - row["right"], row["touches"])
            for (materials, method, t_s), row in by_place.items()
            if materials == count and method == "1 finger" and (reference := by_place.get((count, "reference", t_s)))
        ]
        worst, touches = max(beside)
        what = f"{count} materials: share right below the reference's, at the worst time"
        rows.append(_row(what, SHORTFALL, worst, touches, worst <= SHORTFALL))
    last = [row for row in data["accuracy"] if row["wrong"] is not None]
    named = sum(row["identified"] * row["touches"] for row in last)
    wrong = sum(row["wrong"] * row["touches"] for row in last) / max(named, 1.0)
    rows.append(_row("identified answers that are wrong", WRONG, wrong, round(named), wrong <= WRONG))
    end_s = max((row["t_s"] for row in data["untrained"]), default=0.0)
    for far in (True, False):
        found = [r for r in data["untrained"] if r["t_s"] == end_s and (abs(r["away_ln"]) >= FAR_LN) == far]
        touches = sum(row["touches"] for row in found)
        if touches:
            kind = "unknown" if far else "named"
            share = sum(row[kind] * row["touches"] for row in found) / touches
            what = f"untrained, {FAR_LN} or more away: unknown" if far else "untrained, nearer: ever named as another"
            limit = UNKNOWN if far else 0.0
            rows.append(_row(what, limit, share, touches, share >= limit if far else share <= limit))
    return rows


def _row(what: str, limit: float, found: float, touches: int, met: bool) -> dict[str, Any]:
    return {"goal": what, "limit": limit, "found": round(found, 4), "touches": touches, "met": met}
