"""Targets on a map are found where the quantity stands out most, and judged by the truth."""

import math

import pytest

from common.scenes.scene import Scene, SceneObject, load_scene
from operator_site.console.map.finger_samples import Sample
from operator_site.console.map.tactile_map import TactileMap
from teletaction.report.found_targets import find_target, found_targets, value_near
from teletaction.report.report_words import targets_table


def presses(*hot_mm: tuple[int, int], there_n_m: float = 1800.0) -> TactileMap:
    """Presses every 7 mm, of another stiffness at these."""
    touched = TactileMap()
    for number, (x, y) in enumerate((x, y) for x in range(0, 56, 7) for y in range(0, 56, 7)):
        value = math.log(there_n_m if (x, y) in hot_mm else 600.0)
        touched.take(Sample("stiffness", (1, number, 0), number, 1, 1e-3 * x, 1e-3 * y, 0.0, value, 0.03**2))
    return touched


FOUR = ((14, 14), (21, 14), (14, 21), (21, 21))


@pytest.mark.parametrize(
    ("hot_mm", "middle_m"), [(FOUR, (0.0175, 0.0175)), (((14, 14), (21, 14), (49, 49)), (0.0175, 0.014))]
)
def test_a_target_is_the_centre_of_the_largest_outstanding_place(
    hot_mm: tuple[tuple[int, int], ...], middle_m: tuple[float, float]
) -> None:
    touched = presses(*hot_mm)
    found = find_target(touched, "stiffness")
    assert found is not None
    assert (found.x_m, found.y_m) == pytest.approx(middle_m, abs=0.3e-3)
    assert value_near(touched, "stiffness", found).value == pytest.approx(1800.0, rel=1e-3)


def test_nothing_is_found_on_an_untouched_map() -> None:
    assert find_target(TactileMap(), "roughness") is None
    assert find_target(presses(), "temperature") is None


def scene() -> Scene:
    """A stiff target, its middle at 18 and 17 mm, and a warm one where nobody was."""
    stiff = SceneObject(
        name="<b>stiff</b>",
        material="skin_dermis",
        surface="skin",
        x_m=0.010,
        length_m=0.016,
        y_m=0.010,
        width_m=0.014,
        stiffness_n_m=1700.0,
        target="stiffness",
    )
    warm = stiff.model_copy(update={"name": "warm", "x_m": 0.2, "target": "temperature", "absolute_c": 35.0})
    return load_scene("phantom_sweep").model_copy(update={"objects": (stiff, warm)})


def test_a_target_is_judged_by_its_place_and_its_value_and_has_a_row_in_the_report() -> None:
    stiff, warm = rows = found_targets(scene(), presses(*FOUR))
    assert stiff["place_error_mm"] == pytest.approx(math.hypot(0.5, 0.5), abs=0.4)
    assert stiff["error"] == pytest.approx(100.0, rel=0.01)
    assert stiff["around"] == pytest.approx(600.0, rel=1e-3)
    assert (warm["target"], warm["value"], warm["place_error_mm"]) == ("warm", None, None)
    html = str(targets_table(rows))
    for words in ("&lt;b&gt;stiff&lt;/b&gt;", "<td>1700 N/m</td>", "<td>600 N/m</td>", "<td>+100 ± 50 N/m</td>"):
        assert words in html
    assert "<td>not felt</td>" in html


def test_a_target_that_is_softer_than_its_surroundings_is_found() -> None:
    stiff, _ = scene().objects
    soft = stiff.model_copy(update={"stiffness_n_m": 200.0})
    around = stiff.model_copy(update={"name": "around", "x_m": 0.026, "stiffness_n_m": 600.0, "target": None})
    bench = scene().model_copy(update={"objects": (soft, around)})
    (row,) = found_targets(bench, presses(*FOUR, there_n_m=200.0))
    assert row["place_error_mm"] == pytest.approx(math.hypot(0.5, 0.5), abs=0.4)
    assert row["value"] == pytest.approx(200.0, rel=0.01)


def test_an_untouched_target_is_not_found_elsewhere() -> None:
    away = scene().model_copy(update={"objects": (scene().objects[0].model_copy(update={"x_m": 0.1}),)})
    (row,) = found_targets(away, presses((14, 14), (21, 14)))
    assert row["value"] is None


def test_the_scene_for_finding_has_one_of_each() -> None:
    rows = found_targets(load_scene("phantom_sweep"), TactileMap())
    assert {row["target"]: row["quantity"] for row in rows} == {
        "warm_spot": "temperature",
        "lesion": "roughness",
        "nodule": "stiffness",
    }
    assert found_targets(load_scene("materials"), TactileMap()) == []


def test_a_rough_target_has_its_row_in_the_report() -> None:
    rough = {"target": "lesion", "quantity": "roughness", "place_error_mm": 0.5, "value": 0.08, "sd": 0.004}
    text = str(targets_table([{**rough, "around": 0.005, "true_value": None, "error": None}]))
    assert "8.0 ± 0.1 of 10" in text
    assert "1.99 of 10" in text
