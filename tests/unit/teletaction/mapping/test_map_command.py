"""The command `map` writes the contract's files, finds a stiff place, and refuses wrong input in one line."""

import csv
import json
import math
from pathlib import Path

import numpy as np
import pytest

from tests.commands import command, one_line

OFFSET_N = 0.08


def presses(path: Path, lump: tuple[float, float] = (12.0, 18.0), step_mm: int = 3, side_mm: int = 36) -> Path:
    """A file of presses in steps on an even ground of 800 N/m, three times as stiff at one place."""
    chance = np.random.default_rng(1)
    lines = ["press,depth_mm,force_n,x_mm,y_mm,z_mm"]
    places = [(x, y) for x in range(0, side_mm + 1, step_mm) for y in range(0, side_mm + 1, step_mm)]
    for press, (x, y) in enumerate(places):
        k = 0.8 * (1.0 + 2.0 * math.exp(-0.5 * (math.dist((x, y), lump) / 4.0) ** 2))
        for depth in np.linspace(0.0, 2.0, 6):
            force = OFFSET_N + k * depth + 0.01 * chance.normal()
            lines.append(f"{press},{depth:.3f},{force:.4f},{x},{y},{-depth:.3f}")
    path.write_text("\n".join(lines) + "\n", "utf-8")
    return path


def columns(path: Path) -> dict[str, np.ndarray]:
    with path.open(newline="") as file:
        rows = list(csv.DictReader(file))
    return {name: np.array([float(row[name] or "nan") for row in rows]) for name in rows[0]}


def test_the_files_of_the_contract(tmp_path: Path) -> None:
    outcome = command("map", presses(tmp_path / "presses.csv"), "--out", tmp_path / "out")
    assert outcome.said[:2] == (0, "")
    assert "used 169 of 169 presses, found 1 lump" in outcome.err
    cells = columns(tmp_path / "out" / "map.csv")
    assert list(cells) == ["x_mm", "y_mm", "value", "sd", "lump_probability"]
    away_mm = np.hypot(cells["x_mm"] - 12.0, cells["y_mm"] - 18.0)
    assert np.median(cells["value"][away_mm > 15.0]) == pytest.approx(800.0, rel=0.03)
    assert cells["value"][away_mm < 1.0].mean() == pytest.approx(2400.0, rel=0.08)
    assert cells["lump_probability"][away_mm < 3.0].min() > 0.9
    assert cells["lump_probability"][away_mm > 10.0].max() < 0.2
    border = (cells["x_mm"] < -8.0) | (cells["x_mm"] > 44.0)
    inside = np.hypot(cells["x_mm"] - 18.0, cells["y_mm"] - 18.0) < 15.0
    share = cells["sd"] / cells["value"]
    assert np.median(share[border]) > 2.0 * np.median(share[inside])
    (lump,) = json.loads((tmp_path / "out" / "map.json").read_text())["lumps"]
    assert math.dist((lump["x_mm"], lump["y_mm"]), (12.0, 18.0)) < 1.0
    assert lump["stiffness_ratio"] == pytest.approx(2.5, abs=0.8)
    assert not lump["at_edge"]
    assert (tmp_path / "out" / "map.png").read_bytes().startswith(b"\x89PNG")


@pytest.mark.long
def test_a_lump_at_the_edge_is_marked(tmp_path: Path) -> None:
    command("map", presses(tmp_path / "presses.csv", (0.0, 18.0)), "--out", tmp_path / "out")
    (lump,) = json.loads((tmp_path / "out" / "map.json").read_text())["lumps"]
    assert lump["at_edge"]


@pytest.mark.long
def test_several_files_and_lines_of_roughness_and_temperature(tmp_path: Path) -> None:
    lines = "x_mm,y_mm,roughness_v,object_c,object_c_sd\n1,1,0.01,33.1,0.2\n4,1,0.02,,\n7,1,,34.0,\n"
    (tmp_path / "strokes.csv").write_text(lines, "utf-8")
    file = presses(tmp_path / "presses.csv")
    assert command("map", file, tmp_path / "strokes.csv", "--out", tmp_path / "out").code == 0
    found = json.loads((tmp_path / "out" / "map.json").read_text())
    assert found["quantities"] == ["temperature", "roughness", "stiffness"]


@pytest.mark.long
def test_a_few_presses_have_no_lump_probability(tmp_path: Path) -> None:
    assert command("map", presses(tmp_path / "few.csv", step_mm=20), "--out", tmp_path / "out").code == 0
    assert np.isnan(columns(tmp_path / "out" / "map.csv")["lump_probability"]).all()
    found = json.loads((tmp_path / "out" / "map.json").read_text())
    assert (found["lumps"], found["ground_spread_ln"]) == ([], None)


@pytest.mark.long
def test_failed_presses_are_listed_and_not_mapped(tmp_path: Path) -> None:
    file = presses(tmp_path / "presses.csv")
    (tmp_path / "contacts.csv").write_text("press,status\n0,fail\n1,ok\n", "utf-8")
    command("map", file, "--out", tmp_path / "out")
    found = json.loads((tmp_path / "out" / "map.json").read_text())
    assert (found["presses"], found["used"]) == (169, 168)
    assert [one["press"] for one in found["skipped"]] == [0]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("time_s,force_n\n0,0\n", "no column press, roughness_v or object_c"),
        ("press,depth_mm,force_n\n0,0,0\n0,1,1\n", "columns x_mm,y_mm,z_mm are missing"),
        ("press,depth_mm,force_n,x_mm,y_mm,z_mm\n0,0,0,1,1,1\n0,1,-0.05,1,1,1\n", "no press or line gives a sample"),
        (
            "press,depth_mm,force_n,x_mm,y_mm,z_mm\n0,0.5,0,1,1,1\n0,-1,1,1,1,1\n0,0,0.2,1,1,1\n",
            "wrong.csv: the force falls with depth_mm in most presses: depth is positive below the contact",
        ),
        ("x_mm,y_mm,roughness_v\n1,1,0.1\n2,2,-0.1\n", "line 3: column roughness_v: must be above 0"),
        ("x_mm,y_mm,object_c,object_c_sd\n1,1,30,-0.2\n", "line 2: column object_c_sd: must not be negative"),
        ("x_mm,y_mm,object_c,object_c_sd\n1,1,30,1e200\n", "line 2: column object_c_sd: must be at most 1000"),
        ("x_mm,y_mm,object_c\n1,1e300,30\n", "wrong.csv: a coordinate of 1e+300 mm is no place"),
        ("x_mm,y_mm,object_c\n1,1,30\n1,5000,30\n", "a map has at most 1000 mm"),
        ("x_mm,y_mm,object_c\n0,0,303\n9,0,304\n", "column object_c: a median of 303.5 is no temperature"),
        (
            "x_mm,y_mm,roughness_v\n0,0,0.1\n0.054,0.02,0.1\n",
            "the places are at most 0.054 mm apart: they look like m; multiply by 1000",
        ),
        ("x_mm,y_mm,object_c\n1,north,30\n", "line 2: column y_mm: not a finite number"),
    ],
)
def test_wrong_input_is_refused_in_one_line(tmp_path: Path, text: str, words: str) -> None:
    (tmp_path / "wrong.csv").write_text(text, "utf-8")
    assert words in one_line(command("map", tmp_path / "wrong.csv", "--out", tmp_path / "out"), 2)
    assert not (tmp_path / "out").exists()


def test_a_file_that_is_named_twice_is_refused(tmp_path: Path) -> None:
    file = presses(tmp_path / "grid.csv")
    (tmp_path / "link.csv").symlink_to(file)
    for again in (file, tmp_path / "." / "grid.csv", tmp_path / "link.csv"):
        words = one_line(command("map", file, again, "--out", tmp_path / "out"), 2)
        assert f"{again}: is named twice" in words
    assert not (tmp_path / "out").exists()


def test_a_map_overwrites_no_recording_that_it_is_made_of(tmp_path: Path) -> None:
    file = presses(tmp_path / "map.csv")
    before = file.read_bytes()
    assert "map.csv: the map would overwrite it" in one_line(command("map", file, "--out", tmp_path), 2)
    assert file.read_bytes() == before


@pytest.mark.parametrize("verb", ["map", "identify stiffness"])
def test_contacts_of_two_files_with_the_same_numbers_are_refused(tmp_path: Path, verb: str) -> None:
    """The presses of the second file would be placed where those of the first one were."""
    left, right = (presses(tmp_path / f"{side}.csv", step_mm=20) for side in ("left", "right"))
    (tmp_path / "contacts.csv").write_text("press,x_mm,y_mm,z_mm\n3,9,9,0\n", "utf-8")
    outcome = command(*verb.split(), left, right, *(["--out", tmp_path / "out"] if verb == "map" else []))
    assert outcome.code == 2
    assert "contacts.csv: column press: press 3 is in left.csv and in right.csv; give each file" in outcome.err


def test_a_missing_file_or_folder_is_named(tmp_path: Path) -> None:
    assert "no.csv: cannot be read" in one_line(command("map", tmp_path / "no.csv", "--out", tmp_path), 2)
    assert "--out" in one_line(command("map", tmp_path / "no.csv"), 2)


@pytest.mark.long
def test_presses_on_a_line_give_a_map(tmp_path: Path) -> None:
    lines = [f"{n},{depth},{OFFSET_N + 0.8 * depth},{3 * n},0,0" for n in range(12) for depth in (0.0, 1.0, 2.0)]
    file = tmp_path / "line.csv"
    file.write_text("\n".join(["press,depth_mm,force_n,x_mm,y_mm,z_mm", *lines]) + "\n", "utf-8")
    assert command("map", file, "--out", tmp_path / "out").code == 0
    value = columns(tmp_path / "out" / "map.csv")["value"]
    assert np.median(value) == pytest.approx(800.0, rel=0.02)
