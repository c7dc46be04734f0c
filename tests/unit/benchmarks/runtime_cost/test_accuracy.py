"""Identification by its cost: accuracy depends on the schedule and the seed alone, and starvation names nothing."""

import math
from dataclasses import replace
from pathlib import Path

import pytest

from benchmarks.runtime_cost import figure
from benchmarks.runtime_cost.accuracy import SCHEDULES, Found, accuracy
from remote_site.identification.perception import AT_ONCE, FOREIGN_SHARE
from remote_site.thermal.material_table import MaterialTable
from remote_site.thermal.thermal_identification import ThermalKnowledge
from studies.thermal_identification.answers import by_product
from studies.thermal_identification.situations import FOUR, STAGGERED_K, Situation, touched
from teletaction.session.demo_files import TABLES

pytestmark = pytest.mark.long

SEED = 3
FEW = [each for each in SCHEDULES if each.name in ("every reading", "every 0.2 s", "never")]
COSTS = ("reference_steps", "reference_steps_touch")


@pytest.fixture(scope="module")
def rows() -> list[dict[str, object]]:
    return accuracy(1, 1, SEED, schedules=FEW)


def test_less_budget_costs_less(rows: list[dict[str, object]]) -> None:
    assert [row["schedule"] for row in rows] == ["every reading", "every 0.2 s", "never"]


def test_accuracy_is_the_same_in_every_run(rows: list[dict[str, object]]) -> None:
    again = accuracy(1, 1, SEED, schedules=FEW)
    without = [[{key: row[key] for key in row if key not in COSTS} for row in each] for each in (rows, again)]
    assert without[0] == without[1]


def test_plenty_names_and_starvation_does_not(rows: list[dict[str, object]]) -> None:
    plenty, some, never = rows
    for row in (plenty, some):
        assert row["right"] > 0.0
        assert row["object_known"] == len(FOUR)
    for key in ("right", "wrong", "object_known", "strangers_named"):
        assert never[key] == 0
    assert never["named_s"] is never["object_rms_k"] is None


@pytest.fixture(scope="module")
def knowledge() -> ThermalKnowledge:
    return ThermalKnowledge.of(MaterialTable.load(TABLES / "materials.json"), AT_ONCE, FOREIGN_SHARE)


def every(knowledge: ThermalKnowledge, interval_s: float) -> ThermalKnowledge:
    return replace(knowledge, solve_every_s=((math.inf, interval_s),))


def test_starved_identification_is_deciding(knowledge: ThermalKnowledge) -> None:
    for material in FOUR:
        (hand,) = touched(Situation(material, SEED, 1, STAGGERED_K[:2], seconds=1.05))
        for answer in by_product(every(knowledge, math.inf), "", hand, (0.5, 1.0), fingers=2):
            assert (answer.status, answer.error_k, answer.named_s) == ("deciding", None, None)


def test_a_hand_solved_late_or_seldom_is_known_later(knowledge: ThermalKnowledge) -> None:
    (hand,) = touched(Situation("aluminium", SEED, 1, STAGGERED_K, seconds=5.05))
    usual, late, seldom = (
        by_product(known, "", hand, (0.3, 1.2, 5.0), fingers=5, late=late)
        for known, late in ((knowledge, False), (knowledge, True), (every(knowledge, 0.5), False))
    )
    known = [[answer.error_k is not None for answer in answers] for answers in (usual, late, seldom)]
    assert known == [[True, True, True], [False, True, True], [False, False, True]]
    assert seldom[-1].named_s is not None
    assert 0.0 <= math.remainder(seldom[-1].named_s, 0.5) <= 0.02, "the hand is judged when its fingers are solved"


def found(right: int, wrong: int, of: int = 20) -> Found:
    named = [1.0] * right + [0.0] * (of - right)
    return Found(named, [0.0] * (of - wrong) + [1.0] * wrong, [1.0] * of, [0.1] * of, [1000] * of)


def test_fewer_right_or_more_wrong_names_fail() -> None:
    plenty = found(15, 1)
    cases = {(15, 1): False, (18, 0): False, (14, 1): False, (8, 1): True, (15, 2): True}
    assert {case: found(*case).row("", plenty, 100.0)["fails"] for case in cases} == cases


def test_costs_are_in_reference_steps() -> None:
    row = found(15, 1).row("", found(15, 1), 100.0)
    assert row["reference_steps_touch"] == 10.0
    assert row["reference_steps"] == pytest.approx(10.0 / 305, abs=1e-3)


def test_the_figure_is_drawn_where_nothing_is_named(rows: list[dict[str, object]], tmp_path: Path) -> None:
    cost = [
        {"process": process, "doing": doing, "stage": "tick", "fingers": 1, "reference_steps": 1.0}
        for process in figure.PROCESSES
        for doing in ("free", "resting")
    ]
    starved = [row | {"named_s": None, "named_p90_s": None, "object_rms_k": None, "fails": True} for row in rows]
    for number, each in enumerate((rows, starved)):
        figure.plot({"cost": cost, "accuracy": each, "reference_step_us": 100.0}, tmp_path / f"{number}.png")
        assert (tmp_path / f"{number}.png").stat().st_size > 10_000
