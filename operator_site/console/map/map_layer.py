"""Maps the samples of one quantity onto cells of 1 mm on the bench, in tiles that exist only where it was measured.

A cell's value is the mean of the samples around it, weighted by a Gaussian of width KERNEL_M and by their precision.
Where samples disagree by more than their variances allow, the standard deviation grows by the Birge ratio (1932).
"""

import math
from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from operator_site.console.map.finger_samples import Sample

Floats = NDArray[np.float64]
CELL_M = 1e-3
"""Side of a cell, m."""
TILE = 32
"""Cells along each side of a tile."""
KERNEL_M = 1.5e-3
"""Standard deviation of the Gaussian kernel of a sample, m."""
REACH_M = 3e-3
"""Largest distance from a sample at which a cell counts as explored, m."""
MOST_SAMPLES = 2000
"""Maximum number of samples of a tile; the oldest are dropped, but remain in the sums of the cells."""
LEAST_FREEDOM = 0.25
"""Smallest number of degrees of freedom for the disagreement of the samples in a cell."""


class Tile:
    """Sums over TILE x TILE cells, row by row from the near edge.

    Attributes:
        revision: revision of the map at the newest change of this tile.
        samples: samples whose place lies in this tile.
        felt_cells: number of cells with a sample in reach.
    """

    __slots__ = ("_count", "_sums", "_taken", "felt_cells", "revision", "samples")

    def __init__(self) -> None:
        self.revision = 0
        self.samples: dict[tuple[int, int, int], Sample] = {}
        self._taken: dict[tuple[int, int, int], int] = {}
        """Revision of the map when it took each sample."""
        self.felt_cells = 0
        self._count = np.zeros((TILE, TILE), dtype=np.int32)
        self._sums = np.zeros((4, TILE, TILE))
        """Sums of k, k w, k w v and k w v^2, with the kernel k, precisions w and values v."""

    def add(self, at: tuple[slice, slice], kernel: Floats, precision: float, value: float, sign: int) -> None:
        """Add a sample to the cells `at` with `sign` 1, or remove it with `sign` -1."""
        weight = precision * kernel
        self._sums[:, at[0], at[1]] += sign * np.stack((kernel, weight, value * weight, value * value * weight))
        self._count[at] += sign * (kernel > 0.0)
        self._sums[:, self._count == 0] = 0.0  # clear the rounding residue
        self.felt_cells = int(np.count_nonzero(self._count))

    def keep(self, sample: Sample, revision: int) -> None:
        """Keep a sample, and forget the oldest one of too many."""
        self.samples[sample.key], self._taken[sample.key] = sample, revision
        if len(self.samples) > MOST_SAMPLES:
            self.forget(next(iter(self.samples)))

    def forget(self, key: tuple[int, int, int]) -> None:
        """Forget a sample if it is here; the cells do not change."""
        self.samples.pop(key, None)
        self._taken.pop(key, None)

    def after(self, revision: int) -> Iterator[tuple[int, Sample]]:
        """Yield the samples that were taken after a revision, newest first, each with its own revision."""
        for sample in reversed(self.samples.values()):
            if self._taken[sample.key] <= revision:
                break
            yield self._taken[sample.key], sample

    @property
    def explored(self) -> NDArray[np.bool_]:
        """Cells with a sample in reach, (TILE, TILE)."""
        return self._count > 0

    @property
    def kernel(self) -> Floats:
        """Sum of the kernels in each cell; 1 for one sample in its middle."""
        kernel: Floats = self._sums[0]
        return kernel

    def mean(self) -> tuple[Floats, Floats]:
        """Return value and standard deviation of each cell, (TILE, TILE); NaN where it is unexplored."""
        kernel, precision, first, second = np.where(self.explored, self._sums, np.nan)
        value = first / precision
        disagreement = (second - first * value) / np.maximum(kernel - 1.0, LEAST_FREEDOM)
        return value, np.sqrt(np.maximum(1.0, disagreement) / precision)


class Layer:
    """Tiles of one quantity.

    Attributes:
        tiles: by their column and row on the bench.
        middle: offset that is subtracted from the values before squares are summed, in the quantity's unit; a value
            near it keeps its digits.
    """

    def __init__(self, middle: float = 0.0) -> None:
        self.tiles: dict[tuple[int, int], Tile] = {}
        self.middle = middle
        self._newest: dict[int, Sample] = {}

    def mean(self, place: tuple[int, int]) -> tuple[Floats, Floats]:
        """Return value and standard deviation of a tile's cells, (TILE, TILE) each; NaN where none is shown."""
        return self.tiles[place].mean()

    @property
    def felt_cells(self) -> int:
        """Number of cells with a sample in reach."""
        return sum(tile.felt_cells for tile in self.tiles.values())

    def shows(self, place: tuple[int, int]) -> bool:
        """Return whether a tile has a cell with a value."""
        return self.tiles[place].felt_cells > 0

    def put(self, sample: Sample, revision: int) -> None:
        """Add a sample; it replaces the newest sample of its finger if that has the same key."""
        before = self._newest.get(sample.finger)
        if before is not None and before.key == sample.key:
            self._paint(before, -1, revision)
            self.tiles[tile_of(before.x_m, before.y_m)].forget(before.key)
        self._newest[sample.finger] = sample
        self._paint(sample, 1, revision)
        self.tiles[tile_of(sample.x_m, sample.y_m)].keep(sample, revision)

    def drop(self, finger: int, key: tuple[int, int, int], revision: int) -> None:
        """Remove the newest sample of a finger if it has this key."""
        before = self._newest.get(finger)
        if before is not None and before.key == key:
            self._paint(before, -1, revision)
            self.tiles[tile_of(before.x_m, before.y_m)].forget(key)
            del self._newest[finger]

    def near(self, x_m: float, y_m: float, radius_m: float) -> Iterator[Sample]:
        """Yield the samples within a radius of a place, m."""
        low, high = tile_of(x_m - radius_m, y_m - radius_m), tile_of(x_m + radius_m, y_m + radius_m)
        for column in range(low[0], high[0] + 1):
            for row in range(low[1], high[1] + 1):
                tile = self.tiles.get((column, row))
                for sample in () if tile is None else tile.samples.values():
                    if math.dist((x_m, y_m), (sample.x_m, sample.y_m)) <= radius_m:
                        yield sample

    def _paint(self, sample: Sample, sign: int, revision: int) -> None:
        column, across = _kernel(sample.x_m)
        row, along = _kernel(sample.y_m)
        kernel = np.outer(along, across)
        kernel[kernel < math.exp(-0.5 * (REACH_M / KERNEL_M) ** 2)] = 0.0
        precision, value = 1.0 / sample.variance, sample.value - self.middle
        for tile_column in range(column // TILE, (column + len(across) - 1) // TILE + 1):
            for tile_row in range(row // TILE, (row + len(along) - 1) // TILE + 1):
                x0, x1 = max(column, TILE * tile_column), min(column + len(across), TILE * (tile_column + 1))
                y0, y1 = max(row, TILE * tile_row), min(row + len(along), TILE * (tile_row + 1))
                part = kernel[y0 - row : y1 - row, x0 - column : x1 - column]
                if not part.any():
                    continue
                tile = self.tiles.setdefault((tile_column, tile_row), Tile())
                tile.revision = revision
                at = (
                    slice(y0 - TILE * tile_row, y1 - TILE * tile_row),
                    slice(x0 - TILE * tile_column, x1 - TILE * tile_column),
                )
                tile.add(at, part, precision, value, sign)
        self.tiles.setdefault(tile_of(sample.x_m, sample.y_m), Tile())


def tile_of(x_m: float, y_m: float) -> tuple[int, int]:
    """Return column and row of the tile that holds a place on the bench."""
    return math.floor(x_m / CELL_M) // TILE, math.floor(y_m / CELL_M) // TILE


def _kernel(place_m: float) -> tuple[int, Floats]:
    """Return the first cell along one axis that a sample reaches, and the kernel at the middle of each reached cell."""
    first, last = math.floor((place_m - REACH_M) / CELL_M), math.floor((place_m + REACH_M) / CELL_M)
    away_m = (np.arange(first, last + 1) + 0.5) * CELL_M - place_m
    return first, np.exp(-0.5 * (away_m / KERNEL_M) ** 2)
