"""Compares the cost of each stage of a tick with its budget in `budget.toml`, in reference steps.

`python -m benchmarks.runtime_cost.budget` measures and rewrites the budget. Raise a budget only by decision. The
shipped one has the largest number of several machines (decision 42).
"""

import tempfile
import tomllib
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

from benchmarks.runtime_cost.measure import measure
from common.fingers import FINGERS
from teletaction.session.demo_files import PROCESSES

BUDGET = Path(__file__).with_name("budget.toml")
ALLOWANCE = 1.0 / 3.0
"""Relative excess over the budget that is allowed, because two runs on a busy machine differ."""
LEAST_STEPS = 0.05
"""Least excess that is reported, reference steps; a smaller one is the time of reading the clock."""

Budget = Mapping[str, Mapping[str, Mapping[str, float]]]


def load_budget(path: Path = BUDGET) -> tuple[int, Budget]:
    """Return the budget's number of fingers, and reference steps by process, stage and activity of the fingers."""
    with path.open("rb") as file:
        found = tomllib.load(file)
    return found.pop("fingers"), found


def exceeded(rows: Iterable[Mapping[str, Any]], fingers: int, budget: Budget) -> list[str]:
    """Describe each cost that exceeds its budget, one line each; a stage without a budget has a budget of 0.

    Args:
        rows: rows of `Spent.rows`.
        fingers: number of fingers; other rows are left out.
        budget: budget of `load_budget`.
    """
    found = []
    for row in rows:
        if row["fingers"] != fingers:
            continue
        process, stage, doing, cost = row["process"], row["stage"], row["doing"], row["reference_steps"]
        allowed = budget.get(process, {}).get(stage, {}).get(doing, 0.0)
        if cost > allowed * (1.0 + ALLOWANCE) + LEAST_STEPS:
            found.append(
                f"{process}, {stage}, fingers {doing}: {cost:.2f} reference steps a tick, {allowed:.2f} in budget"
            )
    return found


def budget_text(rows: Iterable[Mapping[str, Any]], fingers: int) -> str:
    """Return the budget in TOML made of the rows with this number of fingers."""
    found = [f"# Mean reference steps per tick, by process, stage and activity of the fingers.\nfingers = {fingers}"]
    stages: dict[tuple[str, str], list[str]] = {}
    for row in sorted(rows, key=lambda row: PROCESSES.index(row["process"])):
        if row["fingers"] == fingers:
            stage = stages.setdefault((row["process"], row["stage"]), [])
            stage.append(f"{row['doing']} = {row['reference_steps']:.2f}")
    found += ["\n".join((f'[{process}."{stage}"]', *lines)) for (process, stage), lines in stages.items()]
    return "\n\n".join(found) + "\n"


if __name__ == "__main__":
    with tempfile.TemporaryDirectory(prefix="runtime-cost-") as folder:
        BUDGET.write_text(budget_text(measure(len(FINGERS), 0, Path(folder)).rows(len(FINGERS)), len(FINGERS)), "utf-8")
