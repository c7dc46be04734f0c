"""Models the pad of a finger: its tissue layers, its surroundings, and its steady temperatures in free motion."""

from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.typing import NDArray

Floats = NDArray[np.float64]

BLOOD_DENSITY_KG_M3 = 1060.0
"""Density of blood, kg/m3."""
BLOOD_SPECIFIC_HEAT_J_KGK = 3770.0
"""Specific heat of blood, J/(kg K)."""
REST_CELLS = (60, 60, 120)
"""Cells of each layer for the temperatures at rest; twice as many cells change them by less than 1 mK."""


@dataclass(frozen=True, slots=True)
class Layer:
    """One layer of tissue, SI; perfusion in volumes of blood per volume of tissue and second."""

    name: str
    thickness_m: float
    conductivity_w_mk: float
    density_kg_m3: float
    specific_heat_j_kgk: float
    perfusion_per_s: float


LAYERS = (
    Layer("epidermis", 0.45e-3, 0.24, 1200.0, 3590.0, 0.0),
    Layer("dermis", 1.2e-3, 0.45, 1200.0, 3300.0, 0.005),
    Layer("subcutis", 5.0e-3, 0.19, 1000.0, 2500.0, 0.00125),
)
"""Layers of the finger pad, outermost first."""


@dataclass(frozen=True, slots=True)
class Body:
    """Surroundings of the finger: temperatures, C, and heat transfer to air, W/m2K; only `deep_c` differs by person."""

    air_c: float = 25.0
    deep_c: float = 34.0
    arterial_c: float = 35.0
    air_w_m2k: float = 10.0


@dataclass(frozen=True, slots=True)
class Cells:
    """Tissue divided into m cells, outermost first; per area of skin.

    Attributes:
        size_m: (m,) thickness.
        conductivity_w_mk: (m,) thermal conductivity.
        heat_j_m2k: (m,) heat capacity.
        blood_w_m2k: (m,) heat flux from the blood for each kelvin between blood and cell.
        layer_of: (m,) index into LAYERS.
    """

    size_m: Floats
    conductivity_w_mk: Floats
    heat_j_m2k: Floats
    blood_w_m2k: Floats
    layer_of: NDArray[np.intp]

    @property
    def links_w_m2k(self) -> Floats:
        """(m - 1,) conductances between neighbours: Eq. 4, both half cells in series."""
        half = self.size_m / (2.0 * self.conductivity_w_mk)
        return np.asarray(1.0 / (half[:-1] + half[1:]))

    @property
    def half_m2k_w(self) -> float:
        """Thermal resistance from the skin's surface to the centre of the outermost cell."""
        return float(self.size_m[0] / (2.0 * self.conductivity_w_mk[0]))

    @property
    def deep_w_m2k(self) -> float:
        """Conductance from the innermost cell's centre to the deep tissue."""
        return float(2.0 * self.conductivity_w_mk[-1] / self.size_m[-1])

    @property
    def centres_m(self) -> Floats:
        """(m,) depth of each cell's centre."""
        return np.asarray(np.cumsum(self.size_m) - 0.5 * self.size_m)


def cells(counts: tuple[int, int, int]) -> Cells:
    """Divide each layer into its count of equal cells."""
    layer_of = np.repeat(np.arange(len(LAYERS)), counts)
    size = np.array([layer.thickness_m / count for layer, count in zip(LAYERS, counts, strict=True)])[layer_of]
    blood = BLOOD_DENSITY_KG_M3 * BLOOD_SPECIFIC_HEAT_J_KGK
    return Cells(
        size,
        np.array([layer.conductivity_w_mk for layer in LAYERS])[layer_of],
        size * np.array([layer.density_kg_m3 * layer.specific_heat_j_kgk for layer in LAYERS])[layer_of],
        size * np.array([layer.perfusion_per_s * blood for layer in LAYERS])[layer_of],
        layer_of,
    )


@dataclass(frozen=True, slots=True)
class Rest:
    """A finger in steady state without contact: layer means and surface, C, and flux into the finger, W/m2."""

    layers_c: tuple[float, float, float]
    surface_c: float
    flux_w_m2: float


@cache
def rest(body: Body) -> Rest:
    """Return the steady state in free motion."""
    tissue = cells(REST_CELLS)
    air_w_m2k = 1.0 / (1.0 / body.air_w_m2k + tissue.half_m2k_w)
    links, blood = tissue.links_w_m2k, tissue.blood_w_m2k
    loss = blood.copy()
    loss[0] += air_w_m2k
    loss[-1] += tissue.deep_w_m2k
    loss[:-1] += links
    loss[1:] += links
    known = blood * body.arterial_c
    known[0] += air_w_m2k * body.air_c
    known[-1] += tissue.deep_w_m2k * body.deep_c
    temperature = np.linalg.solve(np.diag(loss) - np.diag(links, 1) - np.diag(links, -1), known)
    flux = air_w_m2k * (body.air_c - float(temperature[0]))
    means = np.bincount(tissue.layer_of, temperature) / np.array(REST_CELLS)
    first, second, third = means.tolist()
    return Rest((first, second, third), float(temperature[0]) + flux * tissue.half_m2k_w, flux)
