"""The command that calibrates textures takes its options for every kind of stroke."""

from pathlib import Path

import numpy as np
import pytest

from remote_site.texture.calibration.texture_calibration import calibrate_texture
from remote_site.texture.surface_table import SurfaceTable
from sim_sensors.traces.simulate import simulate_stroke_set, write_stroke_csv
from sim_sensors.traces.simulated_stroke import simulate_stroke
from tests.commands import command, one_line


def test_signal_and_speed_also_count_for_fast_strokes(tmp_path: Path) -> None:
    plain, renamed = tmp_path / "plain", tmp_path / "renamed"
    for folder in (plain, renamed):
        folder.mkdir()
        simulate_stroke_set("widely_grooved_pvc", 2, speed_mm_s=60.0, force_n=1.2, seed=3, out=folder)
    for path in renamed.glob("widely*.csv"):
        header, *rows = path.read_text("utf-8").splitlines()
        assert header == "time_s,pressure_v,force_n,speed_mm_s"
        cells = [row.rsplit(",", 1)[0] for row in rows]
        path.write_text("\n".join(["time_s,piezo_v,force_n", *cells]) + "\n", "utf-8")
    assert command("calibrate", "texture", "--strokes", plain, "--out", plain / "table.json").code == 0
    options = ("--signal", "piezo_v", "--speed", 60)
    outcome = command("calibrate", "texture", "--strokes", renamed, "--out", renamed / "table.json", *options)
    assert outcome.code == 0, outcome.err
    whole, other = (SurfaceTable.load(folder / "table.json") for folder in (plain, renamed))
    assert other.surfaces[0].period_mm == pytest.approx(whole.surfaces[0].period_mm, rel=0.02)
    assert other.surfaces[0].ln_roughness == pytest.approx(whole.surfaces[0].ln_roughness, abs=0.1)


@pytest.mark.parametrize(("speed", "why"), [(-1.0, "must be positive, mm/s, not -1.0"), (0.02, "it looks like m/s")])
def test_a_speed_that_is_none_is_refused(tmp_path: Path, speed: float, why: str) -> None:
    time_s = np.arange(0.0, 8.0, 0.02)
    rows = [f"{t:.3f},{np.sin(9.0 * t) + 0.1 * np.sin(31.0 * t):.4f}" for t in time_s]
    (tmp_path / "slow.csv").write_text("\n".join(["time_s,pressure_v", *rows]) + "\n", "utf-8")
    (tmp_path / "labels.csv").write_text("file,surface\nslow.csv,cloth\n", "utf-8")
    line = one_line(
        command("calibrate", "texture", "--strokes", tmp_path, "--out", tmp_path / "table.json", "--speed", speed), 2
    )
    assert "--speed: " in line
    assert why in line


def test_a_stroke_that_never_moves_is_named_in_one_line(tmp_path: Path) -> None:
    rows = [f"{k / 2000.0},{0.01 * (k % 7)},1.0,0.0" for k in range(2000)]
    (tmp_path / "still.csv").write_text("\n".join(["time_s,pressure_v,force_n,speed_mm_s", *rows]) + "\n", "utf-8")
    (tmp_path / "labels.csv").write_text("file,surface\nstill.csv,cloth\n", "utf-8")
    line = one_line(command("calibrate", "texture", "--strokes", tmp_path, "--out", tmp_path / "table.json"), 2)
    assert line.endswith("still.csv: column speed_mm_s: the finger never moves; leave this stroke out")


def without_speed(path: Path) -> None:
    header, *rows = path.read_text("utf-8").splitlines()
    assert header.endswith(",speed_mm_s")
    path.write_text("\n".join(line.rsplit(",", 1)[0] for line in (header, *rows)) + "\n", "utf-8")


def test_a_speed_in_the_labels_counts_for_fast_strokes(tmp_path: Path) -> None:
    for speed_mm_s in (40.0, 80.0):
        simulate_stroke_set("widely_grooved_pvc", 1, speed_mm_s=speed_mm_s, force_n=1.2, seed=3, out=tmp_path)
    for path in tmp_path.glob("widely*.csv"):
        without_speed(path)
    lines = (tmp_path / "labels.csv").read_text("utf-8").splitlines()
    speeds = [f"{line},{'speed_mm_s' if not n else '40' if '_40mm' in line else '80'}" for n, line in enumerate(lines)]
    (tmp_path / "labels.csv").write_text("\n".join(speeds) + "\n", "utf-8")
    fit = calibrate_texture(tmp_path, tmp_path / "table.json")
    assert fit.table.surfaces[0].period_mm == pytest.approx(8.0, rel=0.05)
    assert not any("speed_mm_s in" in warning for warning in fit.warnings)


def test_strokes_without_a_speed_teach_no_spacing_and_are_named(tmp_path: Path) -> None:
    simulate_stroke_set("widely_grooved_pvc", 2, speed_mm_s=80.0, force_n=1.2, seed=3, out=tmp_path)
    for path in tmp_path.glob("widely*.csv"):
        without_speed(path)
    fit = calibrate_texture(tmp_path, tmp_path / "table.json")
    assert fit.table.surfaces[0].period_mm is None
    assert any("_000.csv: no speed_mm_s in 2 of 2 strokes: 50 mm/s are assumed" in warning for warning in fit.warnings)


def test_a_stroke_of_two_surfaces_and_one_unlike_the_others_are_named(tmp_path: Path) -> None:
    simulate_stroke_set("plain_pvc", 3, speed_mm_s=60.0, force_n=1.2, seed=3, out=tmp_path)
    simulate_stroke_set("sandpaper", 1, speed_mm_s=60.0, force_n=1.2, seed=4, out=tmp_path)
    labels = tmp_path / "labels.csv"
    labels.write_text(labels.read_text("utf-8").replace(",sandpaper", ",plain_pvc") + "two.csv,plain_pvc\n", "utf-8")
    two = simulate_stroke("plain_pvc", 8, 60.0, 1.2, length_m=0.14, then="sandpaper")
    write_stroke_csv(tmp_path / "two.csv", two)
    warnings = calibrate_texture(tmp_path, tmp_path / "table.json").warnings
    (crosses,) = (warning for warning in warnings if "the surface changes at" in warning)
    assert crosses.startswith(f"{tmp_path / 'two.csv'}: ")
    (unlike,) = (warning for warning in warnings if "times as rough as most strokes of plain_pvc" in warning)
    assert "sandpaper_60mm_s_4_000.csv: " in unlike
