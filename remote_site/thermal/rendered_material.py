"""Which constants of a material are rendered while it is still being identified, and after."""

import numpy as np

from common.scenes.materials import ALIASES, Material, materials
from common.wire.messages import ThermalStatus
from remote_site.thermal.thermal_result import ThermalResult

VAGUE_LN_SD = 0.7
"""An effusivity known no better than this (a factor of two) is not rendered."""
_SHOWN = (ThermalStatus.DECIDING, ThermalStatus.IDENTIFIED, ThermalStatus.AMBIGUOUS, ThermalStatus.UNKNOWN)


def rendered_constants(answer: ThermalResult) -> tuple[float, float, float]:
    """Conductivity, density and specific heat to render; zeros where nothing may be rendered.

    An identified material's own; before that the mean (in logarithms) over the likely ones, made to have the effusivity
    that the running estimate has: the finger feels something from the first moment, and no jump when a name is found.
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
