"""`scene check`: a line for each object, and clear errors."""

import csv
import io
from pathlib import Path

import pytest

from common.scenes.scene import load_scene, scene_names
from teletaction.doctor.scene_check import COLUMNS, check_scene
from tests.commands import command, one_line


@pytest.mark.parametrize("name", scene_names())
def test_every_object_of_every_scene_is_right_enough(name: str) -> None:
    checked = check_scene(load_scene(name))
    assert [one.name for one in checked] == [thing.name for thing in load_scene(name).objects]
    for one in checked:
        assert 0.0 <= one.share <= 1.0
        assert one.error_k <= 0.1 + 0.1 * abs(one.difference_k)
        assert one.step_us > 0.0
        assert one.states == one.model.states


def test_a_scene_s_own_material_is_checked(tmp_path: Path) -> None:
    own = tmp_path / "own.toml"
    block = '[[objects]]\nname = "block"\nmaterial = "balsa"\nsurface = "pine"\nx_m = 0.0\nlength_m = 0.1\n'
    constants = "conductivity_w_mk = 0.05\ndensity_kg_m3 = 160.0\nspecific_heat_j_kgk = 1700.0\n"
    own.write_text(f'name = "own"\n{block}[materials.balsa]\n{constants}', "utf-8")
    (checked,) = check_scene(load_scene(str(own)))
    assert (checked.name, checked.material) == ("block", "balsa")
    assert checked.share <= 1.0


def test_not_all_materials_need_the_same_model_and_shorter_touches_need_no_more() -> None:
    long, short = (check_scene(load_scene("materials"), dwell_s) for dwell_s in (10.0, 0.2))
    assert len({one.states for one in long}) > 1
    assert all(a.states >= b.states for a, b in zip(long, short, strict=True))


def test_it_prints_csv() -> None:
    code, out, _ = command("scene", "check", "materials", "--dwell", 3).said
    assert code == 0
    rows = list(csv.DictReader(io.StringIO(out)))
    assert list(rows[0]) == list(COLUMNS)
    assert {row["object"]: row["material"] for row in rows}["wood"] == "pine"
    assert all(row["dwell_s"] == "3" and float(row["share"]) <= 1.0 for row in rows)


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["nowhere"], "unknown scene 'nowhere'; known: "),
        (["materials", "--dwell", "11"], "'--dwell': Input should be less than or equal to 10"),
        (["missing.toml"], "missing.toml: cannot read the scene"),
    ],
)
def test_wrong_input_is_named(arguments: list[str], said: str) -> None:
    assert said in one_line(command("scene", "check", *arguments), 2)
