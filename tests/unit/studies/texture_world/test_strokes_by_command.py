"""Strokes of 1000 samples/s through the commands: spectra name the surfaces, and a stranger is unknown."""

import json

import numpy as np
import pytest

from remote_site.texture.surface_table import SurfaceTable
from studies.texture_world.models import read_models
from studies.texture_world.strokes import stroke_over
from tests.commands import command
from tests.unit.studies.texture_world.made_models import models_in

pytestmark = pytest.mark.long
KNOWN, STRANGERS, LABELLED = 6, 6, 3


def write_stroke(path, model, seed, place, number=0):
    """Write two seconds of a stroke as a recorder does, with times in milliseconds."""
    stroke = stroke_over(model, seed, place, number)
    rows = [np.arange(len(stroke.force_n)) / 1000, stroke.signal_v, stroke.force_n, stroke.speed_mm_s]
    header = "time_s,pressure_v,force_n,speed_mm_s"
    np.savetxt(path, np.column_stack(rows)[:2200], fmt="%.5f", delimiter=",", header=header, comments="")


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Folder with the strokes, a table made from them, and the report of the calibration."""
    out = tmp_path_factory.mktemp("strokes")
    models = read_models(models_in(out / "models", KNOWN + STRANGERS))
    labels = ["file,surface,roughness_um"]
    for place, model in enumerate(models[:KNOWN]):
        for number in range(LABELLED):
            write_stroke(out / f"{place}_{number}.csv", model, 1, place, number)
            labels.append(f"{place}_{number}.csv,{model.material},{2.0 + place}")
    (out / "labels.csv").write_text("\n".join(labels) + "\n")
    said = command("calibrate", "texture", "--strokes", out, "--out", out / "surfaces.json")
    assert said.code == 0, said.err
    for place, model in enumerate(models):
        write_stroke(out / f"new_{place}.csv", model, 2, place)
    return out, said.err, [model.material for model in models]


def answers(out, places):
    """Lines about the longest stroking part of new strokes."""
    said = command("identify", "texture", "--table", out / "surfaces.json", *(out / f"new_{k}.csv" for k in places))
    assert said.code == 0, said.err
    found = {}
    for line in map(json.loads, said.out.splitlines()):
        before = found.get(line["stroke"])
        if line["mode"] == "stroking" and (
            before is None or line["end_s"] - line["start_s"] > before["end_s"] - before["start_s"]
        ):
            found[line["stroke"]] = line
    return list(found.values())


def test_surfaces_are_named_by_their_spectra(made):
    out, report, names = made
    assert "surfaces by their spectra" in report
    assert SurfaceTable.load(out / "surfaces.json").spectra is not None
    lines = answers(out, range(KNOWN))
    assert [line["stroke"] for line in lines] == [str(out / f"new_{place}.csv") for place in range(KNOWN)]
    named = [line["surface"] for line in lines]
    assert sum(name == true for name, true in zip(named, names[:KNOWN], strict=True)) >= KNOWN - 2
    assert set(named) <= {*names[:KNOWN], "unknown"}
    assert all(0.0 < line["surface_probability"] <= 1.0 for line in lines)
    assert {"roughness_um", "roughness_sd_um"} <= lines[0].keys()


def test_strangers_are_unknown(made):
    lines = answers(made[0], range(KNOWN, KNOWN + STRANGERS))
    assert sum(line["surface"] == "unknown" for line in lines) >= STRANGERS - 2
