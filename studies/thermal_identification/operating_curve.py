"""Operating curve of naming: how soon touches are named, and how many wrongly, for rules of different caution."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from remote_site.thermal.thermal_result import NamingRule
from studies.drawing import Rows, curve, where
from studies.thermal_identification.answers import SHIPPED_RULE, Answered

RULES = (*(NamingRule(caution=caution) for caution in (1.0, 25.0, 100.0)), SHIPPED_RULE)
"""Rules of naming."""
WITHIN_S = (1, 3, 6)
"""Times after contact at which named touches are counted, s."""
LEAST_RANGE = 1.0
"""Least end of the axis of wrong names, %."""


def operating_curve(
    answers: Sequence[Answered], strangers: Sequence[Answered] = (), **columns: Any
) -> list[dict[str, Any]]:
    """Return a row for each method and rule: what is named at the end, and how soon.

    `named_s` is the median time to the first name over touches with one. The shares are 0..1 of the touches of
    calibrated materials, and of strangers for `strangers_named`.

    Args:
        answers: last answers to touches of calibrated materials, by `by_fingers`.
        strangers: last answers to touches of other materials.
        columns: further columns.
    """
    keys = dict.fromkeys((one.method, one.rule.caution) for one in answers if one.rule is not None)
    rows = []
    for method, caution in keys:
        known, strange = (
            [one for one in each if one.rule is not None and (one.method, one.rule.caution) == (method, caution)]
            for each in (answers, strangers)
        )
        times_s = [one.named_s for one in known if one.named_s is not None]
        wrong = sum(one.status == "identified" and one.best != one.truth for one in known)
        rows.append(
            {
                **columns,
                "method": method,
                "caution": caution,
                "touches": len(known),
                **{f"named_{t_s}_s": round(sum(s <= t_s for s in times_s) / len(known), 4) for t_s in WITHIN_S},
                "named_s": round(float(np.median(times_s)), 3) if times_s else None,
                "wrong": round(wrong / len(known), 4),
                "strangers": len(strange),
                "strangers_named": round(sum(one.status == "identified" for one in strange) / len(strange), 4)
                if strange
                else None,
            }
        )
    return rows


def draw_operating_curve(axes: Axes, rows: Rows, looks: Mapping[str, tuple[str, str]]) -> None:
    """Draw the share named within 3 and 6 s over the share of wrong names; a point is a rule, and circles the shipped.

    If strangers were touched, the share of them that is named takes the place of the wrong names.

    Args:
        axes: axes to draw into.
        rows: rows of `operating_curve`.
        looks: colour and marker of each method.
    """
    strange = any(row["strangers_named"] is not None for row in rows)
    x = "strangers_named" if strange else "wrong"
    for method, (colour, marker) in looks.items():
        mine = sorted(where(rows, method=method), key=lambda row: -float(row["caution"]))
        shipped = where(mine, caution=SHIPPED_RULE.caution)
        for y, how in (
            ("named_6_s", {"marker": marker, "markersize": 4, "label": method}),
            ("named_3_s", {"marker": marker, "markersize": 3, "linestyle": "--", "linewidth": 1.0}),
        ):
            curve(axes, mine, x, y, (100.0, 100.0), color=colour, **how)
            around = {"marker": "o", "markersize": 10, "fillstyle": "none"}
            curve(axes, shipped, x, y, (100.0, 100.0), color=colour, **around)
    axes.set_xlabel("uncalibrated materials named (%)" if strange else "named, and wrong (%)")
    axes.set_ylabel("named within 6 s, dashed: 3 s (%)\ncircle: shipped")
    axes.set_xlim(right=max(axes.get_xlim()[1], LEAST_RANGE))
