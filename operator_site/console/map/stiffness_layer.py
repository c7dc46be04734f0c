"""Maps stiffness by a field whose uncertainty grows away from the samples, and computes lump probabilities from it.

The field belongs to all samples. It is made again when cells are read after a change.
"""

import math

import numpy as np

from operator_site.console.map.finger_samples import Sample
from operator_site.console.map.map_layer import CELL_M, TILE, Floats, Layer, Tile, tile_of
from operator_site.palpation.lump_probability import FEWEST_PLACES, LumpMap
from operator_site.palpation.press_depth import at_one_depth
from operator_site.palpation.stiffness_field import StiffnessField

SHOWN_M = 10e-3
"""Largest distance from a sample at which a cell shows its stiffness, m."""
_EVERY = 2
"""Distance of the places where the field is computed, cells; the cells between are interpolated."""
_PLACES = np.arange(0, TILE + 1, _EVERY)
_BETWEEN = np.maximum(0.0, 1.0 - np.abs(np.arange(TILE)[:, None] + 0.5 - _PLACES) / _EVERY)
"""Weights of the computed places along one axis for each cell of a tile, (TILE, TILE / _EVERY + 1)."""


class StiffnessLayer(Layer):
    """Layer of ln stiffness."""

    def __init__(self) -> None:
        super().__init__()
        self._field: StiffnessField | None = None
        self._lumps: LumpMap | None = None
        self._means: dict[tuple[int, int], tuple[Floats, Floats]] = {}
        """Tiles of the field that were read since the last change."""

    def __getstate__(self) -> dict[str, object]:
        """Return the layer without the field, which the samples determine."""
        return self.__dict__ | {"_field": None, "_lumps": None, "_means": {}}

    @property
    def field(self) -> StiffnessField | None:
        """The field of the present samples; None without one."""
        if self._field is None:
            every = self.rows()
            if len(every):
                self._field = field_of_presses(every)
        return self._field

    def rows(self) -> Floats:
        """Return place, m, ln stiffness, its variance, and force, N, of each sample, (n, 5); force 0 is not known."""
        samples = (sample for tile in self.tiles.values() for sample in tile.samples.values())
        return np.array([(s.x_m, s.y_m, s.value, s.variance, s.force_n) for s in samples]).reshape(-1, 5)

    @property
    def lumps(self) -> LumpMap | None:
        """Lump probabilities of the present samples; None with too few places."""
        field = self.field
        if self._lumps is None and field is not None and len(field.places_m) >= FEWEST_PLACES:
            self._lumps = LumpMap(field)
        return self._lumps

    def lump_at(self, x_m: float, y_m: float) -> float | None:
        """Return the probability that a place belongs to a lump, 0..1; None with too few places."""
        lumps = self.lumps
        return None if lumps is None else float(lumps.probability([(x_m, y_m)])[0])

    def mean(self, place: tuple[int, int]) -> tuple[Floats, Floats]:
        """Return ln stiffness and its standard deviation in a tile's cells; NaN farther than SHOWN_M from a sample."""
        if place not in self._means:
            self._means[place] = self._mean(place)
        return self._means[place]

    def _mean(self, place: tuple[int, int]) -> tuple[Floats, Floats]:
        field = self.field
        if field is None:
            return np.full((TILE, TILE), np.nan), np.full((TILE, TILE), np.nan)
        x_m, y_m = np.meshgrid(*(CELL_M * (TILE * number + _PLACES) for number in place))
        places_m = np.column_stack([x_m.ravel(), y_m.ravel()])
        value, sd = field.at(places_m)
        shown = _cells(field.nearest_m(places_m)) <= SHOWN_M
        return np.where(shown, _cells(value), np.nan), np.where(shown, _cells(sd), np.nan)

    def shows(self, place: tuple[int, int]) -> bool:
        """Return whether a tile has a cell with a value."""
        return bool(np.isfinite(self.mean(place)[0]).any())

    def _paint(self, sample: Sample, sign: int, revision: int) -> None:
        super()._paint(sample, sign, revision)
        self._field, self._lumps, self._means = None, None, {}
        low = tile_of(sample.x_m - SHOWN_M, sample.y_m - SHOWN_M)
        high = tile_of(sample.x_m + SHOWN_M, sample.y_m + SHOWN_M)
        for column in range(low[0], high[0] + 1):
            for row in range(low[1], high[1] + 1):
                self.tiles.setdefault((column, row), Tile()).revision = revision


def field_of_presses(presses: Floats) -> StiffnessField:
    """Return the field of presses, `StiffnessLayer.rows`, at their median depth."""
    rows = at_one_depth(presses)
    return StiffnessField(rows[:, :2], rows[:, 2], rows[:, 3])


def _cells(computed: Floats) -> Floats:
    """Interpolate the computed places of a tile to its cells, (TILE, TILE)."""
    side = math.isqrt(computed.size)
    return np.asarray(_BETWEEN @ computed.reshape(side, side) @ _BETWEEN.T)
