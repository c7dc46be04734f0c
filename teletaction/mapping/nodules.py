"""Describes each lump of a map as a nodule, and lists where to press next."""

from typing import Any

import numpy as np

from operator_site.palpation.lump_probability import search_of_field
from operator_site.palpation.next_press import next_presses
from operator_site.palpation.nodule_posterior import Presses, Quantity, nodule
from teletaction.mapping.map_recorded import MappedPresses

NEXT = 5
"""Number of places to press next."""
ROUND = 2.0
"""Largest ratio of length to width of a lump that may be a round nodule."""


def nodule_at(mapped: MappedPresses, lump: dict[str, Any], probe_radius_m: float) -> dict[str, Any] | None:
    """Return the posterior of a round nodule at a lump of the map; None for a long lump or with too few presses near.

    A quantity that is not `known` is mostly the prior: one force per place cannot separate depth, diameter and ratio.
    """
    field, lumps = mapped.surface.stiffness.field, mapped.surface.stiffness.lumps
    if field is None or lumps is None or lump["length_mm"] > ROUND * lump["width_mm"]:
        return None
    variance = np.array([sample.variance for sample in mapped.used]) + field.press_sd**2
    presses = Presses(
        1e-3 * mapped.places_mm,
        np.array([sample.value for sample in mapped.used]),
        variance,
        np.array(mapped.indentation_m),
    )
    found = nodule(presses, (1e-3 * lump["x_mm"], 1e-3 * lump["y_mm"]), lumps.spread, probe_radius_m)
    if found is None:
        return None
    return {
        "probability": round(found.probability, 4),
        "x_mm": round(1e3 * found.x_m, 2),
        "y_mm": round(1e3 * found.y_m, 2),
        "place_sd_mm": round(1e3 * found.place_sd_m, 2),
        "depth_mm": _rounded(found.top, 1e3),
        "diameter_mm": _rounded(found.diameter, 1e3),
        "ratio": _rounded(found.ratio, 1.0),
    }


def next_mm(mapped: MappedPresses) -> list[list[float]]:
    """Return the places within the bounds of the presses that are expected to say most, (NEXT, 2), mm."""
    field = mapped.surface.stiffness.field
    if field is None:
        return []
    found_m = next_presses(search_of_field(field), field.places_m.min(axis=0), field.places_m.max(axis=0), NEXT)
    return (1e3 * found_m).round(1).tolist()  # type: ignore[no-any-return]


def _rounded(quantity: Quantity, unit: float) -> dict[str, Any]:
    """Return a quantity in another unit, for a file."""
    values = {name: round(unit * getattr(quantity, name), 2) for name in ("middle", "low", "high")}
    return {**values, "known": quantity.known}
