"""The study of heat at the finger: what it measures is what it says."""

from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

from operator_site.model_choice import RUNGS
from studies.registry import write_table
from studies.thermal_rendering import EXACT, EXPLICIT_EULER, OBJECTS, SOLVERS, plot, run, tables


@cache
def data() -> dict[str, Any]:
    return run(quick=True, seed=0, tell=lambda _: None)


def test_the_runtime_chooses_the_first_rung_that_is_right_enough() -> None:
    rungs = [str(model) for model in RUNGS]
    for name in OBJECTS:
        mine = {row["model"]: row for row in data()["models"] if row["object"] == name}
        (chosen,) = (model for model, row in mine.items() if row["chosen"])
        assert mine[chosen]["share_of_tolerance"] <= 1.0
        for smaller in rungs[: rungs.index(chosen)]:
            assert mine[smaller]["share_of_tolerance"] > 0.8


def test_explicit_euler_diverges_just_where_the_fastest_cell_says() -> None:
    rows = [row for row in data()["integrators"] if row["method"] == EXPLICIT_EULER]
    assert {row["error_k"] is None for row in rows} == {True, False}
    for row in rows:
        assert (row["error_k"] is None) is (row["setting"] > row["diverges_above_s"])


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


@pytest.mark.parametrize("name", ["copper", "ceramic_tile", "pvc"])
def test_a_faster_plate_is_nearer_to_the_scene(name: str) -> None:
    errors = [row["error_k"] for row in data()["plates"] if row["object"] == name and row["lead_s"] == 0.0]
    # A finger on a plate rests a little otherwise than one in the air: 0.03 K remain at any rate.
    assert all(faster <= slower + 1e-3 for slower, faster in pairwise(errors))
    assert errors[-1] < 0.04 < 0.1 < errors[0]


def test_what_starts_early_is_felt_early() -> None:
    for row in data()["plates"]:
        assert (row["early_k"] > 0.0) is (row["lead_s"] > 0.0)


def test_it_is_written_and_drawn(tmp_path: Path) -> None:
    for name, rows in tables(data()).items():
        write_table(tmp_path / f"{name}.csv", rows)
    plot(data(), tmp_path / "figure.png")
    assert (tmp_path / "figure.png").stat().st_size > 50_000
    assert len((tmp_path / "models.csv").read_text("utf-8").splitlines()) == 1 + len(data()["models"])
