"""Runtime cost: processor time of a tick of each process, by stage and number of fingers, and accuracy by cost.

Each session runs in one process and in lock step with its simulated devices, over real lines and a real link. Costs are
processor time of the loop's thread, in microseconds and in reference steps. Reference steps are comparable between
machines. Identification also runs on simulated touches with more and with less processor time.
"""

import os
import platform
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.runtime_cost.accuracy import accuracy
from benchmarks.runtime_cost.budget import exceeded, load_budget
from benchmarks.runtime_cost.finger_cost import finger_costs
from benchmarks.runtime_cost.measure import measure
from studies.compared import Compared
from studies.pieces import part_of
from studies.running import Progress, tables_of

MEASURES_THIS_MACHINE = "what a tick costs on this machine"
tables = tables_of("cost", "finger", "accuracy")
COMPARED = (
    Compared("cost", "reference_steps", "less", ("fingers", "process", "doing", "stage"), relative=0.33),
    Compared("accuracy", "reference_steps", "less", ("schedule",), relative=0.33),
    Compared("accuracy", "right", "more", ("schedule",), counted="hands"),
    Compared("accuracy", "wrong", "less", ("schedule",), counted="hands"),
)
_FINGERS = (1, 2, 3, 4, 5)
_QUICK_FINGERS = (1, 5)
_TOUCHES, _QUICK_TOUCHES = (12, 8), (1, 1)
"""Number of touches of each calibrated material, and number of other materials, each touched once."""
_ACCURACY_FROM = 0.6
"""Share of the study's progress at which the accuracy part begins, 0..1."""


def run(*, quick: bool, seed: int, progress: Progress) -> dict[str, Any]:
    """Measure sessions of different numbers of fingers.

    Args:
        quick: one and five fingers and few touches, little more than a minute; otherwise one to five fingers.
        seed: seed of the simulated devices, the hand and the touches.

    Raises:
        NotEngaged: the sites did not find their devices or each other.
    """
    numbers, touches = (_QUICK_FINGERS, _QUICK_TOUCHES) if quick else (_FINGERS, _TOUCHES)
    rows: list[dict[str, Any]] = []
    reference_ns: list[int] = []
    for place, fingers in enumerate(numbers):
        with tempfile.TemporaryDirectory(prefix="runtime-cost-") as folder:
            share = part_of(progress, *(_ACCURACY_FROM * done / len(numbers) for done in (place, place + 1)))
            spent = measure(fingers, seed, Path(folder), share)
        rows += spent.rows(fingers)
        reference_ns += spent.reference
    return {
        "machine": {"processors": os.cpu_count(), "python": platform.python_version()},
        "reference_step_us": round(float(np.median(reference_ns)) * 1e-3, 2),
        "cost": rows,
        "finger": finger_costs(rows),
        "accuracy": accuracy(*touches, seed, part_of(progress, _ACCURACY_FROM, 1.0)),
        "problems": exceeded(rows, *load_budget()),
    }
