"""Lumps on a map are listed beside the nodules of a scene."""

import math

import numpy as np
import pytest

from common.scenes.tissue import Nodule
from operator_site.console.map.finger_samples import Sample
from operator_site.console.map.tactile_map import TactileMap
from teletaction.report.found_lumps import found_lumps
from teletaction.report.report_words import lumps_table

LUMP_MM = (20.0, 28.0)


def pressed() -> TactileMap:
    """Presses every 4 mm, with a lump of 12 mm that is twice as stiff in its middle."""
    surface, random = TactileMap(), np.random.default_rng(5)
    for number, (x, y) in enumerate((x, y) for x in range(0, 60, 4) for y in range(0, 60, 4)):
        lift = math.log(2.0) * math.exp(-((math.dist((x, y), LUMP_MM) / 6.0) ** 2))
        value = math.log(600.0) + lift + 0.02 * random.normal()
        surface.take(Sample("stiffness", (1, number, 0), number, 1, 1e-3 * x, 1e-3 * y, 0.0, value, 0.02**2))
    return surface


def nodule(name: str, x_m: float, y_m: float) -> Nodule:
    return Nodule(name=name, x_m=x_m, y_m=y_m, size_m=0.012, depth_m=0.003, ratio=8.0)


def test_a_lump_shows_the_nodule_below_it_and_another_nodule_is_not_found() -> None:
    rows = found_lumps(pressed(), (nodule("far", 0.050, 0.050), nodule("near", 0.021, 0.029)))
    assert [row["nodule"] for row in rows] == ["near", "far"]
    found, missed = rows
    assert (found["x_mm"], found["y_mm"]) == pytest.approx(LUMP_MM, abs=1.5)
    assert found["place_error_mm"] == pytest.approx(math.dist((21.0, 29.0), (found["x_mm"], found["y_mm"])), abs=0.01)
    assert found["probability"] > 0.9
    assert found["stiffness_ratio"] > 1.3
    assert missed["probability"] is None
    assert missed["true_size_mm"] == pytest.approx(12.0)


def test_a_lump_without_a_nodule_is_listed_as_it_is() -> None:
    (row,) = found_lumps(pressed())
    assert row["nodule"] is row["place_error_mm"] is None
    assert row["probability"] > 0.9
    assert found_lumps(TactileMap()) == []


def test_the_table_says_what_was_found_and_what_was_not() -> None:
    text = str(lumps_table(found_lumps(pressed(), (nodule("<far>", 0.050, 0.050),))))
    assert "&lt;far&gt;" in text
    assert "<far>" not in text
    assert text.count("<tr>") == 3
    assert "not found" in text
