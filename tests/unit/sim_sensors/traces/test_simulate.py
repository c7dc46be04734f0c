import csv

import numpy as np
import pytest

from sim_sensors.traces.simulate import simulate_stroke_set, simulate_thermal_set, write_stroke_csv
from sim_sensors.traces.simulated_stroke import simulate_stroke
from sim_sensors.traces.simulated_touch import simulate_thermal


def rows(path):
    with path.open(newline="") as stream:
        return list(csv.reader(stream))


def test_a_touch_starts_warm_and_cools_towards_its_object():
    (trace,) = simulate_thermal("aluminium", 0, seconds=5.0)
    before, after = trace.time_s < trace.contact_s, trace.time_s >= trace.contact_s + 4.5
    assert trace.contact_s == pytest.approx(1.0, abs=0.05)
    assert trace.sensor_c[before].mean() == pytest.approx(33.0, abs=0.1)
    assert trace.object_c is not None
    assert trace.sensor_c[after].mean() == pytest.approx(trace.object_c, abs=0.7)
    assert np.abs(trace.ambient_c - 23.0).max() < 0.1
    assert trace.force_n[before].max() < 0.35
    assert 1.0 < trace.force_n[after].mean() < 1.4
    assert np.diff(trace.time_s) == pytest.approx(np.full(trace.time_s.size - 1, 0.01))


def drop_after(trace, seconds):
    start = round(trace.contact_s * 100)
    return (trace.sensor_c[start] - trace.sensor_c[start + round(seconds * 100)]) / (33.0 - (trace.object_c or 23.0))


@pytest.mark.long
def test_better_conductors_cool_the_sensor_faster():
    drops = [
        np.mean([drop_after(trace, 2.0) for trace in simulate_thermal(name, 1, touches=20, seconds=2.5)])
        for name in ("foam", "pine", "pvc", "ceramic", "aluminium")
    ]
    assert np.all(np.diff(drops) > 0.02)


def test_free_cool_down_is_slow_and_touches_nothing():
    (trace,) = simulate_thermal("air", 0, seconds=8.0)
    assert trace.object_c is None
    assert np.abs(trace.force_n).max() < 0.05
    assert 1.0 < trace.sensor_c[100] - trace.sensor_c[-1] < 4.0


@pytest.mark.long
def test_touches_are_drawn_apart_and_again_alike():
    first, again = (simulate_thermal("pvc", 7, touches=3, seconds=1.0) for _ in range(2))
    for a, b in zip(first, again, strict=True):
        assert np.array_equal(a.sensor_c, b.sensor_c)
        assert np.array_equal(a.force_n, b.force_n)
    assert len({trace.object_c for trace in first}) == 3
    assert simulate_thermal("pine", 7, seconds=1.0)[0].object_c != first[0].object_c


@pytest.mark.long
def test_spread_of_the_contact_is_the_one_that_was_decided():
    traces = simulate_thermal("aluminium", 2, touches=300, seconds=0.5)
    logs = np.log([trace.conductance_w_m2k for trace in traces])
    assert logs.std() == pytest.approx(0.155, abs=0.025)  # 15 % and a little from the force
    offsets = np.array([trace.object_c for trace in traces]) - 23.0
    assert np.abs(offsets).max() <= 3.0
    assert offsets.std() == pytest.approx(3.0 / np.sqrt(3.0), rel=0.1)


def test_preheat_never_goes_beyond_the_limit_of_the_plate():
    (trace,) = simulate_thermal("pvc", 0, seconds=0.5, ambient_c=30.0, preheat_k=17.0)
    assert trace.sensor_c[:80].mean() == pytest.approx(42.0, abs=0.15)


def test_stroke_is_a_trace_at_2_khz_with_true_grooves():
    trace = simulate_stroke("widely_grooved_pvc", 0, 50.0, 1.2)
    assert np.diff(trace.time_s) == pytest.approx(np.full(trace.time_s.size - 1, 5e-4))
    begin, end = trace.stroke_s
    moving = (trace.time_s > begin + 0.1) & (trace.time_s < end)
    assert trace.speed_mm_s[moving].mean() == pytest.approx(50.0, rel=0.01)
    assert 1.0 < trace.force_n[moving].mean() < 1.4
    assert trace.force_n[:500].max() < 0.1
    assert len(trace.groove_s) == 10
    for crossing in trace.groove_s:
        near = np.abs(trace.time_s - crossing) < 0.008
        assert trace.pressure_v[near].min() < -0.4


@pytest.mark.long
def test_thermal_files_share_a_folder_and_its_labels(tmp_path):
    traces = simulate_thermal_set("wood", 2, seconds=0.5, seed=3, out=tmp_path)
    simulate_thermal_set("air", 1, seconds=0.5, seed=3, out=tmp_path)
    simulate_thermal_set("wood", 2, seconds=0.5, seed=3, out=tmp_path)
    labels = rows(tmp_path / "labels.csv")
    assert labels[0] == ["file", "material", "object_c"]
    assert [row[1] for row in labels[1:]] == ["air", "pine", "pine"]
    assert labels[1][2] == ""
    assert float(labels[2][2]) == pytest.approx(traces[0].object_c, abs=1e-4)
    written = rows(tmp_path / labels[2][0])
    assert written[0] == ["time_s", "sensor_c", "force_n", "ambient_c"]
    assert np.array(written[1:], float)[:, 1] == pytest.approx(traces[0].sensor_c, abs=1e-4)


@pytest.mark.long
def test_stroke_files_and_labels(tmp_path):
    traces = simulate_stroke_set("foam", 2, speed_mm_s=100.0, force_n=1.0, seed=1, out=tmp_path)
    labels = rows(tmp_path / "labels.csv")
    assert labels[0] == ["file", "surface"]
    assert [row[1] for row in labels[1:]] == ["foam", "foam"]
    assert not np.array_equal(traces[0].pressure_v, traces[1].pressure_v)
    write_stroke_csv(tmp_path / "one.csv", traces[0])
    assert rows(tmp_path / "one.csv") == rows(tmp_path / labels[1][0])
    assert rows(tmp_path / "one.csv")[0] == ["time_s", "pressure_v", "force_n", "speed_mm_s"]


def test_another_touch_or_stroke_of_the_same_name_is_kept(tmp_path):
    """The force of a stroke and the temperature of an object are not in the name of a file."""
    for make in (
        lambda folder, force_n: simulate_stroke_set("foam", 1, speed_mm_s=90.0, force_n=force_n, seed=1, out=folder),
        lambda folder, force_n: simulate_thermal_set("pvc", 1, seconds=0.5, seed=1, force_n=force_n, out=folder),
    ):
        folder = tmp_path / f"{len(list(tmp_path.iterdir()))}"
        make(folder, 1.0)
        before = {path: path.read_bytes() for path in folder.iterdir()}
        make(folder, 1.0)
        with pytest.raises(ValueError, match="exists with another content; use another --seed or folder"):
            make(folder, 2.0)
        assert {path: path.read_bytes() for path in folder.iterdir()} == before


@pytest.mark.parametrize("content", [b"file,surface\n", b"\xff\n", b"file,material,object_c\n" + 200_000 * b"x"])
def test_foreign_labels_are_not_overwritten(tmp_path, content):
    (tmp_path / "labels.csv").write_bytes(content)
    with pytest.raises(ValueError, match=r"labels\.csv: .*; write into another folder"):
        simulate_thermal_set("pvc", 1, seconds=0.2, seed=0, out=tmp_path)
    assert (tmp_path / "labels.csv").read_bytes() == content


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: simulate_thermal("gold", 0), r"unknown material 'gold'.*air"),
        (lambda: simulate_thermal("pvc", 0, touches=0), "touches must be 1"),
        (lambda: simulate_thermal("pvc", 0, seconds=float("nan")), "seconds"),
        (lambda: simulate_thermal("pvc", 0, force_n=0.1), "force"),
        (lambda: simulate_thermal("pvc", -1), "seed"),
        (lambda: simulate_stroke("velvet", 0), "^unknown surface 'velvet'"),
        (lambda: simulate_stroke("foam", 0, 0.0), "speed"),
        (lambda: simulate_stroke("foam", 0, 50.0, 99.0), "force"),
    ],
)
def test_bad_input_gets_a_clear_error(call, message):
    with pytest.raises(ValueError, match=message):
        call()
