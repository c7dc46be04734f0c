"""The study of texture: what it shows of the paper's method fails there, and holds here."""

from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from studies.texture.figure import plot
from studies.texture.paper_method import PaperRoughness
from studies.texture.run import Sizes, measure, tables
from tests.unit.studies.written import draw_figure, write_tables


@cache
def data() -> dict[str, Any]:
    return measure(Sizes(learn=2, judge=3, changes=1, grooves=0), seed=0, progress=lambda _: None)


@pytest.mark.long
def test_the_shipped_method_is_right_more_often_than_the_paper_s_and_the_classic_ones() -> None:
    right = {row["method"]: row["right"] for row in data()["accuracy"] if row["time_s"] == 1.0}
    assert right["shipped"] == max(right.values())
    assert right["paper"] < right["shipped"]


@pytest.mark.long
def test_roughness_is_freed_of_speed_and_force() -> None:
    before, after = ([row["scatter"] for row in data()["scatter"] if row["normalised"] is way] for way in (False, True))
    assert max(after) < 0.15
    assert sum(after) < 0.5 * sum(before)


@pytest.mark.long
def test_the_paper_s_hold_latches_and_its_mean_drifts() -> None:
    smooth_to_rough, rough_to_smooth = data()["courses"]
    assert all(smooth_to_rough["held"][-100:])
    assert smooth_to_rough["shipped_v"][-1] > 0.1
    assert rough_to_smooth["paper_v"][-1] > 0.3 * max(rough_to_smooth["paper_v"])
    assert rough_to_smooth["shipped_v"][-1] < 0.01


@pytest.mark.long
def test_what_it_writes_can_be_read(tmp_path: Path) -> None:
    write_tables(tables(data()), tmp_path)
    draw_figure(plot, data(), tmp_path)


def test_the_paper_s_mean_leaves_a_pattern_out() -> None:
    roughness, chance = PaperRoughness(), np.random.default_rng(0)
    for number in range(100):
        roughness.step(chance.normal(0.0, 0.01, 10) - (1.0 if number in (50, 51) else 0.0))
        assert roughness.began == (number == 50)
    assert roughness.mean_v == pytest.approx(0.008, rel=0.1)
