"""Thermal constants of materials, read from `materials.toml`."""

import math
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from common.files.constants import read_constants
from common.files.read_files import read_tables

ALIASES = {
    "wood": "pine",
    "ceramic": "ceramic_tile",
    "steel": "carbon_steel",
    "foam": "pu_foam",
    "skin": "skin_dermis",
}
"""Everyday names of materials, and the specimen that each stands for."""
CONSTANTS = {
    "conductivity_w_mk": (0.01, 500.0),
    "density_kg_m3": (1.0, 25_000.0),
    "specific_heat_j_kgk": (100.0, 10_000.0),
    "spread": (0.0, 1.0),
}
"""Constants of each material, with the ranges that the link can carry and a finger can be shown."""


@dataclass(frozen=True, slots=True)
class Material:
    """One material's thermal constants, SI; `spread` is the standard deviation of ln(effusivity)."""

    name: str
    conductivity_w_mk: float
    density_kg_m3: float
    specific_heat_j_kgk: float
    spread: float

    @classmethod
    def read(cls, name: str, given: object, where: str) -> "Material":
        """Read a table's constants; raises ValueError that contains `where` and names the wrong constant."""
        return cls(name, **read_constants(given, CONSTANTS, where))

    @property
    def effusivity(self) -> float:
        """sqrt(k rho c), J/(m2 K s^0.5): it determines the skin temperature in the first seconds of a touch."""
        return math.sqrt(self.conductivity_w_mk * self.density_kg_m3 * self.specific_heat_j_kgk)


@cache
def materials() -> dict[str, Material]:
    """Return all known materials by name."""
    return read_materials(Path(__file__).parent / "constants" / "materials.toml")


def read_materials(path: Path) -> dict[str, Material]:
    """Return the materials of a file by name.

    Raises:
        ValueError: a constant is missing, unknown, not a number, or out of range; the message names file, material
            and constant.
    """
    tables = read_tables(path)
    return {name: Material.read(name, given, f"{path}: {name}") for name, given in tables.items()}


def material(name: str) -> Material:
    """Look a material up by name or alias.

    Raises:
        KeyError: there is no such material; the message lists the known ones.
    """
    known = materials()
    try:
        return known[ALIASES.get(name, name)]
    except KeyError:
        raise KeyError(f"unknown material {name!r}; known: {', '.join(sorted([*known, *ALIASES]))}") from None
