"""The study of heat at the finger: what it measures is what it says."""

from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

from operator_site.thermal.contact_prediction import LEAD_S
from operator_site.thermal.model_selection import RUNGS, TOLERANCE_K
from studies.thermal_rendering.figure import plot
from studies.thermal_rendering.plate_strategies import OBJECTS
from studies.thermal_rendering.run import EXACT, EXPLICIT_EULER, SOLVERS, run, tables
from tests.unit.studies.written import draw_figure, write_tables


@cache
def data() -> dict[str, Any]:
    return run(quick=True, seed=0, progress=lambda _: None)


@pytest.mark.long
def test_the_runtime_chooses_the_first_rung_that_is_right_enough() -> None:
    rungs = [str(model) for model in RUNGS]
    for name in OBJECTS:
        mine = {row["model"]: row for row in data()["models"] if row["object"] == name}
        (chosen,) = (model for model, row in mine.items() if row["chosen"])
        assert mine[chosen]["share_of_tolerance"] <= 1.0
        for smaller in rungs[: rungs.index(chosen)]:
            assert mine[smaller]["share_of_tolerance"] > 0.8


@pytest.mark.long
def test_explicit_euler_diverges_just_where_the_fastest_cell_says() -> None:
    rows = [row for row in data()["integrators"] if row["method"] == EXPLICIT_EULER]
    assert {row["error_k"] is None for row in rows} == {True, False}
    for row in rows:
        assert (row["error_k"] is None) is (row["setting"] > row["diverges_above_s"])


@pytest.mark.long
def test_the_exact_step_is_the_cheapest_but_for_those_as_coarse() -> None:
    for row in data()["integrators"]:
        if row["method"] in SOLVERS:
            (exact,) = (
                each
                for each in data()["integrators"]
                if (each["method"], each["object"], each["model"]) == (EXACT, row["object"], row["model"])
            )
            assert row["products"] > 10.0 * exact["products"]
            assert exact["error_k"] == 0.0


@pytest.mark.long
@pytest.mark.parametrize("name", ["copper", "ceramic_tile", "pvc"])
def test_a_faster_plate_is_nearer_to_the_object(name: str) -> None:
    errors = [row["error_k"] for row in data()["rates"] if row["object"] == name]
    assert all(faster < slower for slower, faster in pairwise(errors[:4]))
    # The simulated skin is not the model's: some of the error is there at any rate.
    assert max(errors[3:]) < 0.4 * errors[0]


@pytest.mark.long
def test_only_what_starts_early_is_felt_early_and_the_runtimes_lead_is_too_little_to_be_felt() -> None:
    for row in data()["strategies"]:
        assert (row["early_k"] > 0.0) is ("early" in row["strategy"]), row
        if row["strategy"] == f"{LEAD_S:g} s early":
            assert row["early_k"] <= TOLERANCE_K
    leads = {name: best_strategy(name) for name in ("copper", "ceramic_tile", "pvc", "pine")}
    assert leads == {"copper": "1 s early", "ceramic_tile": "1 s early", "pvc": "0.3 s early", "pine": "0.3 s early"}


def best_strategy(name: str) -> str:
    mine = [row for row in data()["strategies"] if row["object"] == name and row["object_c"] == 25.0]
    return str(min(mine, key=lambda row: row["error_k"])["strategy"])


@pytest.mark.long
def test_an_inverted_model_turns_the_smallest_noise_into_kelvins_and_flux_matching_does_not() -> None:
    inverted = [row for row in data()["inverse"] if row["way"] == "one-step inverse" and row["step_s"] == 0.01]
    assert all(row["plate_noise_k"] > 1.0 for row in inverted if row["delay_s"] == 0.0)
    assert all(row["plate_noise_k"] is None for row in inverted if row["delay_s"] > 0.0)
    assert all(row["plate_noise_k"] < 0.01 for row in data()["inverse"] if row["way"] == "flux matching")


@pytest.mark.long
def test_through_plate_and_loop_the_finger_feels_what_the_rate_allows() -> None:
    """Also where ticks are of 50 ms, readings noisy by 0.1 K and late by 0.1 s."""
    assert {row["noise_k"] for row in data()["loop"]} == {0.0, 0.1}
    for row in data()["loop"]:
        assert row["share_where_rate_allows"] <= 2.0, row
        assert row["beyond_k"] <= 0.3, row
        assert row["plate_swing_k"] <= 0.3, row


@pytest.mark.long
def test_it_is_written_and_drawn(tmp_path: Path) -> None:
    write_tables(tables(data()), tmp_path)
    draw_figure(plot, data(), tmp_path, 50_000)
    assert len((tmp_path / "models.csv").read_text("utf-8").splitlines()) == 1 + len(data()["models"])
