"""The study of vibration: what it measures is what it says."""

from functools import cache
from pathlib import Path
from typing import Any

import pytest

from studies.vibration.figure import plot
from studies.vibration.run import ALONE, COMPENSATED, EARLY, LIMIT, run, tables
from tests.unit.studies.written import draw_figure, write_tables


@cache
def data() -> dict[str, Any]:
    return run(quick=True, seed=0, progress=lambda _: None)


def by_way(table: str, way: str) -> list[dict[str, Any]]:
    return [row for row in data()[table] if row["way"] == way]


@pytest.mark.long
def test_a_tap_has_its_strength_but_for_a_motor_left_alone() -> None:
    for way in (COMPENSATED, EARLY, LIMIT):
        assert all(abs(row["peak_intensity_share"] - 1.0) <= 0.2 for row in by_way("taps", way)), way
    assert all(row["peak_intensity_share"] < 0.8 for row in by_way("taps", ALONE))


@pytest.mark.long
def test_a_known_contact_is_felt_when_it_happens_and_nothing_is_faster_than_the_limit() -> None:
    for early, compensated, limit in zip(*(by_way("taps", way) for way in (EARLY, COMPENSATED, LIMIT)), strict=True):
        assert abs(early["near_after_s"]) <= 0.008 < limit["near_after_s"] + 0.002
        assert limit["near_after_s"] <= compensated["near_after_s"] <= limit["near_after_s"] + 0.008


@pytest.mark.long
def test_grooves_are_resolved_until_they_fold() -> None:
    for row in by_way("impulses", "rendered"):
        assert (row["depth"] > 0.4) if row["rate_hz"] <= 15.0 else (row["rate_hz"] < 20.0 or row["depth"] < 0.01)
    assert by_way("impulses", ALONE)[-1]["depth"] < 0.2


@pytest.mark.long
def test_matched_intensity_is_a_straight_line_above_the_floor() -> None:
    matched = [row for row in data()["scales"] if row["scale"] == "intensity" and row["felt_share"] > 0.0]
    assert len(matched) > 80
    assert all(abs(row["felt_share"] - row["asked_share"]) < 1e-9 for row in matched)


@pytest.mark.long
def test_tables_and_figure_are_written(tmp_path: Path) -> None:
    write_tables(tables(data()), tmp_path)
    draw_figure(plot, data(), tmp_path, 20_000)
