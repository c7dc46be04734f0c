"""Rendering without devices: rows, parameters, and errors."""

import json
import math
from itertools import pairwise

import pytest

from common.limits import COMFORT
from common.wire.messages import Event, EventKind, ExplorationMode
from operator_site.offline_rendering import (
    THERMAL_COLUMNS,
    StrokeSample,
    render_thermal,
    render_vibration,
    write_parameters,
)
from operator_site.vibration.vibration import Surface


def test_thermal_rows():
    rows = list(render_thermal("ceramic", 25.0, 22.0, 3.0, plate=True))
    assert [row[0] for row in rows] == [i / 100 for i in range(301)]
    assert {len(row) for row in rows} == {len(THERMAL_COLUMNS) + 1}
    free, touching = rows[:100], rows[100:]
    assert max(abs(row[1] - free[0][1]) for row in free) < 1e-9  # steady
    assert touching[0][1] == pytest.approx(free[0][1])
    assert touching[0][5] < -2000.0 < free[0][5]  # flux is positive into the finger
    assert rows[-1][1] < rows[0][1] - 1.0
    plates = [row[-1] for row in rows]
    assert all(-0.025 - 1e-9 <= b - a <= 0.04 + 1e-9 for a, b in pairwise(plates))
    assert all(COMFORT.low_c <= plate <= COMFORT.high_c for plate in plates)


def test_a_warm_object_warms_and_rows_without_a_plate_are_shorter():
    rows = list(render_thermal("iron", 40.0, 25.0, 4.0))
    assert rows[-1][5] > 0.0
    assert rows[-1][1] > rows[0][1] + 1.0
    short = list(render_thermal("pvc", 25.0, 25.0, 0.5, model="1+1+1"))  # it ends before the contact
    assert (len(short), len(short[0])) == (51, len(THERMAL_COLUMNS))


def test_parameters_are_enough_to_compute_the_case_again(tmp_path):
    path = tmp_path / "parameters.json"
    write_parameters(path, "wood", 25.0, 22.0, model="2+1+1+6")
    case = json.loads(path.read_text())
    assert [layer["name"] for layer in case["skin"]] == ["epidermis", "dermis", "subcutis"]
    constants = {"conductivity_w_mk": 0.12, "density_kg_m3": 500.0, "specific_heat_j_kgk": 2000.0}
    assert set(case["skin"][0]) == {"name", "thickness_m", *constants, "perfusion_per_s"}
    assert case["object"] == {"name": "wood", **constants, "thickness_m": None, "start_c": 25.0}
    assert (case["arterial_c"], case["deep_c"], case["air_c"], case["air_w_m2k"]) == (35.0, 34.0, 22.0, 10.0)
    assert (case["contact_s"], case["model"], case["step_s"]) == (1.0, "2+1+1+6", 0.01)
    # Steady state from the file alone: the flux to the air is what the rendered rows say.
    row = next(render_thermal("wood", 25.0, 22.0, 0.1, model="2+1+1+6"))
    assert row[5] == pytest.approx(case["air_w_m2k"] * (case["air_c"] - row[4]))


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"object_name": "unobtainium"}, "unobtainium"),
        ({"model": "4+x"}, "model"),
        ({"seconds": 0.0}, "seconds"),
        ({"seconds": math.nan}, "seconds"),
        ({"object_c": 200.0}, "object_c"),
        ({"air_c": math.nan}, "air_c"),
    ],
)
def test_bad_input_is_named(changes, named):
    case = {"object_name": "pvc", "object_c": 25.0, "air_c": 25.0, "seconds": 2.0} | changes
    with pytest.raises(ValueError, match=named):
        render_thermal(**case)


def test_vibration_rows():
    surface = Surface(4000.0, 30.0, 5000.0, 120.0, 60.0)
    events = (Event(1, EventKind.TAP, 0, 0, 0, 0.2),)
    samples = [StrokeSample(i * 0.005, ExplorationMode.TAPPING, 0.0, 1.0, surface, events) for i in range(60)]
    samples += [StrokeSample(0.3 + i * 0.005, ExplorationMode.STROKING, 0.06, 1.0, surface, events) for i in range(20)]
    rows = list(render_vibration(samples))
    assert [row[:2] for row in rows] == [(s.t_s, s.mode) for s in samples]
    assert rows[0][2] == pytest.approx(4000.0 * 0.2 * 30.0 / math.pi)
    assert rows[59][2] == 0.0  # the tap was over after 0.15 s although every sample lists it
    assert rows[-1][2] == pytest.approx((300.0 + 120.0) * 30.0 / math.pi)


@pytest.mark.parametrize(("t_s", "speed"), [(0.0, 0.0), (-1.0, 0.0), (math.nan, 0.0), (1.0, math.inf)])
def test_vibration_refuses_samples_that_are_no_series(t_s, speed):
    samples = [StrokeSample(0.0, 0, 0.0, 0.0, Surface()), StrokeSample(t_s, 0, speed, 0.0, Surface())]
    with pytest.raises(ValueError, match="sample at"):
        list(render_vibration(samples))
