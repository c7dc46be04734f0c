"""Computes the felt share of a surface and the largest distance between neighbouring lines."""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import binary_closing, distance_transform_edt

from operator_site.console.map.map_layer import CELL_M, REACH_M
from operator_site.console.map.map_tiles import MapPicture

OUTLINE_M = 12e-3
"""Half the width of the widest gap that still belongs to the explored area, m."""
LINES_M = 2.0 * REACH_M
"""Largest distance of neighbouring lines without a gap between them, m."""


@dataclass(frozen=True, slots=True)
class Coverage:
    """Coverage of a surface: areas in m2, and the largest distance of neighbouring lines in m, at least LINES_M."""

    felt_m2: float
    explored_m2: float
    lines_m: float

    @property
    def share(self) -> float:
        """Share of the explored area that was felt, 0..1."""
        return self.felt_m2 / self.explored_m2

    @property
    def gaps(self) -> bool:
        """True if neighbouring lines are too far apart."""
        return self.lines_m > LINES_M + CELL_M


def coverage(shown: MapPicture) -> Coverage:
    """Compute the coverage of one quantity."""
    margin = round(OUTLINE_M / CELL_M)
    felt = ~np.isnan(shown.value) if shown.felt is None else shown.felt
    known = np.pad(felt, 2 * margin)
    disc = np.hypot(*np.ogrid[-margin : margin + 1, -margin : margin + 1]) <= margin
    explored = binary_closing(known, structure=disc) | known
    inside = distance_transform_edt(~known)[explored & ~known]
    widest_m = CELL_M * (2.0 * float(inside.max()) - 1.0) if inside.size else 0.0
    return Coverage(float(known.sum()) * CELL_M**2, float(explored.sum()) * CELL_M**2, LINES_M + widest_m)
