"""The study of the tactile map: what it measures is what it says."""

from functools import cache
from pathlib import Path
from typing import Any

import pytest

from studies.tactile_map.figure import plot
from studies.tactile_map.run import GOAL_K, GOAL_M, GOAL_SHARE, SURE, TARGETS, run, tables
from tests.unit.studies.written import draw_figure


@cache
def data() -> dict[str, Any]:
    return run(quick=True, seed=0, progress=lambda _: None)


@pytest.mark.study
@pytest.mark.timeout(240)  # some two minutes of virtual time, half a minute of a free core
def test_a_sweep_finds_all_three_targets() -> None:
    rows = {row["target"]: row for row in data()["targets"]}
    assert set(rows) == set(TARGETS)
    assert data()["problems"] == []
    for row in rows.values():
        assert row["place_error_mm"] <= 1e3 * GOAL_M
    assert abs(rows["warm_spot"]["error"]) <= GOAL_K
    assert abs(rows["nodule"]["error"]) <= GOAL_SHARE * rows["nodule"]["true_value"]
    assert rows["lesion"]["value"] > 5.0 * rows["lesion"]["around"]


@pytest.mark.study
@pytest.mark.timeout(240)
def test_every_nodule_is_outlined_within_two_minutes_and_nothing_else() -> None:
    assert data()["palpated_s"] <= 120.0
    assert len(data()["nodules"]) == 3
    for row in data()["nodules"]:
        assert row["probability"] >= SURE, row["nodule"]
        assert row["place_error_mm"] <= 3.0
    assert data()["false_outlines"] == 0


@pytest.mark.study
@pytest.mark.timeout(240)
def test_it_says_what_it_takes_in_time_and_draws_it(tmp_path: Path) -> None:
    seconds = data()["seconds"]
    assert seconds["whole"] == pytest.approx(seconds["strokes"] + seconds["presses"] + seconds["rests"])
    assert seconds["rests"] > seconds["strokes"]
    assert tables(data())["targets"] == data()["targets"]
    draw_figure(plot, data(), tmp_path, 20_000)
