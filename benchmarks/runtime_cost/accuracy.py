"""Measures the accuracy of identification against its cost, on the same touches solved at different intervals.

A schedule sets when the touch model may be solved. It reads no clock, so that the seed alone determines the accuracy.
The cost of each schedule is measured.
"""

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from scipy.stats import binomtest

from benchmarks.runtime_cost.measure import timed
from common.runtime.reference_step import reference_step
from remote_site.identification.perception import AT_ONCE, FOREIGN_SHARE
from remote_site.thermal.material_table import MaterialTable
from remote_site.thermal.solving_turns import POSTPONED_S
from remote_site.thermal.thermal_identification import ThermalKnowledge
from remote_site.thermal.touch_estimate import SOLVE_EVERY_S, Intervals
from studies.pieces import one_thread
from studies.thermal_identification.answers import READING_S, by_product
from studies.thermal_identification.situations import FOUR, STAGGERED_K, TWELVE, Hand, Situation, touched
from teletaction.session.demo_files import TABLES

OBJECT_S, END_S = 2.0, 3.0
"""Times after contact at which the object's temperature and the material's name are judged, s."""
SURE_SES = 2.0
"""Least paired difference of two shares that counts, in standard errors."""
_SECONDS = END_S + 0.05
_FIRST_SEED = 440_000


@dataclass(frozen=True, slots=True)
class Schedule:
    """Schedule of solving the touch model.

    Attributes:
        name: name in its rows.
        solve_every_s: see `SOLVE_EVERY_S`.
        late: whether every tick is late, so that each solution waits for POSTPONED_S.
    """

    name: str
    solve_every_s: Intervals
    late: bool = False


PLENTY, PRODUCT, LATE = "every reading", "product", f"product, always late ({POSTPONED_S:g} s)"
SCHEDULES = (
    Schedule(PLENTY, ((math.inf, READING_S),)),
    *(Schedule(f"every {every_s:g} s", ((math.inf, every_s),)) for every_s in (0.02, 0.1, 0.2, 0.5, 1.0, 2.0)),
    Schedule("never", ((math.inf, math.inf),)),
    Schedule(PRODUCT, SOLVE_EVERY_S),
    Schedule(LATE, SOLVE_EVERY_S, late=True),
)


@dataclass(slots=True)
class Found:
    """Results of one schedule; all but `strangers` concern hands on calibrated materials.

    Attributes:
        right, wrong: 1 for each hand whose name is right or wrong at END_S, else 0.
        named_s: time until each hand named a material, s; None without a name.
        errors_k: errors of the object's temperature at OBJECT_S, K, where it is estimated.
        spent_ns: processor time of each hand.
        strangers: True for each hand on another material that named one.
    """

    right: list[float] = field(default_factory=list)
    wrong: list[float] = field(default_factory=list)
    named_s: list[float | None] = field(default_factory=list)
    errors_k: list[float] = field(default_factory=list)
    spent_ns: list[int] = field(default_factory=list)
    strangers: list[bool] = field(default_factory=list)

    def take(self, knowledge: ThermalKnowledge, schedule: Schedule, hand: Hand) -> None:
        """Identify one hand."""
        begun_ns = time.thread_time_ns()
        early, end = by_product(knowledge, "", hand, (OBJECT_S, END_S), len(hand.fingers), schedule.late)
        spent_ns = time.thread_time_ns() - begun_ns
        named = end.status == "identified"
        if hand.material not in FOUR:
            self.strangers.append(named)
            return
        self.spent_ns.append(spent_ns)
        self.right.append(float(named and end.best == hand.material))
        self.wrong.append(float(named and end.best != hand.material))
        self.named_s.append(end.named_s)
        if early.error_k is not None:
            self.errors_k.append(early.error_k)

    def row(self, schedule: str, plenty: "Found", reference_ns: float) -> dict[str, Any]:
        """Return the row of a schedule; it `fails` if it names fewer rightly, or more wrongly, than `plenty`.

        `reference_steps` is the cost of a reading of all fingers, and `reference_steps_touch` that of a touch.
        """
        hands, touch = len(self.right), float(np.median(self.spent_ns)) / reference_ns
        fewer = np.subtract(plenty.right, self.right)
        fewer_right, se = float(fewer.mean()), float(fewer.std()) / math.sqrt(hands)
        right_s = [t_s for t_s, right in zip(self.named_s, self.right, strict=True) if right and t_s is not None]
        named_s, named_p90_s = np.percentile(right_s, (50, 90)).round(2).tolist() if right_s else (None, None)
        return {
            "schedule": schedule,
            "reference_steps": round(touch * READING_S / _SECONDS, 3),
            "reference_steps_touch": round(touch, 1),
            "hands": hands,
            **_share("right", self.right),
            **_share("wrong", self.wrong),
            "named_s": named_s,
            "named_p90_s": named_p90_s,
            "object_known": len(self.errors_k),
            "object_rms_k": round(float(np.sqrt(np.mean(np.square(self.errors_k)))), 3) if self.errors_k else None,
            "fewer_right": round(fewer_right, 4),
            "fewer_right_se": round(se, 4),
            "strangers": len(self.strangers),
            "strangers_named": sum(self.strangers),
            "fails": fewer_right > SURE_SES * se or sum(self.wrong) > sum(plenty.wrong),
        }


def accuracy(
    touches: int,
    strangers: int,
    seed: int,
    progress: Callable[[float], object] = lambda _: None,
    schedules: Sequence[Schedule] = SCHEDULES,
) -> list[dict[str, Any]]:
    """Return a row for each schedule, the costliest first.

    Args:
        touches: hands of five fingers on each calibrated material, at least 1.
        strangers: number of materials that are not calibrated, each touched once, 0 to 8.
        seed: seed of the touches.
        progress: receives the share done, 0..1.
        schedules: schedules with different names; the others are compared with the first.
    """
    table = MaterialTable.load(TABLES / "materials.json")
    own = ThermalKnowledge.of(table, AT_ONCE, FOREIGN_SHARE)
    counts = {**dict.fromkeys(FOUR, touches), **dict.fromkeys(TWELVE[len(FOUR) :][:strangers], 1)}
    situations = [
        Situation(material, _FIRST_SEED + 100 * seed + number, count, STAGGERED_K, seconds=_SECONDS)
        for number, (material, count) in enumerate(counts.items())
    ]
    known = [(schedule, replace(own, solve_every_s=schedule.solve_every_s)) for schedule in schedules]
    found = {schedule.name: Found() for schedule in schedules}
    reference_ns: list[int] = []
    with one_thread():
        for place, situation in enumerate(situations):
            for hand in touched(situation):
                for schedule, knowledge in known:
                    found[schedule.name].take(knowledge, schedule, hand)
                    reference_ns.append(timed(reference_step))
            progress((place + 1) / len(situations))
    reference = float(np.median(reference_ns))
    rows = [each.row(name, found[schedules[0].name], reference) for name, each in found.items()]
    return sorted(rows, key=lambda row: -float(row["reference_steps"]))


def _share(name: str, which: Sequence[float]) -> dict[str, float]:
    """Return the share of ones with its 95 % interval."""
    low, high = binomtest(int(sum(which)), len(which)).proportion_ci()
    return {name: round(sum(which) / len(which), 4), f"{name}_low": round(low, 4), f"{name}_high": round(high, 4)}
