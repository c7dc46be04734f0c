"""Runtime cost: processor time of a tick of each process, by stage, number of fingers and what the fingers do.

Each session runs in one process and in lock step with its simulated devices, over real lines and a real link. Costs are
processor time of the loop's thread, in microseconds and in reference steps, which mean the same on a slower machine.
"""

import os
import platform
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.runtime_cost.budget import exceeded, load_budget
from benchmarks.runtime_cost.figure import plot
from benchmarks.runtime_cost.measure import measure
from studies.compared import Compared
from studies.pieces import part_of
from studies.registry import Tell

__all__ = ["COMPARED", "MEASURES_THIS_MACHINE", "plot", "run", "tables"]

MEASURES_THIS_MACHINE = "what a tick costs on this machine"
COMPARED = (Compared("cost", "reference_steps", "less", ("fingers", "process", "doing", "stage"), relative=0.33),)
_FINGERS = (1, 2, 3, 4, 5)
_QUICK_FINGERS = (1, 5)


def run(*, quick: bool, seed: int, tell: Tell) -> dict[str, Any]:
    """Measure sessions of different numbers of fingers.

    Args:
        quick: one and five fingers, about a minute; otherwise one to five.
        seed: of the simulated devices and the hand.
        tell: is told the share done, 0..1.

    Raises:
        NotEngaged: the sites did not find their devices or each other.
    """
    numbers = _QUICK_FINGERS if quick else _FINGERS
    rows: list[dict[str, Any]] = []
    reference_ns: list[int] = []
    for place, fingers in enumerate(numbers):
        with tempfile.TemporaryDirectory(prefix="runtime-cost-") as folder:
            share = part_of(tell, place / len(numbers), (place + 1) / len(numbers))
            spent = measure(fingers, seed, Path(folder), share)
        rows += spent.rows(fingers)
        reference_ns += spent.reference
    return {
        "machine": {"processors": os.cpu_count(), "python": platform.python_version()},
        "reference_step_us": round(float(np.median(reference_ns)) * 1e-3, 2),
        "cost": rows,
        "problems": exceeded(rows, *load_budget()),
    }


def tables(data: dict[str, Any]) -> dict[str, list[dict[str, Any]]]:
    """The costs, a row for each number of fingers, process, activity and stage."""
    return {"cost": data["cost"]}
