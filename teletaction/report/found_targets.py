"""Finds targets on a tactile map as a reader of the picture would, and compares them with a simulated scene.

The comparison gives the errors of each target's place and value.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.ndimage import binary_dilation, label

from common.scenes.scene import Scene, SceneObject
from operator_site.console.map.map_layer import CELL_M
from operator_site.console.map.map_tiles import picture
from operator_site.console.map.tactile_map import LOGARITHMIC, Measured, TactileMap

STANDS_OUT = 0.5
"""Share of the largest difference from the median above which a cell belongs to the target."""
MOST_DIFFERENT = 0.99
"""Quantile of the differences that counts as the largest one."""
GAP_CELLS = 4
"""Cells by which a target is widened on each side. Gaps up to twice this width do not divide it."""
CONFIDENT = 1
"""Lowest confidence of the cells that are searched."""


@dataclass(frozen=True, slots=True)
class Found:
    """Centre of a target found on the map, m."""

    x_m: float
    y_m: float


def find_target(tactile_map: TactileMap, quantity: str, *, lowest: bool = False) -> Found | None:
    """Find the connected area with the largest total excess over the median; None if nothing was felt with confidence.

    The place is the centre of the target's cells, weighted by their excess. With `lowest`, the excess is that of the
    median over the cells.
    """
    shown = picture(tactile_map, quantity)
    if shown is None:
        return None
    sure = shown.confidence >= CONFIDENT
    if shown.felt is not None:
        sure &= shown.felt
    if not sure.any():
        return None
    value = np.log(shown.value) if quantity in LOGARITHMIC else shown.value
    above = np.where(sure, value - np.median(value[sure]), 0.0) * (-1.0 if lowest else 1.0)
    hot = above > STANDS_OUT * np.quantile(above[sure], MOST_DIFFERENT)
    places, count = label(binary_dilation(hot, iterations=GAP_CELLS))
    weights = [np.where((places == number) & hot, above, 0.0) for number in range(1, count + 1)]
    if not weights:
        return None
    weight = max(weights, key=np.sum)
    rows, columns = np.nonzero(weight)
    heavy = weight[rows, columns]
    x_m = shown.left_m + CELL_M * (float(np.average(columns, weights=heavy)) + 0.5)
    y_m = shown.near_m + CELL_M * (float(np.average(rows, weights=heavy)) + 0.5)
    return Found(x_m, y_m)


def value_near(tactile_map: TactileMap, quantity: str, found: Found) -> Measured:
    """Return the combined value of the samples within 3 mm of the sample nearest to a target."""
    samples = [sample for tile in tactile_map.layers[quantity].tiles.values() for sample in tile.samples.values()]
    nearest = min(samples, key=lambda sample: math.dist((found.x_m, found.y_m), (sample.x_m, sample.y_m)))
    here: Measured = getattr(tactile_map.at(nearest.x_m, nearest.y_m), quantity)
    return here


def found_targets(scene: Scene, tactile_map: TactileMap) -> list[dict[str, Any]]:
    """List for each target of a scene its place and value on the map, and the true ones."""
    return [
        judged(
            thing,
            tactile_map,
            find_target(tactile_map, thing.target, lowest=_is_low(scene, thing, thing.target))
            if _was_felt(thing, thing.target, tactile_map)
            else None,
        )
        for thing in scene.objects
        if thing.target is not None
    ]


def judged(thing: SceneObject, tactile_map: TactileMap, found: Found | None) -> dict[str, Any]:
    """Compare a target, whose `target` is set, with its place and value on the map; `found` is None without one."""
    quantity = thing.target
    assert quantity is not None
    row: dict[str, Any] = {"target": thing.name, "quantity": quantity, "place_error_mm": None, "value": None}
    if found is None:
        return row
    here, around = value_near(tactile_map, quantity, found), getattr(tactile_map.around(found.x_m, found.y_m), quantity)
    true_value = _true_value(thing, quantity)
    return row | {
        "place_error_mm": 1e3 * math.dist((found.x_m, found.y_m), thing.middle_m),
        "x_mm": 1e3 * found.x_m,
        "y_mm": 1e3 * found.y_m,
        "value": here.value,
        "sd": here.sd,
        "touches": here.touches,
        "true_value": true_value,
        "error": None if true_value is None else here.value - true_value,
        "around": None if around is None else around.value,
    }


def _true_value(thing: SceneObject, quantity: str) -> float | None:
    """Return a quantity of an object; None if unknown."""
    # A simulated surface has no true roughness in the sensor's unit.
    return {"temperature": thing.absolute_c, "stiffness": thing.stiffness}.get(quantity)


def _is_low(scene: Scene, thing: SceneObject, quantity: str) -> bool:
    """Return whether a target has less of its quantity than the other objects, such as a cold spot."""
    own = _true_value(thing, quantity)
    others = [
        value for other in scene.objects if other is not thing and (value := _true_value(other, quantity)) is not None
    ]
    return own is not None and bool(others) and own < float(np.median(others))


def _was_felt(thing: SceneObject, quantity: str, tactile_map: TactileMap) -> bool:
    """Return True if the quantity was felt anywhere on a target. Unexplored targets cannot be found."""
    radius_m = math.dist(thing.middle_m, (thing.x_m, thing.y_range_m[0]))
    return any(
        thing.covers(sample.x_m, sample.y_m) for sample in tactile_map.layers[quantity].near(*thing.middle_m, radius_m)
    )
