"""Computes stiffness and lump probability over the cells of a mapped area, and lists its lumps.

A console searches its growing map for them, and for the next place to press.
"""

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation, label
from scipy.spatial import ConvexHull, Delaunay, QhullError

from operator_site.console.map.map_layer import CELL_M
from operator_site.console.map.stiffness_layer import SHOWN_M, field_of_presses
from operator_site.palpation.lump_probability import FEWEST_PLACES, LumpMap, lumps_of_field, search_of_field
from operator_site.palpation.next_press import next_presses
from operator_site.palpation.nodule_search import NoduleSearch
from operator_site.palpation.stiffness_field import StiffnessField, lattice

Floats = NDArray[np.float64]
LUMP = 0.5
"""Smallest lump probability of a cell inside an outline."""
FEWEST_CELLS = 4
"""Smallest number of cells of a listed lump."""
EDGE_CELLS = round(SHOWN_M / CELL_M)
"""Distance from the edge of the stated cells at which a lump is at the edge, cells: no press lies beyond."""
_AT_ONCE = 4096


class Cells(NamedTuple):
    """Cells of 1 mm between and around the presses; rows from the near edge, NaN where nothing is stated.

    Attributes:
        x_mm, y_mm: middles of columns and rows, mm.
        value, sd: stiffness and its standard deviation, (rows, columns), N/m.
        lump: lump probability, (rows, columns), 0..1; NaN with too few places.
    """

    x_mm: Floats
    y_mm: Floats
    value: Floats
    sd: Floats
    lump: Floats


class Searched(NamedTuple):
    """Result of a search: lumps, see `lumps_in`, and the next place to press, mm, None if unknown."""

    lumps: list[dict[str, Any]]
    next_mm: tuple[float, float] | None


NOTHING = Searched([], None)


def search_lumps(rows: Floats) -> Searched:
    """Search the presses of a map, `StiffnessLayer.rows`. Raises ValueError for rows that are none."""
    field = field_of_presses(rows) if len(rows) else None
    if field is None or len(field.places_m) < FEWEST_PLACES:
        return NOTHING
    search = search_of_field(field)
    return Searched(lumps_in(cells(field, LumpMap(field, search), stiffness=False), field), next_press_mm(search))


def next_press_mm(search: NoduleSearch) -> tuple[float, float]:
    """Return the place between the presses of a search where the next one says most about nodules, mm."""
    places_m = search.presses.places_m
    ((x_m, y_m),) = next_presses(search, places_m.min(axis=0), places_m.max(axis=0)).tolist()
    return round(1e3 * x_m, 1), round(1e3 * y_m, 1)


def searched(field: StiffnessField) -> LumpMap | None:
    """Return the lump probabilities of a field with a search for nodules; None with too few places."""
    return lumps_of_field(field) if len(field.places_m) >= FEWEST_PLACES else None


def cells(field: StiffnessField, lumps: LumpMap | None, stiffness: bool = True) -> Cells:
    """Return the cells of a field, and of its lump probabilities if there are any; `stiffness` False leaves it NaN."""
    low, high = field.places_m.min(axis=0) - SHOWN_M, field.places_m.max(axis=0) + SHOWN_M
    places_m = lattice(low.tolist(), high.tolist(), CELL_M)
    columns = len(np.unique(np.round(places_m[:, 0] / CELL_M)))
    found, hull = np.full((3, len(places_m)), np.nan), _hull(field)
    for part in np.array_split(np.arange(len(places_m)), math.ceil(len(places_m) / _AT_ONCE)):
        near = field.nearest_m(places_m[part]) <= SHOWN_M
        mine = part[near if hull is None else near | (hull.find_simplex(places_m[part]) >= 0)]
        if not len(mine):
            continue
        if stiffness:
            mean, sd = field.at(places_m[mine])
            found[0, mine], found[1, mine] = np.exp(mean), np.exp(mean) * sd
        if lumps is not None:
            found[2, mine] = lumps.probability(places_m[mine])
    value, sd, lump = (row.reshape(-1, columns) for row in found)
    return Cells(1e3 * places_m[:columns, 0], 1e3 * places_m[::columns, 1], value, sd, lump)


def lumps_in(shown: Cells, field: StiffnessField) -> list[dict[str, Any]]:
    """List the connected areas of at least LUMP, most probable first: place, size, ratio, probability, and outline.

    `at_edge` marks an area that reaches the edge of the stated cells: its surroundings are unknown on one side.
    """
    outside = np.pad(~np.isfinite(shown.lump), 1, constant_values=True)
    edge = binary_dilation(outside, iterations=EDGE_CELLS)[1:-1, 1:-1]
    areas, number = label(np.nan_to_num(shown.lump) >= LUMP, structure=np.ones((3, 3)))
    found = []
    for one in range(1, number + 1):
        rows, columns = np.nonzero(areas == one)
        if len(rows) < FEWEST_CELLS:
            continue
        places_mm = np.column_stack([shown.x_mm[columns], shown.y_mm[rows]])
        excess = field.excess(1e-3 * places_mm)
        peak = int(excess.mean.argmax())
        ratio = math.exp(float(excess.mean[peak]))
        # A uniform ellipse has a variance of a sixteenth of its squared diameter along each axis.
        length, width = 4.0 * np.sqrt(np.maximum(np.linalg.eigvalsh(np.cov(places_mm.T))[::-1], 1.0 / 12.0))
        corners = _outline(places_mm)
        found.append(
            {
                "x_mm": round(float(places_mm[:, 0].mean()), 2),
                "y_mm": round(float(places_mm[:, 1].mean()), 2),
                "area_mm2": len(rows),
                "length_mm": round(float(length), 1),
                "width_mm": round(float(width), 1),
                "stiffness_ratio": round(ratio, 3),
                "stiffness_ratio_sd": round(ratio * float(excess.sd[peak]), 3),
                "probability": round(float(np.nanmax(shown.lump[areas == one])), 4),
                "at_edge": bool(edge[areas == one].any()),
                "outline_mm": corners.round(2).tolist(),
            }
        )
    return sorted(found, key=lambda lump: -float(str(lump["probability"])))


def _hull(field: StiffnessField) -> Delaunay | None:
    """Return the triangles between the presses; None for fewer than three presses, or presses on a line."""
    try:
        return Delaunay(field.places_m)
    except (QhullError, ValueError):
        return None


def _outline(places_mm: Floats) -> Floats:
    """Return the corners of the convex hull of cells, counter-clockwise, (n, 2), mm."""
    half = 0.5e3 * CELL_M
    corners = np.concatenate([places_mm + np.array([dx, dy]) for dx in (-half, half) for dy in (-half, half)])
    return np.asarray(corners[ConvexHull(corners).vertices])
