"""Lists the lumps on a tactile map, and compares them with the nodules of a simulated scene."""

import math
from collections.abc import Sequence
from typing import Any

from common.scenes.tissue import Nodule
from operator_site.console.map.lump_areas import search_lumps
from operator_site.console.map.tactile_map import TactileMap

BESIDE_M = 5e-3
"""Largest distance of a lump from the edge of the nodule that it shows, m."""
_SHOWN = ("x_mm", "y_mm", "length_mm", "width_mm", "stiffness_ratio", "stiffness_ratio_sd", "probability", "at_edge")


def suggested_lumps(surface: TactileMap) -> list[dict[str, Any]]:
    """List the lumps with their outlines, most probable first, as the console suggests them."""
    return search_lumps(surface.stiffness.rows()).lumps


def found_lumps(surface: TactileMap, nodules: Sequence[Nodule] = ()) -> list[dict[str, Any]]:
    """List the lumps, most probable first, then the nodules without a lump.

    A lump shows the nearest nodule that no likelier lump shows, within BESIDE_M of its edge. `nodule`, `true_size_mm`
    and `place_error_mm` are None for a lump that shows none; `probability` is None for a nodule without a lump.
    """
    left, rows = list(nodules), []
    for lump in suggested_lumps(surface):
        row = {name: lump[name] for name in _SHOWN} | dict.fromkeys(("nodule", "true_size_mm", "place_error_mm"))
        near = [(_apart_m(lump, nodule), nodule) for nodule in left]
        near = [(far_m, nodule) for far_m, nodule in near if far_m <= 0.5 * nodule.size_m + BESIDE_M]
        if near:
            far_m, nodule = min(near, key=lambda each: each[0])
            left.remove(nodule)
            row |= _true(nodule) | {"place_error_mm": round(1e3 * far_m, 2)}
        rows.append(row)
    return rows + [dict.fromkeys((*_SHOWN, "place_error_mm")) | _true(nodule) for nodule in left]


def _apart_m(lump: dict[str, Any], nodule: Nodule) -> float:
    return math.dist((1e-3 * lump["x_mm"], 1e-3 * lump["y_mm"]), (nodule.x_m, nodule.y_m))


def _true(nodule: Nodule) -> dict[str, Any]:
    return {"nodule": nodule.name, "true_size_mm": 1e3 * nodule.size_m}
