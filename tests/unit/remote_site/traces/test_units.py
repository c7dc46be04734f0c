"""Traces and labels in a wrong unit are refused with the unit that they look like; right ones are read unchanged."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from remote_site.traces.trace_files import read_labels, read_stroke, read_thermal
from remote_site.traces.units import wrong_forces, wrong_speeds, wrong_temperature, wrong_times
from tests.places import DATA

CELSIUS = st.floats(15.6, 50.0)
COUNT = 40


def csv(path: Path, **columns: np.ndarray) -> Path:
    np.savetxt(path, np.column_stack([*columns.values()]), "%.9g", ",", header=",".join(columns), comments="")
    return path


def touch(**changed: np.ndarray) -> dict[str, np.ndarray]:
    right = {
        "time_s": np.arange(COUNT) * 0.01,
        "sensor_c": np.full(COUNT, 33.0),
        "force_n": np.full(COUNT, 3.0),
        "ambient_c": np.full(COUNT, 23.0),
    }
    return right | changed


@given(st.lists(CELSIUS, min_size=1))
def test_each_unit_of_a_temperature_is_recognised(values: list[float]) -> None:
    celsius = np.array(values)
    assert wrong_temperature(celsius) == ""
    assert "kelvin; subtract 273.15" in wrong_temperature(celsius + 273.15)
    assert "Fahrenheit; subtract 32" in wrong_temperature(celsius * 1.8 + 32.0)


@pytest.mark.parametrize(
    ("column", "value", "why"),
    [
        ("sensor_c", -999.0, "-999, value 8, is no temperature in C"),
        ("ambient_c", -127.0, "-127, value 8, is no temperature in C"),
        ("ambient_c", 0.0, "0 C is no room: the thermometer is shorted or open"),
        ("ambient_c", 55.0, "55 C is no room"),
    ],
)
def test_a_single_value_that_is_no_reading_is_refused(tmp_path: Path, column: str, value: float, why: str) -> None:
    """Its mean with the others would shift the object's temperature by kelvins."""
    columns = touch()
    columns[column][7] = value
    with pytest.raises(ValueError, match=f"column {column}: {why}"):
        read_thermal(csv(tmp_path / "touch.csv", **columns))


def test_one_label_in_kelvin_among_others_is_refused(tmp_path: Path) -> None:
    for name in ("a", "b", "c"):
        csv(tmp_path / f"{name}.csv", **touch())
    (tmp_path / "labels.csv").write_text("file,material,object_c\na.csv,pvc,22\nb.csv,pvc,295.15\nc.csv,pvc,23\n")
    with pytest.raises(ValueError, match=r"line 3: column object_c: .* 295\.15 is no temperature .* kelvin"):
        read_labels(tmp_path, "material", "object_c")


@given(st.floats(1e-4, 0.5), st.integers(2, 50))
def test_each_unit_of_a_time_is_recognised(step_s: float, count: int) -> None:
    assert wrong_times(np.linspace(0.0, step_s * 0.99 * (count - 1), count)) == ""


@pytest.mark.parametrize("rate_hz", [10, 100, 1000])
def test_milliseconds_and_microseconds_are_recognised(rate_hz: int) -> None:
    time_s = np.arange(50) / rate_hz
    assert "milliseconds" in wrong_times(time_s * 1e3)
    assert "microseconds" in wrong_times(time_s * 1e6)


@given(st.lists(st.floats(2.1, 10.0), min_size=1))
def test_grams_are_recognised(force_n: list[float]) -> None:
    values = np.array(force_n)
    assert wrong_forces(values) == ""
    assert "grams; multiply by 0.00981" in wrong_forces(values / 0.00981)


@given(st.lists(st.floats(1.0, 400.0), min_size=1))
def test_metres_a_second_are_recognised(speed_mm_s: list[float]) -> None:
    values = np.array(speed_mm_s)
    assert wrong_speeds(values) == ""
    assert "m/s; multiply by 1000" in wrong_speeds(values / 1000.0)


def test_a_finger_that_never_moves_has_the_right_speed() -> None:
    assert wrong_speeds(np.zeros(5)) == ""


def test_the_file_of_a_touch_in_a_wrong_unit_is_named(tmp_path: Path) -> None:
    read_thermal(csv(tmp_path / "right.csv", **touch()))
    with pytest.raises(ValueError, match=r"wrong\.csv: column sensor_c: .* kelvin"):
        read_thermal(csv(tmp_path / "wrong.csv", **touch(sensor_c=np.full(COUNT, 306.15))))


def test_a_stroke_in_a_wrong_unit_is_refused(tmp_path: Path) -> None:
    stroke = {"time_s": np.arange(COUNT) * 1e-3, "pressure_v": np.zeros(COUNT), "speed_mm_s": np.full(COUNT, 50.0)}
    read_stroke(csv(tmp_path / "right.csv", **stroke))
    with pytest.raises(ValueError, match=r"column speed_mm_s: .* m/s; multiply by 1000"):
        read_stroke(csv(tmp_path / "wrong.csv", **stroke | {"speed_mm_s": np.full(COUNT, 0.05)}))


@pytest.mark.parametrize(
    ("column", "factor", "words"),
    [
        # At 2000 samples/s a step of 1 ms is 0.5, which could be one of a slow recording in s.
        ("time_s", 1e3, "column time_s: a trace of 3999.5 s is too long: it looks like milliseconds; divide by 1000"),
        ("pressure_v", 1e3, "column pressure_v: 1500 V is no reading of a sensor: it looks like mV; divide by 1000"),
        ("speed_mm_s", 1e3, "column speed_mm_s: 50000 mm/s is no stroke: it looks like um/s; divide by 1000"),
    ],
)
def test_a_stroke_of_the_texture_sensor_in_a_wrong_unit_is_refused(
    tmp_path: Path, column: str, factor: float, words: str
) -> None:
    count = 8000
    stroke = {
        "time_s": np.arange(count) / 2000.0,
        "pressure_v": np.full(count, 1.5),
        "force_n": np.full(count, 1.2),
        "speed_mm_s": np.full(count, 50.0),
    }
    assert read_stroke(csv(tmp_path / "right.csv", **stroke)).rate_hz == 2000.0
    with pytest.raises(ValueError, match=words):
        read_stroke(csv(tmp_path / "wrong.csv", **stroke | {column: factor * stroke[column]}))
    # A column of any other name is in the sensor's own unit.
    read_stroke(csv(tmp_path / "other.csv", **stroke | {"counts": np.full(count, 2048.0)}), "counts")


@pytest.mark.parametrize(
    ("rate_hz", "missing_s", "whole"), [(2000.0, 0.09, True), (2000.0, 0.75, False), (35.0, 0.2, True)]
)
def test_a_stroke_with_missing_samples_is_refused(
    tmp_path: Path, rate_hz: float, missing_s: float, whole: bool
) -> None:
    """The line that joins both ends would be named as another surface."""
    time_s = np.arange(4000) / rate_hz
    time_s[2000:] += missing_s
    path = csv(tmp_path / "stroke.csv", time_s=time_s, pressure_v=np.zeros(4000))
    if whole:
        assert len(read_stroke(path).time_s) == 4000
        return
    with pytest.raises(
        ValueError, match=r"column time_s: no sample for 0.75\d* s after 0.9995 s; cut the recording there"
    ):
        read_stroke(path)


def test_labels_in_a_wrong_unit_are_refused(tmp_path: Path) -> None:
    for name in ("a.csv", "b.csv"):
        csv(tmp_path / name, **touch())
    labels = tmp_path / "labels.csv"
    labels.write_text("file,material,object_c\na.csv,pine,23\nb.csv,pine,\n", "utf-8")
    assert read_labels(tmp_path, "material", "object_c")[0][2] == 23.0
    labels.write_text("file,material,object_c\na.csv,pine,296.15\n", "utf-8")
    with pytest.raises(ValueError, match=r"labels\.csv: line 2: column object_c: .* kelvin"):
        read_labels(tmp_path, "material", "object_c")


@pytest.mark.long
@pytest.mark.skipif(not DATA.is_dir(), reason=f"no recordings in {DATA}; TELETACTION_DATA names their folder")
def test_real_recordings_are_in_the_right_units() -> None:
    files = sorted((DATA / "thermal_contact").rglob("*.csv"))
    touches = [path for path in files if "sensor_c" in path.read_text("utf-8").partition("\n")[0]]
    assert len(touches) > 100
    for path in touches:
        read_thermal(path)


def test_a_speed_or_a_roughness_beyond_any_stroke_is_refused(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("", "utf-8")
    for speed, why in (("0.05", "it looks like m/s"), ("-50", "must be positive, mm/s, not -50")):
        (tmp_path / "labels.csv").write_text(f"file,surface,speed_mm_s\na.csv,steel,50\na.csv,cloth,{speed}\n", "utf-8")
        with pytest.raises(ValueError, match=rf"labels.csv: line 3: column speed_mm_s: .*{why}"):
            read_labels(tmp_path, "surface", "speed_mm_s")
    (tmp_path / "labels.csv").write_text("file,surface,roughness_um\na.csv,steel,0.4\na.csv,lost,0\n", "utf-8")
    with pytest.raises(
        ValueError, match=r"labels.csv: line 3: column roughness_um: 0 is no roughness in um \(0.005 to 2000\)"
    ):
        read_labels(tmp_path, "surface", "roughness_um")
