"""Thermal identification against made-up responses of known law (not the simulated world's)."""

import json
import math
from pathlib import Path

import numpy as np
import pytest

from common.messages import ThermalStatus
from remote_site.identify_thermal import identify_thermal
from remote_site.material_table import MaterialTable
from remote_site.thermal_calibration import calibrate_thermal
from remote_site.thermal_identification import ThermalIdentification

TAU_S = {"metal": 1.0, "stone": 2.2, "plastic": 8.0}
AMBIENT_C = 23.0


def course(tau, object_c, start_c, seconds=8.1, seed=0):
    rng = np.random.default_rng(seed)
    t = np.arange(-0.5, seconds, 0.01)
    end = 0.9 if tau < 5.0 else 0.6
    drop = (start_c - object_c) * end * (1.0 - np.exp(-np.maximum(t, 0.0) / tau))
    return t, start_c - drop + 0.01 * rng.normal(size=len(t))


def write(path, t, sensor, force=1.2):
    rows = (f"{a:.2f},{b:.4f},{force if a > -0.005 else 0.0},{AMBIENT_C}" for a, b in zip(t, sensor, strict=True))
    path.write_text("time_s,sensor_c,force_n,ambient_c\n" + "\n".join(rows) + "\n")


@pytest.fixture(scope="module")
def calibrated(tmp_path_factory):
    folder = tmp_path_factory.mktemp("touches")
    rng = np.random.default_rng(1)
    labels = ["file,material,object_c"]
    for name, tau in TAU_S.items():
        for k in range(20):
            object_c = AMBIENT_C + rng.uniform(-3, 3)
            write(folder / f"{name}{k}.csv", *course(tau * math.exp(0.08 * rng.normal()), object_c, 33.0, seed=k))
            labels.append(f"{name}{k}.csv,{name},{object_c}")
    (folder / "labels.csv").write_text("\n".join(labels) + "\n")
    return calibrate_thermal(folder, folder / "table.json", made_on="2026-01-01"), folder


def identify(table, name, object_c, start_c=33.0, until_s=8.1, force=lambda t: 1.2):
    identification = ThermalIdentification(table)
    identification.start(0.0, start_c, AMBIENT_C)
    for t, sensor in zip(*course(TAU_S[name], object_c, start_c, seed=99), strict=True):
        if 0.0 < t <= until_s:
            identification.step(t, sensor, force(t))
    return identification.answer


@pytest.mark.parametrize("name", TAU_S)
@pytest.mark.parametrize("object_c", [21.0, 25.0])
def test_material_and_temperature_are_found(calibrated, name, object_c):
    answer = identify(calibrated[0], name, object_c)
    assert (answer.status, answer.material, answer.best) == (ThermalStatus.IDENTIFIED, name, name)
    assert answer.exponential_material == name
    assert answer.object_c == pytest.approx(object_c, abs=1.0)
    assert answer.probability >= 0.95


@pytest.mark.parametrize("start_c", [40.0, 26.0])
def test_another_preheat_needs_no_other_table(calibrated, start_c):
    assert identify(calibrated[0], "metal", 22.0, start_c).material == "metal"


def test_nothing_is_named_before_one_second(calibrated):
    assert identify(calibrated[0], "metal", 22.0, until_s=0.95).status is ThermalStatus.DECIDING


def test_no_temperature_difference_is_unidentifiable(calibrated):
    answer = identify(calibrated[0], "stone", 33.0)
    assert answer.status is ThermalStatus.UNIDENTIFIABLE
    assert answer.reason == "no temperature difference"
    assert answer.material is None


def test_a_foreign_response_is_unknown(calibrated):
    identification = ThermalIdentification(calibrated[0])
    identification.start(0.0, 33.0, AMBIENT_C)
    for k in range(1, 810):
        t = 0.01 * k
        identification.step(t, 33.0 - (4.0 if t > 3.5 else 0.0) - 0.3 * t, 1.2)
    assert identification.answer.status is ThermalStatus.UNKNOWN


def test_a_lost_contact_ends_the_touch(calibrated):
    early = identify(calibrated[0], "metal", 22.0, force=lambda t: 1.2 if t < 0.7 else 0.0)
    assert (early.status, early.reason) == (ThermalStatus.UNIDENTIFIABLE, "contact lost")
    late = identify(calibrated[0], "metal", 22.0, force=lambda t: 1.2 if t < 6.0 else 0.0)
    assert (late.status, late.material, late.reason) == (ThermalStatus.IDENTIFIED, "metal", "contact lost")


def test_missing_readings_are_a_sensor_fault(calibrated):
    identification = ThermalIdentification(calibrated[0])
    identification.start(0.0, 33.0, AMBIENT_C)
    identification.step(0.5, 32.0, 1.2)
    assert identification.answer.status is ThermalStatus.UNIDENTIFIABLE
    assert "sensor fault" in identification.answer.reason


def test_lines_keep_the_contract_and_look_at_no_later_sample(calibrated, tmp_path):
    table, _ = calibrated
    t, sensor = course(TAU_S["stone"], 22.0, 33.0, seed=5)
    write(tmp_path / "whole.csv", t, sensor)
    cut = t <= 2.0 + 1e-6
    write(tmp_path / "cut.csv", t[cut], sensor[cut])
    whole = list(identify_thermal(table, [tmp_path / "whole.csv"], (1.0, 2.0)))
    short = list(identify_thermal(table, [tmp_path / "cut.csv"], (1.0, 2.0)))
    assert [line["t_s"] for line in whole] == [1.0, 2.0, 8.09]
    assert [line["final"] for line in whole] == [False, False, True]
    for a, b in zip(whole[:2], short[:2], strict=True):
        assert {**a, "trace": ""} == {**b, "trace": ""}
    assert json.loads(json.dumps(whole[-1]))["material"] == "stone"
    assert set(whole[0]) == {
        "trace",
        "t_s",
        "final",
        "status",
        "material",
        "best",
        "probability",
        "candidates",
        "object_c",
        "object_c_sd",
        "exponential",
        "reason",
    }


def test_fingers_on_one_object_are_judged_together(calibrated, tmp_path):
    for k in range(3):
        write(tmp_path / f"f{k}.csv", *course(TAU_S["plastic"], 24.0, 33.0, seed=k))
    (tmp_path / "touches.csv").write_text("touch,trace\n" + "".join(f"one,f{k}.csv\n" for k in range(3)))
    lines = list(identify_thermal(calibrated[0], (), (2.0,), tmp_path / "touches.csv"))
    assert [line["touch"] for line in lines] == ["one", "one"]
    assert lines[-1]["material"] == "plastic"


def test_a_trace_without_contact_says_so(calibrated, tmp_path):
    t, sensor = course(1.0, 22.0, 33.0)
    write(tmp_path / "free.csv", t, sensor, force=0.1)
    assert {line["status"] for line in identify_thermal(calibrated[0], [tmp_path / "free.csv"])} == {"no_contact"}


def test_a_table_survives_its_file_and_a_foreign_one_is_refused(calibrated, tmp_path):
    table, folder = calibrated
    assert MaterialTable.load(folder / "table.json").materials == table.materials
    with pytest.raises(ValueError, match="cannot be read"):
        MaterialTable.load(tmp_path / "none.json")
    (tmp_path / "other.json").write_text('{"kind": "texture_surfaces"}')
    with pytest.raises(ValueError, match="not a thermal_materials table"):
        MaterialTable.load(tmp_path / "other.json")
    text = (folder / "table.json").read_text().replace('"ambient_c": 2', '"ambient_c": 1', 1)
    (tmp_path / "edited.json").write_text(text)
    with pytest.raises(ValueError, match="content_hash"):
        MaterialTable.load(tmp_path / "edited.json")


def test_the_shipped_tables_load():
    tables = Path(__file__).parents[2] / "remote_site" / "tables"
    assert MaterialTable.load(tables / "materials.json").names() == ["aluminium", "ceramic_tile", "pine", "pvc"]
    assert "skin_dermis" in MaterialTable.load(tables / "phantom.json").names()
