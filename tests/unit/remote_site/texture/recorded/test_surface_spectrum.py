"""Surfaces of slow strokes, recognised at another pressure and speed, from a table that keeps what it was made of."""

import json
from dataclasses import replace

import numpy as np
import pytest

from remote_site.texture.calibration.spectrum_calibration import LabelledStroke, calibrate_spectra, read_labelled
from remote_site.texture.recorded.identify_texture import identify_texture, load_surfaces
from remote_site.texture.recorded.spectrum_table import SpectrumTable
from remote_site.texture.recorded.surface_spectrum import _without_motions, unevenness
from teletaction.report.calibration_report import spectrum_text
from tests.commands import command
from tests.slow_strokes import PLACES_MM, SURFACES, folder_of, stroke


@pytest.fixture(scope="module")
def fit():
    return calibrate_spectra(folder_of((120, 180)))


@pytest.mark.long
def test_surfaces_are_recognised_at_another_pressure_and_place(fit):
    assert fit.by_load
    assert [model.along for model in fit.table.models] == ["m", "stroke"]
    assert sum(label == said for label, said in fit.left_out) >= 0.9 * len(fit.left_out)
    for start_mm in (50.0, 900.0):
        new = folder_of((240,), seed=3, start_mm=start_mm)
        found = [fit.table.recognise(one.trace, one.speed_m_s) for one in new]
        assert [one.surface for one in found if one is not None] == [one.surface for one in new]


@pytest.mark.long
def test_the_stroke_is_the_unit_without_a_speed(fit):
    new = folder_of((240,), seed=3)
    found = [fit.table.recognise(one.trace) for one in new]
    assert sum(one is not None and one.surface == own.surface for one, own in zip(found, new, strict=True)) >= 8
    without = calibrate_spectra([replace(one, speed_m_s=None) for one in folder_of((120, 180))])
    assert [model.along for model in without.table.models] == ["stroke"]


@pytest.mark.long
def test_a_single_stroke_without_a_speed_is_named(fit):
    first, *others = folder_of((120, 180))
    partly = calibrate_spectra([replace(first, speed_m_s=None), *others])
    assert [model.along for model in partly.table.models] == ["stroke"]
    assert f"warning: {first.trace.name}: no speed_mm_s (number of such strokes: 1), so that" in spectrum_text(partly)
    assert "no speed_mm_s" not in spectrum_text(fit)


@pytest.mark.long
def test_strokes_of_unlike_length_at_one_speed_are_measured_in_seconds():
    strokes = [
        LabelledStroke(stroke(surface, load, 40.0, k, length_mm=length), surface, None)
        for surface in SURFACES
        for load in (120, 180)
        for k, length in enumerate((250.0, 500.0, 900.0))
    ]
    assert calibrate_spectra(strokes).table.models[0].along == "s"


def test_a_strange_surface_is_unknown(fit):
    chance = np.random.default_rng(5)
    strange = stroke("smooth", 150, 40.0, 1)
    rough = strange.signals * (1.0 + 0.3 * chance.normal(size=strange.signals.shape))
    found = fit.table.recognise(replace(strange, signals=rough), 0.04)
    assert found is not None
    assert found.surface == "unknown"


def test_a_short_stroke_is_recognised_by_fewer_bands_or_not_at_all(fit):
    half = fit.table.recognise(stroke("waved", 150, 20.0, 2, length_mm=240.0), 0.02)
    assert half is not None
    assert half.surface == "waved"
    assert fit.table.recognise(stroke("waved", 150, 20.0, 2, length_mm=8.0), 0.02) is None


def test_heaving_and_tilting_leave_no_trace():
    chance = np.random.default_rng(0)
    motions = chance.normal(size=(400, 3)) @ np.vstack([np.ones(16), PLACES_MM.T])
    assert np.abs(_without_motions(motions, 3)).max() < 1e-9
    surface = 0.1 * chance.normal(size=(400, 16))
    left = _without_motions(motions + surface, 3)
    assert left.std() == pytest.approx(surface.std(), rel=0.15)


def test_flat_signals_and_signals_without_load():
    trace = stroke("waved", 150, 40.0, 0)
    signals = np.column_stack([trace.signals, np.zeros(len(trace.time_s))])
    flat = replace(trace, signals=signals, signal_names=(*trace.signal_names, "flat"))
    seen = unevenness(flat, "s")
    assert seen is not None
    assert seen.used.tolist() == list(range(16))
    centred = unevenness(replace(trace, signals=trace.signals - trace.signals.mean(axis=0)), "s")
    assert centred is not None
    assert centred.loads == pytest.approx(np.ones(16))
    assert unevenness(replace(trace, signals=np.zeros_like(trace.signals)), "s") is None
    assert unevenness(trace, "m") is None


def write(folder, traces):
    labels = ["file,surface"]
    for k, one in enumerate(traces):
        rows = np.column_stack([one.trace.time_s, one.trace.signals])
        header = ",".join(("time_s", *one.trace.signal_names))
        np.savetxt(folder / f"{k}.csv", rows, fmt="%.3f", delimiter=",", header=header, comments="")
        labels.append(f"{k}.csv,{one.surface}")
    (folder / "labels.csv").write_text("\n".join(labels) + "\n")


@pytest.mark.long
@pytest.mark.parametrize("signal", ["best", "mean", "taxel7"])
def test_from_a_folder_to_a_name(tmp_path, signal):
    write(tmp_path, folder_of((120, 180)))
    out = tmp_path / "surfaces.json"
    made = ("--out", out, "--report", tmp_path / "report")
    done = command("calibrate", "texture", "--strokes", tmp_path, "--signal", signal, *made)
    assert done.code == 0
    assert "left out" in (tmp_path / "report" / "report.txt").read_text() or "made without" in done.err
    assert isinstance(load_surfaces(out), SpectrumTable)
    new = tmp_path / "new"
    new.mkdir()
    write(new, [one for one in folder_of((240,), seed=3) if one.speed_m_s == 0.04])
    files = [new / f"{k}.csv" for k in range(3)]
    found = command("identify", "texture", "--table", out, "--signal", signal, "--speed", 40, *files)
    lines = [json.loads(line) for line in found.out.splitlines()]
    right = sum(line["surface"] == name for line, name in zip(lines, SURFACES, strict=True))
    assert right == 3 if signal != "taxel7" else right >= 1
    assert all(0.3 < line["surface_probability"] <= 1.0 for line in lines)
    assert all(line["k_speed_rpm_per_mm_s"] is None for line in lines)


@pytest.mark.long
def test_errors_name_the_remedy(tmp_path, fit):
    write(tmp_path, folder_of((120,)))
    with pytest.raises(ValueError, match="pressure_v is missing; --signal names another of"):
        list(identify_texture([tmp_path / "0.csv"], fit.table))
    with pytest.raises(ValueError, match="1 signals, the table was calibrated with 16"):
        list(identify_texture([tmp_path / "0.csv"], fit.table, "taxel3", 20.0))
    fast = tmp_path / "fast.csv"
    fast.write_text("time_s,pressure_v\n" + "\n".join(f"{k / 2000:.4f},{k % 7}" for k in range(2000)) + "\n")
    with pytest.raises(ValueError, match="2000 samples/s; the table is of strokes below 1000"):
        list(identify_texture([fast], fit.table))
    rows = (tmp_path / "labels.csv").read_text().splitlines()
    (tmp_path / "labels.csv").write_text(
        "\n".join([f"{rows[0]},roughness_um", *(f"{row},2" for row in rows[1:])]) + "\n"
    )
    with pytest.raises(ValueError, match="column roughness_um: strokes below 1000 samples/s show no roughness"):
        read_labelled(tmp_path, "best", 20.0)
    with pytest.raises(ValueError, match=r"^\w+ is the shortest and \w+ the coarsest stroke: too short"):
        calibrate_spectra(folder_of((120,), length_mm=60.0))
    strokes = folder_of((120,))
    dead = replace(strokes[0].trace, signals=np.zeros_like(strokes[0].trace.signals))
    with pytest.raises(ValueError, match="smooth_120_20: no signal in it moves"):
        calibrate_spectra([replace(strokes[0], trace=dead), *strokes[1:]])


def test_a_table_survives_its_file(tmp_path, fit):
    fit.table.save(tmp_path / "t.json")
    assert SpectrumTable.load(tmp_path / "t.json").models == fit.table.models
    fields = json.loads((tmp_path / "t.json").read_text())
    fields["models"][0]["means"][0][0] += 1.0
    (tmp_path / "t.json").write_text(json.dumps(fields))
    with pytest.raises(ValueError, match="content_hash"):
        load_surfaces(tmp_path / "t.json")
