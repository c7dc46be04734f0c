"""Thermal constants of materials, read from `materials.toml`."""

import math
import tomllib
from dataclasses import dataclass, fields
from functools import cache
from pathlib import Path

ALIASES = {
    "wood": "pine",
    "ceramic": "ceramic_tile",
    "steel": "carbon_steel",
    "foam": "pu_foam",
    "skin": "skin_dermis",
}
"""Everyday names and the specimen each stands for."""


@dataclass(frozen=True, slots=True)
class Material:
    """One material's thermal constants, SI; `spread` is one standard deviation of ln(effusivity)."""

    name: str
    conductivity_w_mk: float
    density_kg_m3: float
    specific_heat_j_kgk: float
    spread: float

    @property
    def effusivity(self) -> float:
        """sqrt(k rho c), J/(m2 K s^0.5): what a touch feels in its first seconds."""
        return math.sqrt(self.conductivity_w_mk * self.density_kg_m3 * self.specific_heat_j_kgk)


@cache
def materials() -> dict[str, Material]:
    """All known materials by name."""
    return read_materials(Path(__file__).parent / "materials.toml")


def read_materials(path: Path) -> dict[str, Material]:
    """Materials of a file by name.

    Raises:
        ValueError: a constant is missing, unknown, no number, or not above 0; the message names file, material and
            constant.
    """
    constants = [each.name for each in fields(Material) if each.name != "name"]
    known = {}
    for name, given in tomllib.loads(path.read_text("utf-8")).items():
        for constant in constants:
            value = given.get(constant)
            if value is None:
                raise ValueError(f"{path}: {name}: {constant} is missing")
            if isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 < value < math.inf:
                raise ValueError(f"{path}: {name}: {constant} must be a number above 0, not {value!r}")
        if unknown := sorted(set(given) - set(constants)):
            raise ValueError(f"{path}: {name}: {unknown[0]} is no constant; there are {', '.join(constants)}")
        known[name] = Material(name, **given)
    return known


def material(name: str) -> Material:
    """Look a material up by name or alias.

    Raises:
        KeyError: no such material; the message lists those that there are.
    """
    known = materials()
    try:
        return known[ALIASES.get(name, name)]
    except KeyError:
        raise KeyError(f"unknown material {name!r}; known: {', '.join(sorted([*known, *ALIASES]))}") from None


def contact_resistance_m2k_w(conductivity_w_mk: float) -> float:
    """Thermal contact resistance between a bare finger and an object, m2K/W.

    R_c = (0.37 + k)/(1870 k) after Ho & Jones 2008, which is optimistic for hard conductors:
    held at or above 1e-3, where measured skin temperatures of people lie.
    """
    return max(1e-3, (0.37 + conductivity_w_mk) / (1870.0 * conductivity_w_mk))
