"""Encodes tiles of the map for a page: a value and its spread for each of 32 x 32 cells.

Little endian: u16 magic, u8 version, u8 kind, u8 quantity, u8 column and row in the frame, u8 0, u32 revision, 1024 u16
values, 1024 u8 spreads, row by row from the near edge. Layout and ranges: docs/protocols.md.
"""

import math
import struct
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from operator_site.console.map.map_layer import CELL_M, TILE, Tile
from operator_site.console.map.tactile_map import COLUMNS, LOGARITHMIC, QUANTITIES, TactileMap

MAGIC, VERSION, KIND = 0x7EA7, 1, 2
RANGES = {"temperature": (-10.0, 60.0), "roughness": (0.001, 10.0), "stiffness": (50.0, 20_000.0)}
"""Quantities at the values 0 and HIGHEST of a tile, C, V and N/m; LOGARITHMIC quantities have logarithmic steps.

A material's value is its index in the map's list of materials.
"""
UNEXPLORED = 65535
"""Value of a cell where nothing was measured."""
HIGHEST = 65534
"""Largest value of a cell with a value."""
CONFIDENT_SD = {"temperature": 0.5, "roughness": 0.15, "stiffness": 0.20}
"""Largest standard deviation of confidence 2, K or share of the value; half of it is confidence 3, twice is 1."""
WORST = 127
"""Largest spread of a cell, also used for an unknown value."""
STEEP = 128
"""Flag in the spread of a cell on a slope of 45 degrees or more, which the map shows too narrow."""
OCTAVE, MIDDLE = 8, 64
"""Scale of the spread: MIDDLE is a standard deviation of CONFIDENT_SD, and each OCTAVE more doubles it.

A material's spread is the share of the touches with another identified material, in percent.
"""
CONFIDENT = (MIDDLE + OCTAVE, MIDDLE, MIDDLE - OCTAVE)
"""Largest spread of the confidences 1, 2, 3 of a measured quantity."""
CONFIDENT_MATERIAL = (50, 10, 2)
"""Largest spread of the confidences 1, 2, 3 of a material, percent."""
_HEAD = struct.Struct("<HBBBBBBI")
_TILES = COLUMNS // TILE
_ROUNDING = 1e-6
Cells = tuple[NDArray[np.uint16], NDArray[np.uint8]]
"""Values and spreads of a tile, (32, 32) each."""


class MapTile(NamedTuple):
    """One tile: `value` (32, 32) u16, `spread` (32, 32) u8 with flag STEEP, `column` and `row` in the frame, 0..7."""

    quantity: str
    column: int
    row: int
    revision: int
    value: NDArray[np.uint16]
    spread: NDArray[np.uint8]

    @property
    def confidence(self) -> NDArray[np.uint8]:
        """Confidence of each cell, (32, 32), 0..3."""
        return confidence(self.quantity, self.spread)

    def encode(self) -> bytes:
        """Return the message."""
        number = QUANTITIES.index(self.quantity)
        head = _HEAD.pack(MAGIC, VERSION, KIND, number, self.column, self.row, 0, self.revision & 0xFFFFFFFF)
        return head + self.value.astype("<u2").tobytes() + self.spread.astype(np.uint8).tobytes()


def changed(surface: TactileMap, quantity: str, since: int) -> list[MapTile]:
    """Return the frame's tiles of a quantity that changed after revision `since`, oldest change first.

    A move of the frame changes all its tiles, because each then shows another place.

    Raises:
        ValueError: the quantity is unknown.
    """
    if quantity not in QUANTITIES:
        raise ValueError(f"no quantity {quantity!r}; there are {', '.join(QUANTITIES)}")
    left_m, near_m = surface.frame
    corner = round(left_m / (TILE * CELL_M)), round(near_m / (TILE * CELL_M))
    moved = surface.framed if surface.framed > since else 0
    revisions: dict[tuple[int, int], int] = {}
    for layer in surface.layers_of(quantity):
        for place, tile in layer.tiles.items():
            revision = max(tile.revision, moved, surface.steep_revision(place), revisions.get(place, 0))
            column, row = place[0] - corner[0], place[1] - corner[1]
            if revision > since and 0 <= column < _TILES and 0 <= row < _TILES:
                revisions[place] = revision
    return [
        MapTile(quantity, place[0] - corner[0], place[1] - corner[1], revision, *cells(surface, quantity, place))
        for place, revision in sorted(revisions.items(), key=lambda item: (item[1], item[0]))
    ]


def cells(surface: TactileMap, quantity: str, place: tuple[int, int]) -> Cells:
    """Return values and spreads of the tile at a column and row of the bench."""
    value, spread = _materials(surface, place) if quantity == "material" else _measured(surface, quantity, place)
    return value, np.where((value != UNEXPLORED) & surface.steep(place), spread | STEEP, spread).astype(np.uint8)


def confidence(quantity: str, spread: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return the confidence of cells with these spreads, 0..3."""
    largest = np.array(CONFIDENT_MATERIAL if quantity == "material" else CONFIDENT)
    found: NDArray[np.uint8] = ((spread & ~np.uint8(STEEP))[..., None] <= largest).sum(axis=-1).astype(np.uint8)
    return found


def _measured(surface: TactileMap, quantity: str, place: tuple[int, int]) -> Cells:
    layer = surface.layers[quantity]
    value, sd = layer.mean(place)
    known = np.isfinite(value)
    low, high = (math.log(end) if quantity in LOGARITHMIC else end - layer.middle for end in RANGES[quantity])
    share = np.clip((np.where(known, value, low) - low) / (high - low), 0.0, 1.0)
    spread = _spread(quantity, np.where(known, sd, np.inf))
    return np.where(known, np.round(HIGHEST * share), UNEXPLORED).astype(np.uint16), spread


def confidence_of(quantity: str, sd: NDArray[np.float64]) -> NDArray[np.uint8]:
    """Return the confidence of standard deviations, 0..3, in K or as a share of the value; infinite: nothing known."""
    return confidence(quantity, _spread(quantity, sd))


def _spread(quantity: str, sd: NDArray[np.float64]) -> NDArray[np.uint8]:
    octaves = np.log2(sd / CONFIDENT_SD[quantity])
    found: NDArray[np.uint8] = np.clip(np.ceil(MIDDLE + OCTAVE * octaves), 0, WORST).astype(np.uint8)
    return found


class MapPicture(NamedTuple):
    """Map of one quantity, (rows, columns) from the near left corner at `left_m` and `near_m`, m.

    Values are in C, V, N/m or indices of the list of materials, and NaN where it is unexplored. Confidences are 0..3.
    `steep` marks cells with a steep surface. `felt` marks cells with a sample in reach; None: all cells with a value.
    """

    left_m: float
    near_m: float
    value: NDArray[np.float64]
    confidence: NDArray[np.uint8]
    steep: NDArray[np.bool_]
    felt: NDArray[np.bool_] | None = None


def picture(surface: TactileMap, quantity: str) -> MapPicture | None:
    """Return all tiles of a quantity as one map; None if none was measured."""
    layers = surface.layers_of(quantity)
    places = {place for layer in layers for place in layer.tiles if layer.shows(place)}
    if not places:
        return None
    columns, rows = (range(min(numbers), max(numbers) + 1) for numbers in zip(*places, strict=True))
    value = np.full((TILE * len(rows), TILE * len(columns)), UNEXPLORED, dtype=np.uint16)
    spread = np.full(value.shape, WORST, dtype=np.uint8)
    felt = np.zeros(value.shape, dtype=np.bool_)
    for place in places:
        column, row = TILE * (place[0] - columns[0]), TILE * (place[1] - rows[0])
        at = slice(row, row + TILE), slice(column, column + TILE)
        value[at], spread[at] = cells(surface, quantity, place)
        for layer in layers:
            if place in layer.tiles:
                felt[at] |= layer.tiles[place].explored
    corner_m = TILE * CELL_M
    return MapPicture(
        columns[0] * corner_m,
        rows[0] * corner_m,
        value_of(quantity, value),
        confidence(quantity, spread),
        spread >= STEEP,
        felt,
    )


def value_of(quantity: str, value: NDArray[np.uint16]) -> NDArray[np.float64]:
    """Convert a tile's values to C, V, N/m or indices of the list of materials; NaN where nothing was measured."""
    number = np.where(value == UNEXPLORED, np.nan, value.astype(np.float64))
    if quantity == "material":
        return number
    low, high = (math.log(end) if quantity in LOGARITHMIC else end for end in RANGES[quantity])
    scaled: NDArray[np.float64] = low + number / HIGHEST * (high - low)
    return np.exp(scaled) if quantity in LOGARITHMIC else scaled


def _materials(surface: TactileMap, place: tuple[int, int]) -> Cells:
    """Return the likeliest material of each cell by the touches' votes, and the percentage of other votes."""
    tiles = [layer.tiles.get(place) or Tile() for layer in surface.named.values()]
    votes = np.array([np.nan_to_num(tile.mean()[0]) * tile.kernel for tile in tiles])
    touched = np.array([tile.kernel for tile in tiles]).sum(axis=0)
    known = np.any([tile.explored for tile in tiles], axis=0)
    share = np.where(known, votes.max(axis=0) / np.where(known, touched, 1.0), 0.0)
    spread = np.where(known, np.clip(np.ceil(100.0 * (1.0 - share) - _ROUNDING), 0, 100), WORST)
    return np.where(known, votes.argmax(axis=0), UNEXPLORED).astype(np.uint16), spread.astype(np.uint8)
