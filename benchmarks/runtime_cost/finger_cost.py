"""Computes the cost that one finger adds to a tick, by activity, from ticks with the most fingers and with one."""

from collections.abc import Iterable, Mapping
from typing import Any

from benchmarks.runtime_cost.measure import DOING, TICK

IDENTIFICATION = ("identify", "solve")
"""Stages of the remote site whose cost depends on a finger's activity."""
FREE = DOING[0]


def finger_costs(rows: Iterable[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Return a row for each process and activity, for the whole tick and, at the remote site, for identification.

    Args:
        rows: rows of `Spent.rows`, for one finger and for more.

    Returns:
        Mean processor time that a finger adds, us, and the share of it that a free finger adds.
    """
    us: dict[tuple[str, str, str, int], float] = {
        (row["process"], row["doing"], row["stage"], row["fingers"]): row["mean_us"] for row in rows
    }
    most = max(fingers for *_, fingers in us)

    def added(process: str, doing: str, stages: tuple[str, ...]) -> float:
        spent = [
            us.get((process, doing, stage, most), 0.0) - us.get((process, doing, stage, 1), 0.0) for stage in stages
        ]
        return sum(spent) / (most - 1)

    found = []
    for process in dict.fromkeys(process for process, *_ in us):
        parts = {"whole tick": (TICK,)} | ({"identification": IDENTIFICATION} if process == "remote" else {})
        for part, stages in parts.items():
            free_us = added(process, FREE, stages)
            for doing in DOING:
                finger_us = added(process, doing, stages)
                found.append(
                    {
                        "process": process,
                        "part": part,
                        "doing": doing,
                        "finger_us": round(finger_us, 2),
                        "free_share": round(free_us / finger_us, 3) if finger_us > 0.0 else None,
                    }
                )
    return found
