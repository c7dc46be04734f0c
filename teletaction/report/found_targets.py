"""Where a target lies on a map of what was felt, and what its value is: read as a person would read the picture.

Of a simulated scene it is known what is true: how far beside its place each target is found, and how wrong its value.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.ndimage import binary_dilation, label

from common.scenes.scene import Scene, SceneObject
from operator_site.console.map.map_layer import CELL_M
from operator_site.console.map.map_tiles import picture
from operator_site.console.map.tactile_map import LOGARITHMIC, Felt, TactileMap

STANDS_OUT = 0.5
"""Cells that differ by this share of what the most different do belong to the target."""
MOST_DIFFERENT = 0.99
GAP_CELLS = 4
"""Twice so many cells without a touch do not divide a target."""
CONFIDENT = 1


@dataclass(frozen=True, slots=True)
class Found:
    """The middle of a target, m."""

    x_m: float
    y_m: float


def find_highest(felt: TactileMap, quantity: str) -> Found | None:
    """The one place where most of the quantity is felt more than around it; None where nothing was felt.

    The middle of the cells that stand out, weighted by how much they do.
    """
    shown = picture(felt, quantity)
    if shown is None:
        return None
    sure = shown.confidence >= CONFIDENT
    if not sure.any():
        return None
    value = np.log(shown.value) if quantity in LOGARITHMIC else shown.value
    above = np.where(sure, value - np.median(value[sure]), 0.0)
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


def value_near(felt: TactileMap, quantity: str, found: Found) -> Felt:
    """What the samples within 3 mm of the one nearest to a target say together."""
    samples = [sample for tile in felt.layers[quantity].tiles.values() for sample in tile.samples.values()]
    nearest = min(samples, key=lambda sample: math.dist((found.x_m, found.y_m), (sample.x_m, sample.y_m)))
    here: Felt = getattr(felt.at(nearest.x_m, nearest.y_m), quantity)
    return here


def found_targets(scene: Scene, felt: TactileMap) -> list[dict[str, Any]]:
    """What the map shows of each target of a scene, and what is true."""
    return [
        judged(thing, felt, find_highest(felt, thing.target) if _was_felt(thing, thing.target, felt) else None)
        for thing in scene.objects
        if thing.target is not None
    ]


def judged(thing: SceneObject, felt: TactileMap, found: Found | None) -> dict[str, Any]:
    """A target beside what was found of it: its place, and the value of its quantity there.

    Args:
        thing: the target.
        felt: the map.
        found: where it was found; None where it was not.
    """
    quantity = thing.target
    assert quantity is not None
    row: dict[str, Any] = {"target": thing.name, "quantity": quantity, "place_error_mm": None, "value": None}
    if found is None:
        return row
    here, around = value_near(felt, quantity, found), getattr(felt.around(found.x_m, found.y_m), quantity)
    # Nobody has measured a simulated surface's roughness in the unit of the sensor.
    true_value = {"temperature": thing.absolute_c, "stiffness": thing.stiffness}.get(quantity)
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


def _was_felt(thing: SceneObject, quantity: str, felt: TactileMap) -> bool:
    """Whether a finger felt the quantity anywhere on a target: what was not explored cannot be found."""
    radius_m = math.dist(thing.middle_m, (thing.x_m, thing.y_range_m[0]))
    return any(thing.covers(sample.x_m, sample.y_m) for sample in felt.layers[quantity].near(*thing.middle_m, radius_m))
