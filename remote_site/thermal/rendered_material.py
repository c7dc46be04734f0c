"""Selects the constants of a material that are rendered during and after its identification."""

import numpy as np

from common.scenes.materials import ALIASES, Material, materials
from common.wire.messages import ThermalStatus
from remote_site.thermal.thermal_result import ThermalResult

VAGUE_LN_SD = 0.7
"""Largest standard deviation of ln effusivity that is rendered (a factor of two)."""
_SHOWN = (ThermalStatus.DECIDING, ThermalStatus.IDENTIFIED, ThermalStatus.AMBIGUOUS, ThermalStatus.UNKNOWN)


def rendered_constants(answer: ThermalResult) -> tuple[float, float, float]:
    """Return conductivity, W/mK, density, kg/m3, and specific heat, J/kgK, to render; zeros if nothing may be rendered.

    An identified material has its own constants. Before that, the constants are the mean (in logarithms) over the
    likely materials, scaled to the effusivity of the running estimate. The finger therefore feels something from the
    first moment, and no jump when the material is identified.
    """
    if answer.status not in _SHOWN or answer.effusivity is None or answer.effusivity_ln_sd is None:
        return 0.0, 0.0, 0.0
    known = materials()
    if answer.material is not None:
        entry = known.get(ALIASES.get(answer.material, answer.material))
        return (0.0, 0.0, 0.0) if entry is None else _constants(entry)
    if answer.effusivity_ln_sd > VAGUE_LN_SD:
        return 0.0, 0.0, 0.0
    rows, weights = [], []
    for name, probability in answer.candidates.items():
        entry = known.get(ALIASES.get(name, name))
        if entry is not None:
            rows.append(_constants(entry))
            weights.append(max(probability, 1e-6))
    if not rows:
        return 0.0, 0.0, 0.0
    conductivity, density, heat = np.exp(np.average(np.log(np.array(rows)), axis=0, weights=weights))
    wanted = answer.effusivity / float(np.sqrt(conductivity * density * heat))
    return float(conductivity) * wanted, float(density), float(heat) * wanted


def _constants(entry: Material) -> tuple[float, float, float]:
    return entry.conductivity_w_mk, entry.density_kg_m3, entry.specific_heat_j_kgk
