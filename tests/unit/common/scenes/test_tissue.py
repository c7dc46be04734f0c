from pathlib import Path

import pytest

from common.scenes.scene import load_scene
from tests.unit.common.scenes.test_scene import assert_refused, load

SCENE = """
name = "small"
[[objects]]
name = "belly"
material = "skin_dermis"
surface = "skin"
x_m = 0.0
length_m = 0.05
y_m = 0.0
width_m = 0.05
[objects.tissue]
layer_m = 0.030
exponent = 2.0
[[objects.tissue.nodules]]
name = "one"
x_m = 0.010
y_m = 0.010
size_m = 0.010
depth_m = 0.004
ratio = 5.0
[[objects.tissue.nodules]]
name = "two"
x_m = 0.030
y_m = 0.030
size_m = 0.008
depth_m = 0.003
ratio = 10.0
"""


def test_the_scene_knows_its_true_nodules(tmp_path: Path) -> None:
    assert [(n.name, n.x_m, n.size_m, n.ratio) for n in load(tmp_path, SCENE).nodules] == [
        ("one", 0.010, 0.010, 5.0),
        ("two", 0.030, 0.008, 10.0),
    ]
    assert load_scene("materials").nodules == ()
    assert len(load_scene("phantom_nodules").nodules) == 3


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("size_m = 0.010", "size_m = 0.050", r"objects\.0\.tissue\.nodules\.0\.size_m"),
        ("depth_m = 0.004", "depth_m = 0.001", r"objects\.0\.tissue\.nodules\.0\.depth_m"),
        ("ratio = 5.0", "ratio = 0.5", r"objects\.0\.tissue\.nodules\.0\.ratio"),
        ("exponent = 2.0", "exponent = 9.0", r"objects\.0\.tissue\.exponent"),
        ("layer_m = 0.030", "layer_m = 0.012", "nodule 'one' does not fit into a layer of 0.012 m"),
        ("x_m = 0.010", "x_m = 0.060", "nodule 'one' does not lie below the object"),
        ("x_m = 0.030\ny_m = 0.030", "x_m = 0.014\ny_m = 0.010", "nodules 'one' and 'two' overlap"),
        ('name = "two"', 'name = "one"', "two nodules have the same name"),
        ("y_m = 0.0\nwidth_m = 0.05\n", "", "an object with tissue needs y_m and width_m"),
    ],
)
def test_impossible_tissue_is_refused_in_one_line(tmp_path: Path, old: str, new: str, message: str) -> None:
    assert old in SCENE
    assert_refused(tmp_path, SCENE.replace(old, new, 1), message)
