"""The study of the tactile map: what it measures is what it says."""

import math
from functools import cache
from pathlib import Path
from typing import Any

import pytest

from operator_site.console.finger_samples import Sample
from operator_site.console.tactile_map import TactileMap
from studies.found_targets import find_highest, value_near
from studies.tactile_map import GOAL_K, GOAL_M, GOAL_SHARE, TARGETS, plot, run, tables


@cache
def data() -> dict[str, Any]:
    return run(quick=True, seed=0, tell=lambda _: None)


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


@pytest.mark.timeout(240)
def test_it_says_what_it_takes_in_time_and_draws_it(tmp_path: Path) -> None:
    seconds = data()["seconds"]
    assert seconds["whole"] == pytest.approx(seconds["strokes"] + seconds["presses"] + seconds["rests"])
    assert seconds["rests"] > seconds["strokes"]
    assert tables(data())["targets"] == data()["targets"]
    plot(data(), tmp_path / "map.png")
    assert (tmp_path / "map.png").stat().st_size > 20_000


def presses(*hot_mm: tuple[int, int]) -> TactileMap:
    """Presses every 7 mm, stiffer at these."""
    felt = TactileMap()
    for number, (x, y) in enumerate((x, y) for x in range(0, 56, 7) for y in range(0, 56, 7)):
        value = math.log(1800.0 if (x, y) in hot_mm else 600.0)
        felt.take(Sample("stiffness", (1, number, 0), number, 1, 1e-3 * x, 1e-3 * y, 0.0, value, 0.03**2))
    return felt


def test_a_target_is_the_middle_of_what_stands_out() -> None:
    felt = presses((14, 14), (21, 14), (14, 21), (21, 21))
    found = find_highest(felt, "stiffness")
    assert found is not None
    assert (found.x_m, found.y_m) == pytest.approx((0.0175, 0.0175), abs=0.3e-3)
    assert value_near(felt, "stiffness", found).value == pytest.approx(1800.0, rel=1e-3)


def test_of_two_places_the_larger_counts() -> None:
    found = find_highest(presses((14, 14), (21, 14), (49, 49)), "stiffness")
    assert found is not None
    assert (found.x_m, found.y_m) == pytest.approx((0.0175, 0.014), abs=0.3e-3)


def test_where_nothing_was_felt_nothing_is_found() -> None:
    assert find_highest(TactileMap(), "roughness") is None
    assert find_highest(presses(), "temperature") is None
