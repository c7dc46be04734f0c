"""The Python interface identifies, calibrates, renders and draws as the commands do."""

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import teletaction as tt
from operator_site.offline_rendering import THERMAL_COLUMNS, render_thermal
from remote_site.texture.recorded.identify_texture import identify_texture
from remote_site.texture.surface_table import SurfaceTable
from remote_site.thermal.recorded.identify_thermal import identify_thermal
from sim_sensors.traces.simulate import simulate_stroke_set, simulate_thermal_set
from tests.commands import command
from tests.places import TABLES
from tests.presses import spring_presses, write_presses

pytestmark = pytest.mark.long


def test_a_touch_gets_the_answers_of_the_command(tmp_path: Path) -> None:
    simulate_thermal_set("pvc", 1, seconds=3.0, seed=4, out=tmp_path)
    (path,) = tmp_path.glob("pvc*.csv")
    lines = list(identify_thermal(tt.MaterialTable.load(TABLES / "materials.json"), [path], (0.5, 2.0)))
    answers = tt.identify_thermal(tt.read_thermal(path), at_s=(0.5, 2.0))
    assert [{"trace": str(path), **answer} for answer in answers] == lines
    assert answers[1]["best"] == "pvc"


def test_two_fingers_are_judged_together() -> None:
    traces = [tt.simulate_thermal("pine", 7, object_c=23.0, preheat_k=preheat_k) for preheat_k in (10.0, 0.0)]
    alone, together = tt.identify_thermal(traces[0])[-1], tt.identify_thermal(traces)[-1]
    assert together["best"] == "pine"
    assert together["object_c_sd"] is not None
    assert alone["object_c_sd"] is not None
    assert together["object_c_sd"] <= alone["object_c_sd"]


def test_nothing_to_identify_is_an_error() -> None:
    with pytest.raises(ValueError, match="nothing to identify"):
        tt.identify_thermal([])
    with pytest.raises(ValueError, match="at_s: times must be positive"):
        tt.identify_thermal(tt.simulate_thermal("pvc"), at_s=[0.0])


@pytest.mark.parametrize(
    ("numbers", "words"),
    [
        ({"object_c": math.nan}, "object, C must be"),
        ({"object_c": 1e9}, "object, C must be"),
        ({"preheat_k": math.nan}, "pre-heating, K must be"),
        ({"preheat_k": -1e6}, "pre-heating, K must be"),
    ],
)
def test_a_touch_with_an_impossible_number_is_not_simulated(numbers: dict[str, float], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        tt.simulate_thermal("pvc", **numbers)  # type: ignore[arg-type]


def test_a_stroke_gets_the_answers_of_the_command(tmp_path: Path) -> None:
    simulate_stroke_set("widely_grooved_pvc", 1, speed_mm_s=50.0, force_n=1.2, seed=5, out=tmp_path)
    (path,) = tmp_path.glob("widely*.csv")
    lines = list(identify_texture([path], SurfaceTable.load(TABLES / "surfaces.json")))
    assert [{"stroke": str(path), **answer} for answer in tt.identify_texture(tt.read_stroke(path))] == lines
    assert any(line["impulses_s"] for line in lines)


def test_presses_get_the_answers_of_the_command(tmp_path: Path) -> None:
    path = write_presses(tmp_path, spring_presses(4, exponent=1.4))
    lines = [json.loads(line) for line in command("identify", "stiffness", path).out.splitlines()]
    assert [{"file": str(path), **answer} for answer in tt.identify_stiffness(tt.read_presses(path))] == lines
    assert [line["press"] for line in lines] == [0, 1, 2, 3]
    (alone,) = tt.identify_stiffness(tt.read_presses(path)[0])
    assert alone["stiffness_n_m"] == pytest.approx(lines[0]["stiffness_n_m"], rel=0.1)


def test_a_touch_without_a_trace_is_refused_by_its_number() -> None:
    with pytest.raises(ValueError, match=r"touch 1: expected \(label, trace\)"):
        tt.calibrate_thermal([("pvc", tt.simulate_thermal("pvc", 0)), ("pvc",)])  # type: ignore[list-item]


def test_a_table_from_arrays_names_new_touches() -> None:
    materials = ("aluminium", "pvc", "pu_foam")
    touches = [(name, tt.simulate_thermal(name, seed)) for name in materials for seed in range(4)]
    fit = tt.calibrate_thermal([*touches, ("air", tt.simulate_thermal("air"))])
    assert fit.table.names() == list(materials)
    assert fit.residual_k.shape == (12, len(fit.times_s))
    best = [tt.identify_thermal(tt.simulate_thermal(name, 50), fit.table)[-1]["best"] for name in materials]
    assert best == list(materials)


def test_calibration_refuses_what_it_cannot_use() -> None:
    with pytest.raises(ValueError, match="two materials or more"):
        tt.calibrate_thermal([("pvc", tt.simulate_thermal("pvc", seed)) for seed in range(2)])
    with pytest.raises(ValueError, match="air, seed 0: column force_n: no contact"):
        tt.calibrate_thermal([("pvc", tt.simulate_thermal("air"))])
    trace, table = tt.simulate_thermal("pvc"), tt.MaterialTable.load(TABLES / "materials.json")
    for label in ("", 1):
        with pytest.raises(ValueError, match=r"touch 0: expected \(label, trace\)"):
            tt.calibrate_thermal([(label, trace)])  # type: ignore[list-item]
    with pytest.raises(ValueError, match=r"touch 0: expected \(label, trace\)"):
        tt.calibrate_thermal([("pvc", "pvc.csv")])  # type: ignore[list-item]
    with pytest.raises(ValueError, match=r"touch 0: expected \(label, trace, object_c\)"):
        tt.calibrate_temperature(table, [("pvc", trace)])  # type: ignore[list-item]
    for object_c in (math.nan, 296.0):
        with pytest.raises(ValueError, match=f"touch 0: object_c must be -50..60 C, not {object_c:g}"):
            tt.calibrate_thermal([("pvc", trace, object_c)])
        with pytest.raises(ValueError, match=f"touch 0: object_c must be -50..60 C, not {object_c:g}"):
            tt.calibrate_temperature(table, [("pvc", trace, object_c)])


@pytest.mark.parametrize(
    ("speed", "words"),
    [
        ({"speed_m_s": 0.0}, "speed_m_s must be above 0"),
        ({"speed_m_s": math.nan}, "speed_m_s must be above 0"),
        ({"speed_m_s": 50.0}, "divide by 1000"),
        ({"speed_sd_m_s": -1.0}, "speed_sd_m_s must be 0 or more"),
        ({"speed_sd_m_s": math.nan}, "speed_sd_m_s must be 0 or more"),
    ],
)
def test_a_speed_that_is_none_is_refused(speed: dict[str, float], words: str) -> None:
    stroke = tt.simulate_stroke("foam")
    with pytest.raises(ValueError, match=words):
        tt.identify_texture(tt.StrokeTrace(stroke.time_s, stroke.signals), **speed)  # type: ignore[arg-type]


@pytest.mark.parametrize("table", ["surfaces.json", tt.MaterialTable.load(TABLES / "materials.json")])
def test_a_stroke_with_a_table_of_no_surfaces_is_refused(table: Any) -> None:
    stroke = tt.StrokeTrace(np.arange(400) / 2000.0, np.zeros(400))
    with pytest.raises(TypeError, match="table must be one of surfaces, from load_surfaces, not"):
        tt.identify_texture(stroke, table)


def test_the_skin_is_that_of_the_command() -> None:
    case = tt.render_thermal("aluminium", 15.0, seconds=2.0, plate=True)
    rows = np.array(list(render_thermal("aluminium", 15.0, 23.0, 2.0)))
    for number, name in enumerate(THERMAL_COLUMNS):
        np.testing.assert_array_equal(case[name], rows[:, number])
    assert case["plate_c"].min() >= 20.0


def test_grooves_move_the_motor() -> None:
    drive = tt.render_vibration(tt.simulate_stroke("widely_grooved_pvc", 2))
    assert set(drive) == {"time_s", "mode", "motor_rpm"}
    assert drive["motor_rpm"].max() > 2740.0


def test_the_map_of_a_session_is_drawn(session: Path) -> None:
    recording = tt.Recording(session)
    figure = tt.draw_map(recording, "stiffness")
    assert figure is not None
    assert figure.axes[0].get_images()
    with pytest.raises(ValueError, match="there are temperature, roughness"):
        tt.draw_map(recording, "colour")


def test_files_of_a_simulated_session_go_with_it() -> None:
    session = tt.simulate(seconds=0.5, fingers=1)
    folder = session.path.parent
    assert folder.is_dir()
    del session
    assert not folder.exists()
