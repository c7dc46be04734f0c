import math
from pathlib import Path

import pytest

from common.scenes.materials import ALIASES, material, materials, read_materials


def test_there_are_at_least_24_plausible_materials_known_by_name_and_alias() -> None:
    known = materials()
    assert len(known) >= 24
    for name, each in known.items():
        assert each.name == name
        assert 0.01 < each.conductivity_w_mk <= 500
        assert 10 < each.density_kg_m3 <= 25_000
        assert 100 < each.specific_heat_j_kgk <= 10_000
        assert 0 < each.spread < 0.5
        constants = each.conductivity_w_mk * each.density_kg_m3 * each.specific_heat_j_kgk
        assert each.effusivity == pytest.approx(math.sqrt(constants))
    for alias, name in ALIASES.items():
        assert material(alias) is known[name]
        assert alias not in known
    with pytest.raises(KeyError, match=r"unknown material 'unobtainium'; known: .*aluminium.*wood"):
        material("unobtainium")


def test_effusivities_are_ordered_as_fingers_feel_them() -> None:
    felt = [material(name).effusivity for name in ("aluminium", "ceramic", "pvc", "wood", "foam")]
    assert felt == sorted(felt, reverse=True)


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ("density_kg_m3 = 500.0", "specific_heat_j_kgk is missing"),
        ("density_kg_m3 = -1.0\nspecific_heat_j_kgk = 1.0", "density_kg_m3 must be a number from 1 to 25000, not -1.0"),
        ("density_kg_m3 = nan\nspecific_heat_j_kgk = 1.0", "density_kg_m3 must be a number from 1 to 25000, not nan"),
        ('density_kg_m3 = "x"\nspecific_heat_j_kgk = 1.0', "density_kg_m3 must be a number from 1 to 25000, not 'x'"),
        ("density_kg_m3 = true\nspecific_heat_j_kgk = 1.0", "density_kg_m3 must be a number from 1 to 25000, not True"),
        ("density_kg_m3 = 1.0\nspecific_heat_j_kgk = 1e3\ncolour = 1.0", "colour is no constant; there are"),
    ],
)
def test_a_wrong_or_missing_constant_is_named(tmp_path: Path, line: str, said: str) -> None:
    path = tmp_path / "mine.toml"
    path.write_text(f"[balsa]\nconductivity_w_mk = 0.05\nspread = 0.1\n{line}\n", encoding="utf-8")
    with pytest.raises(ValueError, match="mine.toml: balsa: " + said):
        read_materials(path)
