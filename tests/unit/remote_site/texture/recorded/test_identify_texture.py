"""Recorded strokes: period, surface and the line's contract."""

import numpy as np
import pytest

from remote_site.texture.calibration.texture_calibration import calibrate_texture
from remote_site.texture.recorded.identify_texture import identify_stroke, identify_texture
from remote_site.texture.surface_table import StrokeLaw, SurfaceTable
from remote_site.traces.trace_files import StrokeTrace
from sim_sensors.traces.simulate import simulate_stroke_set, write_stroke_csv
from sim_sensors.traces.simulated_stroke import simulate_stroke
from teletaction.report.calibration_report import texture_text
from teletaction.session.demo_files import TABLES

pytestmark = pytest.mark.long

STROKED = {"plain_pvc": None, "sandpaper": None, "widely_grooved_pvc": 8.0}
"""Surfaces and the distance of their grooves, mm."""
WAYS = ((30.0, 1.2), (60.0, 0.7), (120.0, 2.5))


@pytest.fixture(scope="module")
def calibrated(tmp_path_factory):
    folder = tmp_path_factory.mktemp("strokes")
    for number, name in enumerate(STROKED):
        for way, (speed_mm_s, force_n) in enumerate(WAYS):
            simulate_stroke_set(
                name, 1, speed_mm_s=speed_mm_s, force_n=force_n, seed=100 + 10 * number + way, out=folder
            )
    return calibrate_texture(folder, folder / "surfaces.json", constants={"plain_pvc": (2000.0, 60.0)}), folder


@pytest.mark.parametrize(("name", "period_mm"), STROKED.items())
def test_surfaces_are_recognised(calibrated, tmp_path, name, period_mm):
    fit, folder = calibrated
    assert SurfaceTable.load(folder / "surfaces.json").surfaces == fit.table.surfaces
    write_stroke_csv(tmp_path / "new.csv", simulate_stroke(name, 7, 80.0, 1.0))
    lines = list(identify_texture([tmp_path / "new.csv"], fit.table))
    assert [line["mode"] for line in lines] == ["tapping", "quiescent", "stroking", "quiescent"]
    stroke = lines[2]
    assert stroke["surface"] == name
    assert stroke["fault"] is None
    assert lines[0]["surface"] is None
    assert (stroke["period_mm"] is None) == (period_mm is None)
    if period_mm is not None:
        assert stroke["period_mm"] == pytest.approx(period_mm, rel=0.01)
        assert stroke["irregular"] is False


def test_a_stroke_that_comes_to_another_surface_is_two_segments(calibrated, tmp_path):
    fit, _ = calibrated
    trace = simulate_stroke("plain_pvc", 8, 60.0, 1.5, length_m=0.14, then="sandpaper")
    write_stroke_csv(tmp_path / "two.csv", trace)
    parts = [line for line in identify_texture([tmp_path / "two.csv"], fit.table) if line["mode"] == "stroking"]
    assert [(part["surface"], part["changed"]) for part in parts] == [("plain_pvc", False), ("sandpaper", True)]
    assert parts[1]["start_s"] == pytest.approx(trace.border_s, abs=0.3)


def test_grooves_at_any_distance_are_called_irregular(tmp_path):
    write_stroke_csv(tmp_path / "any.csv", simulate_stroke("arbitrarily_grooved_pvc", 9, 60.0, 1.5, length_m=0.14))
    (part,) = (line for line in identify_texture([tmp_path / "any.csv"]) if line["mode"] == "stroking")
    assert part["irregular"] is True
    assert part["period_mm"] is None
    assert len(part["impulses_s"]) > 15
    assert part["surface"] is None


def test_a_calibration_reports_its_findings_and_its_gaps(calibrated, tmp_path):
    fit, _ = calibrated
    assert fit.law.law.viscous_s == pytest.approx(1e-3, rel=0.5)
    assert fit.law.law.force_exponent == pytest.approx(1.0, abs=0.1)
    assert fit.taken_for == {name: {name: len(WAYS)} for name in STROKED}
    assert max(fit.scatter.values()) < 0.15
    assert fit.warnings == []
    assert all(f"{name} " in texture_text(fit) for name in STROKED)
    for seed, name in enumerate(("plain_pvc", "aluminium")):
        simulate_stroke_set(name, 2, speed_mm_s=50.0, force_n=1.2, seed=seed, out=tmp_path)
    poor = calibrate_texture(tmp_path, tmp_path / "surfaces.json")
    assert [warning.partition(" ")[0] for warning in poor.warnings[:2]] == ["force", "speed"]


def test_two_equal_surfaces_cannot_be_distinguished(tmp_path):
    for number, (speed_mm_s, force_n) in enumerate((*WAYS, (80.0, 1.0))):
        simulate_stroke_set("plain_pvc", 1, speed_mm_s=speed_mm_s, force_n=force_n, seed=number, out=tmp_path)
        simulate_stroke_set("widely_grooved_pvc", 1, speed_mm_s=speed_mm_s, force_n=force_n, seed=number, out=tmp_path)
    rows = (tmp_path / "labels.csv").read_text().splitlines()
    plain = [row for row in rows if row.endswith(",plain_pvc")]
    renamed = [row.replace(",plain_pvc", ",smooth") for row in plain[::2]]
    kept = [row for row in rows if row not in plain] + plain[1::2] + renamed
    (tmp_path / "labels.csv").write_text("\n".join(kept) + "\n")
    warnings = calibrate_texture(tmp_path, tmp_path / "surfaces.json").warnings
    assert "this sensor cannot distinguish plain_pvc and smooth" in warnings


def test_constants_lie_between_the_calibrated_ones(calibrated):
    table = calibrated[0].table
    speeds = [StrokeLaw(table).at(x).k_stroke_v for x in np.linspace(-5.0, -1.0, 50)]
    ends = [surface.k_stroke_v for surface in table.surfaces]
    assert min(ends) * 0.999 <= min(speeds)
    assert max(speeds) <= max(ends) * 1.001
    assert max(np.abs(np.diff(np.log(speeds)))) < 0.35


def test_a_slow_recording_names_no_surface_and_needs_a_speed(tmp_path):
    t = np.arange(0.0, 12.0, 0.028)
    rows = (f"{a:.3f},{b:.2f}" for a, b in zip(t, 100.0 + 10.0 * np.sin(5.0 * np.pi * t), strict=True))
    (tmp_path / "slow.csv").write_text("time_s,taxel1\n" + "\n".join(rows) + "\n")
    (line,) = identify_texture([tmp_path / "slow.csv"], None, "best", 10.0)
    assert line["period_mm"] == pytest.approx(4.0, abs=0.05)
    assert line["surface"] is None
    with pytest.raises(ValueError, match="speed"):
        list(identify_texture([tmp_path / "slow.csv"], None, "best", -1.0))
    with pytest.raises(ValueError, match=r"slow\.csv: 36 samples/s; the table is of strokes of 1000 or more"):
        list(identify_texture([tmp_path / "slow.csv"], SurfaceTable.load(TABLES / "surfaces.json"), "best", 10.0))


def test_roughness_in_um_is_answered_where_it_was_calibrated(calibrated, tmp_path):
    _, folder = calibrated
    known_um = {"plain_pvc": "1", "sandpaper": "12.5", "widely_grooved_pvc": ""}
    header, *rows = (folder / "labels.csv").read_text().splitlines()
    scaled = [f"{header},roughness_um", *(f"{row},{known_um[row.rpartition(',')[2]]}" for row in rows)]
    for name in folder.glob("*.csv"):
        (tmp_path / name.name).write_bytes(name.read_bytes())
    (tmp_path / "labels.csv").write_text("\n".join(scaled) + "\n")
    fit = calibrate_texture(tmp_path, tmp_path / "surfaces.json")
    assert "roughness in um" in texture_text(fit)
    write_stroke_csv(tmp_path / "new.csv", simulate_stroke("sandpaper", 7, 80.0, 1.0))
    table = SurfaceTable.load(tmp_path / "surfaces.json")
    stroke = next(line for line in identify_texture([tmp_path / "new.csv"], table) if line["mode"] == "stroking")
    assert stroke["roughness_um"] == pytest.approx(12.5, rel=0.4)
    assert 0.0 < stroke["roughness_sd_um"] < 12.5
    (tmp_path / "labels.csv").write_text("\n".join(scaled).replace("12.5", "12500") + "\n")
    with pytest.raises(ValueError, match=r"labels.csv: line 5: column roughness_um: 12500 is no roughness in um"):
        calibrate_texture(tmp_path, tmp_path / "other.json")


def test_tables_without_a_scale_answer_as_before(calibrated, tmp_path):
    write_stroke_csv(tmp_path / "new.csv", simulate_stroke("sandpaper", 7, 80.0, 1.0))
    for line in identify_texture([tmp_path / "new.csv"], calibrated[0].table):
        assert "roughness_um" not in line


def test_a_calibration_names_the_fault_of_a_stroke(tmp_path):
    simulate_stroke_set("plain_pvc", 2, speed_mm_s=50.0, force_n=1.2, seed=1, out=tmp_path)
    path = next(tmp_path.glob("plain_pvc*.csv"))
    header, *rows = path.read_text().splitlines()
    cut = [",".join([row.split(",")[0], "10.0", *row.split(",")[2:]]) for row in rows]
    path.write_text("\n".join([header, *cut]) + "\n")
    with pytest.raises(ValueError, match=f"{path.name}: saturated"):
        calibrate_texture(tmp_path, tmp_path / "surfaces.json")


def test_a_sensor_of_a_wider_range_is_not_clipped(calibrated):
    """Recordings may be in another unit, such as m/s^2; only samples at their own largest value are at a rail."""
    made = simulate_stroke("sandpaper", 7, 80.0, 1.0)
    columns = {"force_n": made.force_n, "speed_m_s": 1e-3 * made.speed_mm_s}
    large = 200.0 * (made.pressure_v - np.median(made.pressure_v))
    for limit, faulty in ((np.inf, False), (0.1 * np.abs(large).max(), True)):
        trace = StrokeTrace(made.time_s, np.clip(large, -limit, limit), **columns)
        parts = [part for part in identify_stroke(trace, calibrated[0].table) if part["mode"] == "stroking"]
        assert any(part["fault"] is not None for part in parts) == faulty
