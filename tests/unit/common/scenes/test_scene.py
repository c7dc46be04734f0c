from itertools import pairwise

import pytest

from common.scenes.materials import material
from common.scenes.scene import load_scene, scene_names
from common.scenes.script import Hold, Stroke, Tap
from common.scenes.surfaces import surface_kind

SHIPPED = (
    "abdomen",
    "materials",
    "paper_iron_wood",
    "paper_materials",
    "paper_textures",
    "phantom",
    "phantom_nodules",
    "phantom_sweep",
    "tender_place",
)
GROOVED = {f"{how}_grooved_pvc" for how in ("closely", "arbitrarily", "widely")}
PAPERS_SURFACES = {"foam", "sandpaper", "plain_pvc"} | GROOVED
SCENE = """
name = "small"
calibrated = ["pvc"]
[[objects]]
name = "block"
material = "wood"
surface = "plain_pvc"
x_m = 0.0
length_m = 0.05
[[script]]
act = "move"
object = "block"
u = 0.5
"""


def load(tmp_path, text):
    path = tmp_path / "small.toml"
    path.write_text(text, "utf-8")
    return load_scene(str(path))


def assert_refused(tmp_path, text, message):
    """Assert that a scene is refused in one line that names its file and matches `message`."""
    with pytest.raises(ValueError, match=message) as caught:
        load(tmp_path, text)
    assert "small.toml: " in str(caught.value)
    assert "\n" not in str(caught.value)


def test_shipped_scenes_load_and_a_missing_one_is_reported():
    assert scene_names() == SHIPPED
    for name in scene_names():
        assert load_scene(name).name == name
    with pytest.raises(ValueError, match=f"unknown scene 'moon'; known: {', '.join(SHIPPED)}"):
        load_scene("moon")
    with pytest.raises(KeyError, match="has no object 'x'"):
        load_scene("materials").object_named("x")


def test_materials_scene_holds_the_papers_objects_and_touches_four_materials_for_eight_seconds():
    scene = load_scene("materials")
    assert {thing.surface for thing in scene.objects} >= PAPERS_SURFACES
    held, at = set(), ""
    for step in scene.script:
        at = getattr(step, "object", at)
        if isinstance(step, Hold) and step.seconds >= 8.0:
            held.add(scene.object_named(at).material)
    assert held == set(scene.calibrated) == {"aluminium", "ceramic_tile", "pvc", "pine"}
    assert any(isinstance(step, Stroke) for step in scene.script)
    assert sum(step.times for step in scene.script if isinstance(step, Tap)) >= 2


def test_pvc_zones_are_one_piece():
    zones = [thing for thing in load_scene("materials").objects if thing.material == "pvc"]
    assert {zone.body for zone in zones} == {"pvc_block"}
    for zone, following in pairwise(zones):
        assert zone.end_x_m == pytest.approx(following.x_m)


def test_phantom_is_as_warm_as_the_sensor_with_a_warmer_spot_and_a_stiffer_nodule():
    scene = load_scene("phantom")
    tissue = scene.object_named("tissue")
    assert tissue.absolute_c == scene.ambient_c + 10.0
    assert scene.object_named("warm_spot").absolute_c == tissue.absolute_c + 2.0
    assert scene.object_named("nodule").stiffness == 3 * tissue.stiffness


def test_the_paper_s_conditions():
    textures, materials, fig6 = (load_scene(f"paper_{name}") for name in ("textures", "materials", "iron_wood"))
    assert textures.virtual_stiffness_n_m == surface_kind("plain_pvc").stiffness_n_m
    assert {thing.surface for thing in textures.objects} == PAPERS_SURFACES
    assert {thing.material for thing in materials.objects} == {"aluminium", "ceramic_tile", "pvc", "pine"}
    assert {thing.absolute_c for thing in materials.objects} == {25.0}
    assert {(thing.material, thing.absolute_c) for thing in fig6.objects} == {("iron", 35.0), ("pine", 35.0)}
    assert fig6.ambient_c == 25.0


def test_alias_and_defaults(tmp_path):
    block = load(tmp_path, SCENE).objects[0]
    assert block.material == "pine"
    assert block.stiffness == 4000.0
    assert block.y_range_m[0] < -1.0
    assert block.x_at(0.5) == pytest.approx(0.025)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('material = "wood"', 'material = "wodd"', r"objects\.0\.material.*unknown material 'wodd'"),
        ('surface = "plain_pvc"', 'surface = "velvet"', r"objects\.0\.surface.*unknown surface 'velvet'"),
        ("x_m = 0.0", "x_m = 0.0\ncolour = 3", r"objects\.0\.colour: Extra inputs"),
        ("x_m = 0.0", "x_m = 3.0", r"objects\.0\.x_m"),
        ("x_m = 0.0", "x_m = nan", r"objects\.0\.x_m"),
        ("x_m = 0.0", "x_m = 0.0\ny_m = 0.0", "both y_m and width_m"),
        ("x_m = 0.0", "x_m = 0.0\noffset_c = [3.0, -3.0]", "low <= high"),
        ('object = "block"', 'object = "blok"', r"script step 1 names no object 'blok'"),
        ('act = "move"', 'act = "fly"', r"script\.0"),
        ('calibrated = ["pvc"]', 'calibrated = ["gold"]', r"calibrated.*unknown material 'gold'"),
        (
            "[[script]]",
            '[[objects]]\nname = "b"\nmaterial = "pvc"\nsurface = "foam"\nx_m = 0.04\nlength_m = 0.05\n[[script]]',
            "'block' and 'b' overlap",
        ),
        (
            "[[script]]",
            '[[objects]]\nname = "block"\nmaterial = "pvc"\nsurface = "foam"\nx_m = 0.1\nlength_m = 0.05\n[[script]]',
            "same name",
        ),
    ],
)
def test_bad_scene_is_refused_in_one_line_that_names_file_and_field(tmp_path, old, new, message):
    assert old in SCENE
    assert_refused(tmp_path, SCENE.replace(old, new, 1), message)


OWN = """
[materials.balsa]
conductivity_w_mk = 0.05
density_kg_m3 = 160.0
specific_heat_j_kgk = 1700.0
"""


def test_a_scene_brings_materials_of_its_own(tmp_path):
    scene = load(tmp_path, SCENE.replace('material = "wood"', 'material = "balsa"') + OWN)
    balsa = scene.material(scene.objects[0].material)
    assert (balsa.name, balsa.conductivity_w_mk, balsa.density_kg_m3, balsa.spread) == ("balsa", 0.05, 160.0, 0.0)
    assert scene.material("pvc") is material("pvc")


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("density_kg_m3 = 160.0\n", "", "materials: balsa: density_kg_m3 is missing"),
        ("= 160.0", "= 0.0", "materials: balsa: density_kg_m3 must be a number from 1 to 25000, not 0.0"),
        ("= 0.05", '= "low"', "materials: balsa: conductivity_w_mk must be a number from 0.01 to 500, not 'low'"),
        ("= 0.05", "= 0.05\ncolour = 1.0", "materials: balsa: colour is no constant"),
        ("balsa", "wood", "materials: wood: is the name of a known material"),
        ("balsa", "pine", "materials: pine: is the name of a known material"),
        ("balsa", 41 * "b", f"materials: {41 * 'b'}: is longer than 40 characters"),
        (OWN, "materials = 3\n", "materials: must be tables"),
        (OWN, "materials.balsa = 3\n", "materials: balsa must be a table with conductivity_w_mk"),
    ],
)
def test_a_wrong_material_of_a_scene_is_named(tmp_path, old, new, said):
    assert old in OWN
    own = OWN.replace(old, new)
    assert_refused(tmp_path, own + SCENE if "materials" in new else SCENE + own, said)
