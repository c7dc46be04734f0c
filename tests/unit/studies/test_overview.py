"""The overview: what it reads in each study's data, and that it says what is not there."""

import json
from pathlib import Path
from typing import Any

import pytest
from matplotlib.figure import Figure

from benchmarks.link import latency, load
from studies.overview import Part, Way, draw, overview_rows, plot
from studies.overview_parts import BARE, LINK_LATE, LINK_LOAD, PARTS, parts_in
from tests.unit.studies.written import draw_figure


def deadband(motion: str, reckoning: str, step_mm: float, share: float, off_mm: float) -> dict[str, Any]:
    way = {"motion": motion, "rate_hz": 1000.0, "reckoning": reckoning}
    return way | {"step_mm": step_mm, "sent_share": share, "p95_mm": off_mm}


def run(stable: bool, felt_n_m: float | None, link: str = "steady", name: str = "local model") -> dict[str, Any]:
    made = {"architecture": name, "stable": stable, "felt_n_m": felt_n_m, "link": link}
    return made | {"wall_n_m": 100.0, "produced_mj": 0.1}


MADE_UP: dict[str, tuple[dict[str, Any], list[Way]]] = {
    "thermal-identification": (
        {
            "accuracy": [
                {"method": "1 finger", "materials": 4, "t_s": 2.0, "right": 0.9},
                {"method": "1 finger", "materials": 12, "t_s": 2.0, "right": 0.1},
                {"method": "paper", "materials": 4, "t_s": 2.0, "right": 0.5},
                {"method": "silent", "materials": 4, "t_s": 2.0, "right": None},
            ],
            "cost": [{"method": method, "ratio_all": 3.0} for method in ("paper", "silent", "1 finger", "2 fingers")],
        },
        [Way("paper", 3.0, 50.0), Way("model of the touch", 3.0, 10.0, baseline=False)],
    ),
    "thermal-rendering": (
        {
            "models": [
                {"model": "1+1+1", "products": 1.0, "share_of_tolerance": 3.0, "chosen": False},
                {"model": "1+1+1", "products": 2.0, "share_of_tolerance": 0.5, "chosen": True},
                {"model": "4+1+1+6", "products": 2.5, "share_of_tolerance": 0.8, "chosen": True},
            ]
        },
        [Way("1+1+1", 1.5, 3.0), Way("4+1+1+6", 2.5, 0.8), Way("chosen for each object", 2.25, 0.8, baseline=False)],
    ),
    "texture": (
        {
            "accuracy": [{"method": name, "time_s": 0.5, "share": 0.75} for name in ("paper", "shipped")],
            "cost": {"methods": [{"method": name, "of_one_core": 0.01} for name in ("paper", "shipped")]},
        },
        [Way("paper", 1.0, 25.0), Way("shipped", 1.0, 25.0, baseline=False)],
    ),
    "deadband": (
        {
            "sweep": [
                deadband("scripted", "linear", 0.1, 0.9, 9.0),
                deadband("recorded", "hold", 0.1, 0.5, 0.1),
                deadband("recorded", "linear", 0.1, 0.25, 0.05),
                deadband("recorded", "linear", 1.0, 0.1, 9.0),
            ]
        },
        [
            Way("hold, 0.1 mm", 50.0, 0.1),
            Way("linear, 0.1 mm", 25.0, 0.05, baseline=False),
            Way("every packet", 100.0, 0.0),
        ],
    ),
    "link": (
        {
            "latency": {
                "ways": [
                    {"way": "link, encoded to checked", "median_us": 40.0},
                    {"way": "link, with its encoding", "median_us": 50.0},
                    {"way": "bare CurveZMQ", "median_us": 30.0},
                ]
            },
            "cpu": {"all_cpu": {"link": 0.11, "bare CurveZMQ": 0.08, "loop alone": 0.05}},
        },
        [Way("link", 11.0, 40.0, baseline=False), Way("bare CurveZMQ", 8.0, 30.0)],
    ),
    "teleoperation-stability": (
        {
            "matrix": [
                run(True, 90.0),
                run(True, 50.0, "loss 5 %"),
                run(True, None),
                run(True, 80.0, name="waves"),
                run(False, 10.0, name="waves"),
            ]
        },
        [Way("local model", 0.0, 10.0, baseline=False), Way("waves", 50.0, 20.0)],
    ),
}


@pytest.mark.parametrize("study", PARTS)
def test_each_part_has_the_cost_and_the_error_of_each_way(study: str) -> None:
    data, ways = MADE_UP[study]
    found = list(PARTS[study](data).ways)
    assert [(way.name, way.baseline) for way in found] == [(way.name, way.baseline) for way in ways]
    for way, expected in zip(found, ways, strict=True):
        assert (way.cost, way.error) == pytest.approx((expected.cost, expected.error))


def test_scripted_hands_stand_where_there_are_no_recorded_ones() -> None:
    part = PARTS["deadband"]({"sweep": [deadband("scripted", "hold", 0.1, 0.5, 0.1)]})
    assert "scripted hands" in part.title
    assert part.ways[0].cost == 50.0


@pytest.mark.long
def test_a_study_that_was_not_run_is_said_to_be_and_the_others_are_drawn(tmp_path: Path) -> None:
    for study in ("texture", "thermal-rendering"):
        (tmp_path / f"{study}.json").write_text(json.dumps(MADE_UP[study][0]))
    parts = parts_in(tmp_path)
    assert [study for study, part in parts.items() if part is not None] == ["thermal-rendering", "texture"]
    rows = overview_rows(parts)
    assert len(rows) == 5
    assert {"study": "texture", "way": "shipped", "baseline": False, "error": 25.0}.items() <= rows[-1].items()
    draw_figure(plot, parts, tmp_path, 20_000)


def test_axes_show_every_way() -> None:
    axes = Figure().subplots()
    draw(axes, Part("t", "c", "e", [Way("a", 0.02, 3.0), Way("b", 40.0, 700.0, baseline=False)], "xy"))
    for low, high, values in ((*axes.get_xlim(), (0.02, 40.0)), (*axes.get_ylim(), (3.0, 700.0))):
        assert all(low < value < high for value in values)
    assert [text.get_text() for text in axes.get_legend().get_texts()] == ["a", "b"]


def test_the_ways_of_the_link_are_named_as_in_its_study() -> None:
    assert (LINK_LATE, BARE) == (latency.LINK, latency.CURVE)
    assert (LINK_LOAD, BARE) == (load.LINK, load.CURVE)
