"""Recorded strokes: period, surface and the line's contract."""

import numpy as np
import pytest

from remote_site.identify_texture import identify_texture
from remote_site.surface_class import SurfaceTable, stroke_constants
from remote_site.texture_calibration import calibrate_texture


def write_stroke(path, sd, period_mm=None, seed=0, speed=50.0):
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, 2.5, 0.0005)
    signal = sd * rng.normal(size=len(t))
    force = np.where(t < 0.1, 0.0, 1.2)
    v = np.where((t > 0.6) & (t < 2.2), speed, 0.0)
    if period_mm:
        for edge in np.arange(0.7, 2.15, period_mm / speed):
            signal[round(2000 * edge) : round(2000 * edge) + 10] -= 0.9
    rows = (f"{a:.4f},{b:.5f},{c},{d}" for a, b, c, d in zip(t, signal, force, v, strict=True))
    path.write_text("time_s,pressure_v,force_n,speed_mm_s\n" + "\n".join(rows) + "\n")


@pytest.fixture(scope="module")
def calibrated(tmp_path_factory):
    folder = tmp_path_factory.mktemp("strokes")
    labels = ["file,surface"]
    for name, sd, period in (("smooth", 0.012, None), ("rough", 0.3, None), ("ribbed", 0.012, 4.0)):
        for k in range(2):
            write_stroke(folder / f"{name}{k}.csv", sd, period, seed=k)
            labels.append(f"{name}{k}.csv,{name}")
    (folder / "labels.csv").write_text("\n".join(labels) + "\n")
    return calibrate_texture(folder, folder / "surfaces.json", constants={"smooth": (2000.0, 60.0)}), folder


@pytest.mark.parametrize(
    ("name", "sd", "period"), [("smooth", 0.012, None), ("rough", 0.3, None), ("ribbed", 0.012, 4.0)]
)
def test_surfaces_are_recognised(calibrated, tmp_path, name, sd, period):
    table, folder = calibrated
    assert SurfaceTable.load(folder / "surfaces.json").surfaces == table.surfaces
    write_stroke(tmp_path / "new.csv", sd, period, seed=7)
    lines = list(identify_texture([tmp_path / "new.csv"], table))
    assert [line["mode"] for line in lines] == ["tapping", "quiescent", "stroking", "quiescent"]
    stroke = lines[2]
    assert stroke["surface"] == name
    assert lines[0]["surface"] is None
    assert (stroke["period_mm"] is None) == (period is None)
    if period is not None:
        assert stroke["period_mm"] == pytest.approx(period, abs=0.15)


def test_constants_lie_between_the_calibrated_ones(calibrated):
    table, _ = calibrated
    speeds = [stroke_constants(table, x).k_stroke_v for x in np.linspace(-5.0, -1.0, 50)]
    ends = [surface.k_stroke_v for surface in table.surfaces]
    assert min(ends) * 0.999 <= min(speeds)
    assert max(speeds) <= max(ends) * 1.001
    assert max(np.abs(np.diff(np.log(speeds)))) < 0.35


def test_a_slow_recording_gives_its_period(tmp_path):
    t = np.arange(0.0, 12.0, 0.028)
    x = 10.0 * t
    signal = 100 + 20 * np.sin(2 * np.pi * x / 20.0) + 10 * np.sin(2 * np.pi * x / 4.0)
    rows = (f"{a:.3f},{b:.2f}" for a, b in zip(t, signal, strict=True))
    (tmp_path / "slow.csv").write_text("time_s,taxel1\n" + "\n".join(rows) + "\n")
    (line,) = identify_texture([tmp_path / "slow.csv"], None, "best", 10.0)
    assert line["period_mm"] == pytest.approx(4.0, abs=0.05)
    assert line["surface"] is None
    with pytest.raises(ValueError, match="speed"):
        list(identify_texture([tmp_path / "slow.csv"], None, "best", -1.0))
