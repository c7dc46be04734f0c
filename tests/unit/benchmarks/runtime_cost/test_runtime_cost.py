"""A tick costs no more than its budget, and the measure notices where it does."""

import time
from pathlib import Path

import pytest

from benchmarks.runtime_cost.budget import budget_text, exceeded, load_budget
from benchmarks.runtime_cost.finger_cost import finger_costs
from benchmarks.runtime_cost.measure import DOING, TICK, measure
from benchmarks.runtime_cost.stages import StageClock
from common.faults.fault import Fault
from common.runtime.reference_step import reference_step, reference_step_s
from teletaction.session.demo_files import PROCESSES
from tests.conftest import Contained


def row(process: str, stage: str, cost: float, fingers: int = 5) -> dict[str, object]:
    return {"fingers": fingers, "process": process, "stage": stage, "doing": "free", "reference_steps": cost}


def test_a_cost_more_than_a_third_above_its_budget_is_named() -> None:
    budget = {"remote": {"gate": {"free": 1.0}}}
    within, above = row("remote", "gate", 1.3), row("remote", "gate", 1.5)
    assert exceeded([within], 5, budget) == []
    assert exceeded([above], 5, budget) == ["remote, gate, fingers free: 1.50 reference steps a tick, 1.00 in budget"]
    assert exceeded([above], 1, budget) == [], "the budget is for five fingers"


def test_a_stage_without_a_budget_is_named() -> None:
    assert len(exceeded([row("remote", "new", 0.2)], 5, {"remote": {}})) == 1


def test_the_budget_names_every_process_and_activity() -> None:
    fingers, budget = load_budget()
    assert fingers == 5
    assert set(budget) == set(PROCESSES)
    for process in PROCESSES:
        assert set(budget[process][TICK]) == set(DOING)


def test_a_budget_that_is_written_anew_holds_what_was_measured(tmp_path: Path) -> None:
    rows = [row("remote", "gate", 1.25), row("sim-remote", "tick", 0.5), row("remote", "gate", 9.0, fingers=1)]
    (tmp_path / "budget.toml").write_text(budget_text(rows, 5))
    fingers, budget = load_budget(tmp_path / "budget.toml")
    assert (fingers, budget) == (5, {"remote": {"gate": {"free": 1.25}}, "sim-remote": {"tick": {"free": 0.5}}})


def test_a_reference_step_is_the_same_work_every_time() -> None:
    assert reference_step() == reference_step()
    assert 20e-6 < reference_step_s() < 2e-3


def test_stages_are_timed_and_contained(contained: Contained) -> None:
    latched: list[Fault] = []
    clock = StageClock(latched.append)
    with clock.step("outer"), clock.step("inner"):
        begun_ns = time.thread_time_ns()
        while time.thread_time_ns() - begun_ns < 2_000_000:
            pass
    with clock.step("broken"):
        raise ValueError("on purpose")
    spent = clock.take_spent_ns()
    assert set(spent) == {"outer", "broken"}
    assert spent["outer"] >= 2_000_000
    assert clock.take_spent_ns() == {}
    assert "on purpose" in latched[0].detail
    assert contained.take() == [latched[0].detail]


@pytest.mark.session
@pytest.mark.timeout(300)
def test_every_tick_of_five_fingers_is_within_its_budget(tmp_path: Path) -> None:
    fingers, budget = load_budget()
    rows = measure(fingers, 0, tmp_path).rows(fingers)
    assert {(each["process"], each["doing"]) for each in rows} == {(p, d) for p in PROCESSES for d in DOING}
    assert exceeded(rows, fingers, budget) == []


def test_what_a_finger_adds_is_the_difference_between_five_and_one() -> None:
    def costs(doing: str, identify_us: float) -> list[dict[str, object]]:
        parts = {"tick": 100.0 + identify_us, "identify": identify_us}
        return [
            {"process": "remote", "doing": doing, "stage": stage, "fingers": fingers, "mean_us": us * fingers}
            for fingers in (1, 5)
            for stage, us in parts.items()
        ]

    added = finger_costs([*costs("free", 10.0), *costs("resting", 40.0)])
    found = {(row["part"], row["doing"]): (row["finger_us"], row["free_share"]) for row in added}
    assert found["whole tick", "resting"] == (140.0, pytest.approx(110.0 / 140.0, abs=1e-3))
    assert found["identification", "resting"] == (40.0, 0.25)
    assert found["identification", "stroking"] == (0.0, None)
