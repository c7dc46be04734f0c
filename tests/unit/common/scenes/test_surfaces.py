from pathlib import Path

import numpy as np
import pytest

from common.scenes.surfaces import read_surfaces, surface_kind, surfaces

VELVET = """
[velvet]
stiffness_n_m = 300.0
k_tap = 1500.0
b_tap_per_s = 40.0
k_stroke_v = 800.0
k_stroke_f = 20.0
grooves = { apart_m = [0.002, 0.004], impulse_rad_s = 400.0, decay_per_s = 60.0 }
"""


def read(folder: Path, text: str) -> None:
    path = folder / "mine.toml"
    path.write_text(text, "utf-8")
    read_surfaces(path)


def test_rough_surfaces_vibrate_more_than_smooth_ones_and_soft_ones_tap_less() -> None:
    assert surface_kind("foam").k_stroke_v < surface_kind("plain_pvc").k_stroke_v < surface_kind("sandpaper").k_stroke_v
    assert surface_kind("foam").k_tap < surface_kind("plain_pvc").k_tap
    assert {name for name, kind in surfaces().items() if kind.grooves} == {
        "closely_grooved_pvc",
        "arbitrarily_grooved_pvc",
        "widely_grooved_pvc",
    }


def test_grooves_have_their_spacing_and_arbitrary_ones_follow_the_seed() -> None:
    close, wide = surface_kind("closely_grooved_pvc").grooves, surface_kind("arbitrarily_grooved_pvc").grooves
    assert close is not None
    assert wide is not None
    assert close.draw(0.0101, np.random.default_rng(0)) == pytest.approx([0.001, 0.003, 0.005, 0.007, 0.009])
    first, again, other = (wide.draw(0.5, np.random.default_rng(seed)) for seed in (1, 1, 2))
    assert first == again != other
    gaps = np.diff(first)
    assert gaps.min() >= 2e-3
    assert gaps.max() <= 8e-3
    assert gaps.std() > 0.5e-3


def test_an_unknown_surface_is_refused_with_a_list_of_the_known() -> None:
    with pytest.raises(ValueError, match=r"unknown surface 'velvet'; known: .*sandpaper"):
        surface_kind("velvet")


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("k_tap = 1500.0\n", "", "k_tap is missing"),
        ("= 1500.0", "= -1.0", "k_tap must be a number from 0 to 20000, not -1.0"),
        ("= 1500.0", "= nan", "k_tap must be a number from 0 to 20000, not nan"),
        ("= 300.0", "= true", "stiffness_n_m must be a number from 50 to 20000, not True"),
        ("k_tap", "colour = 1\nk_tap", "colour is no constant; there are stiffness_n_m, .*, grooves"),
        (", decay_per_s = 60.0", "", "grooves: decay_per_s is missing"),
        ("= 400.0", "= 4000.0", "grooves: impulse_rad_s must be a number from 0 to 1100, not 4000.0"),
        ("[0.002, 0.004]", "[0.004, 0.002]", r"grooves: apart_m must be \[smallest, largest\] distance"),
        ("[0.002, 0.004]", "[0.0, 0.002]", r"grooves: apart_m must be \[smallest, largest\] distance"),
        ("[0.002, 0.004]", "0.002", r"grooves: apart_m must be \[smallest, largest\] distance"),
        ("{ apart_m = [0.002, 0.004], impulse_rad_s = 400.0, decay_per_s = 60.0 }", "2", "grooves must be a table"),
    ],
)
def test_a_wrong_or_missing_constant_is_named(tmp_path: Path, old: str, new: str, said: str) -> None:
    assert old in VELVET
    read(tmp_path, VELVET)
    with pytest.raises(ValueError, match="mine.toml: velvet: " + said):
        read(tmp_path, VELVET.replace(old, new))
