"""Builds the tactile map: temperature, roughness, stiffness and material over the explored surface.

Pure: the map takes touch packets at any rate and grows only where a finger touches.
"""

import math
from collections.abc import Sequence
from itertools import takewhile
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from common.fingers import FINGER_Y_M, FINGERS
from common.wire.messages import TouchRow
from common.wire.roughness_um import RoughnessUm
from common.wire.touch_summary import TouchSummary
from operator_site.console.map.finger_samples import FingerSamples, Sample, slant
from operator_site.console.map.map_layer import CELL_M, KERNEL_M, REACH_M, TILE, Layer, tile_of
from operator_site.console.map.roughness_shown import LEVEL_0_V, LEVEL_10_V
from operator_site.console.map.stiffness_layer import StiffnessLayer

QUANTITIES = ("temperature", "roughness", "stiffness", "material")
LOGARITHMIC = frozenset(("roughness", "stiffness"))
"""Quantities whose samples are natural logarithms."""
COLUMNS = ROWS = 256
"""Columns and rows of cells of the frame that a page shows."""
SHARED_SD_K = 0.9
"""Standard deviation of one finger's temperature from a temperature that several fingers share, K.

The shared temperature outvotes one warm finger of five for seconds.
"""
SCALE_K = 3.0
"""Half the span of the temperature scale, K."""
SCALES = {"roughness": (LEVEL_0_V, LEVEL_10_V), "stiffness": (200.0, 5000.0)}
"""Ends of the roughness and stiffness scales, V and N/m."""
CENTRED_BY = 10
"""Number of first touches whose median is the centre of the temperature scale; later touches do not move it."""
BESIDE_M, AROUND_M = 0.010, 0.030
"""Inner and outer radius of the surroundings of a place, m."""
STALE_M = 0.004
"""Side of the squares that are marked as felt before the patient has moved, m."""
_STALE_EVERY = 20
"""Number of changes of the map after which these squares are found again."""
STEEP_SLOPE = 0.999
"""Smallest slope of a steep surface, rise over run: 45 degrees, the largest slope of the link along either axis."""
_FRAME_TILES = COLUMNS // TILE


class Measured(NamedTuple):
    """One quantity at a place: value and standard deviation in C, V or N/m, number of touches, time of the last one."""

    value: float
    sd: float
    touches: int
    last_s: float


class ExploredPlace(NamedTuple):
    """Quantities around a place, None without a sample; `material` is the likeliest one and its share of the votes.

    `lump` is the probability that the place belongs to a lump; None if too few places were pressed.
    """

    x_m: float
    y_m: float
    temperature: Measured | None
    roughness: Measured | None
    stiffness: Measured | None
    material: tuple[str, float] | None
    lump: float | None = None


class TactileMap:
    """The map of one session.

    Attributes:
        revision: grows with every change.
        layers: temperature, roughness and stiffness, by name.
        stiffness: the layer of stiffness, with its field and lump probabilities.
        named: a layer of probabilities for each identified material, in the order of `materials`.
        framed: revision of the newest move of the frame.
        roughness_um: scale of roughness in um of the sensors; None if they were not calibrated for it.
        felt_m: smallest x and y and largest x and y of all samples, m; None before the first one.
        moved_s: time of the patient's newest movement, s; None without one.
    """

    def __init__(self, roughness_um: RoughnessUm | None = None) -> None:
        """Begin unexplored, with sensors that have a scale in um or not."""
        self.roughness_um = roughness_um
        self.revision = 0
        self.stiffness = StiffnessLayer()
        self.layers: dict[str, Layer] = {
            "temperature": Layer(middle=30.0),
            "roughness": Layer(),
            "stiffness": self.stiffness,
        }
        self.named: dict[str, Layer] = {}
        self._steep: dict[tuple[int, int], tuple[NDArray[np.bool_], int]] = {}
        """Steep cells of each tile, and the revision of their newest change."""
        self._slants: list[tuple[int, Sample]] = []
        """Samples that marked a cell as steep, and the revision of each."""
        self._kept = 0
        """Revision of the newest sample that `unkept` has returned."""
        self._fingers = [FingerSamples(finger) for finger in range(len(FINGERS))]
        self._corner: tuple[int, int] | None = None
        """Column and row of the tile at the frame's left and near edge."""
        self.framed = 0
        self.felt_m: tuple[float, float, float, float] | None = None
        self.moved_s: float | None = None
        self._stale: tuple[object, list[tuple[float, float]]] = (None, [])
        self._centre_c: float | None = None
        self._centred_by: list[tuple[tuple[int, int, int], float]] = []

    @property
    def materials(self) -> list[str]:
        """Names of the materials in the order of their first identification."""
        return list(self.named)

    @property
    def frame(self) -> tuple[float, float]:
        """Left and near edge of the frame of COLUMNS x ROWS cells, m."""
        column, row = self._corner or (-_FRAME_TILES // 2, -_FRAME_TILES // 2)
        return column * TILE * CELL_M, row * TILE * CELL_M

    def add(self, t_s: float, rows: Sequence[TouchRow], summaries: Sequence[TouchSummary]) -> None:
        """Take one accepted touch packet."""
        for finger, samples in enumerate(self._fingers):
            row = rows[finger]
            if row.contact and math.hypot(row.slope_x, row.slope_y) >= STEEP_SLOPE:
                self.take(slant(t_s, finger, row.x_m, row.y_m + FINGER_Y_M[finger]))
            for sample in samples.step(t_s, row, summaries[finger]):
                shared = sample.quantity == "temperature" and _is_shared(rows, finger)
                self.take(sample._replace(variance=sample.variance + SHARED_SD_K**2) if shared else sample)

    def layers_of(self, quantity: str) -> list[Layer]:
        """Return the layers of a quantity: one, or one for each material."""
        return list(self.named.values()) if quantity == "material" else [self.layers[quantity]]

    def steep(self, place: tuple[int, int]) -> NDArray[np.bool_]:
        """Return the steep cells of the tile at a column and row of the bench, (TILE, TILE)."""
        known = self._steep.get(place)
        return np.zeros((TILE, TILE), dtype=np.bool_) if known is None else known[0]

    def steep_revision(self, place: tuple[int, int]) -> int:
        """Return the revision at which a cell of a tile was last marked steep; 0 if none is."""
        return self._steep[place][1] if place in self._steep else 0

    def _slant(self, sample: Sample) -> None:
        """Mark the cells within KERNEL_M of a finger on a steep surface, in either axis."""
        x_m, y_m, before = sample.x_m, sample.y_m, self.revision
        for column in range(math.floor((x_m - KERNEL_M) / CELL_M), math.floor((x_m + KERNEL_M) / CELL_M) + 1):
            for row in range(math.floor((y_m - KERNEL_M) / CELL_M), math.floor((y_m + KERNEL_M) / CELL_M) + 1):
                place, cell = (column // TILE, row // TILE), (row % TILE, column % TILE)
                if not (known := self.steep(place))[cell]:
                    self.revision += 1
                    known[cell] = True
                    self._steep[place] = known, self.revision
        if self.revision != before:
            self._slants.append((self.revision, sample))

    def take(self, sample: Sample) -> None:
        """Take one sample."""
        if sample.quantity == "slant":
            self._slant(sample)
            return
        self.revision += 1
        self._follow(sample.x_m, sample.y_m)
        left_m, near_m, right_m, far_m = self.felt_m or (math.inf, math.inf, -math.inf, -math.inf)
        self.felt_m = (
            min(left_m, sample.x_m),
            min(near_m, sample.y_m),
            max(right_m, sample.x_m),
            max(far_m, sample.y_m),
        )
        if sample.quantity == "material":
            for name, layer in self.named.items():
                if name != sample.name:
                    layer.drop(sample.finger, sample.key, self.revision)
            self.named.setdefault(sample.name, Layer()).put(sample, self.revision)
            return
        if sample.quantity == "temperature":
            self._centre(sample)
        self.layers[sample.quantity].put(sample, self.revision)

    def unkept(self) -> list[Sample]:
        """Return the samples since the last call in the order in which they came; a map that takes them shows the same.

        Times do not give this order: the site's clock may have begun again.
        """
        samples = self._after(self._kept)
        self._kept = self.revision
        return samples

    def _after(self, revision: int) -> list[Sample]:
        """Return the samples that were taken after a revision, in this order."""
        layers = (*self.layers.values(), *self.named.values())
        found = [each for layer in layers for tile in layer.tiles.values() for each in tile.after(revision)]
        found += takewhile(lambda slant: slant[0] > revision, reversed(self._slants))
        return [sample for _, sample in sorted(found, key=lambda each: each[0])]

    def restore(self, sample: Sample) -> None:
        """Take a kept sample of an earlier map; later touches get other numbers than its touch."""
        self._fingers[sample.finger].count_from(sample.touch)
        self.take(sample)
        self._kept = self.revision

    def stale(self) -> list[tuple[float, float]]:
        """Return the left near corners, m, of the squares that were felt before the patient has moved, and not since.

        A square that was felt again since is not among them, although its cells hold both.
        """
        if self.moved_s is None:
            return []
        key = self.moved_s, self.revision // _STALE_EVERY
        if self._stale[0] != key:
            newest_s: dict[tuple[int, int], float] = {}
            for sample in self._after(0):
                square = math.floor(sample.x_m / STALE_M), math.floor(sample.y_m / STALE_M)
                newest_s[square] = sample.t_s
            old = [square for square, at_s in newest_s.items() if at_s < self.moved_s]
            self._stale = key, [(column * STALE_M, row * STALE_M) for column, row in sorted(old)]
        return self._stale[1]

    def legend(self, quantity: str) -> tuple[float, float]:
        """Return the ends of a quantity's scale, in its unit; temperature is centred at 33 C until it is measured."""
        if quantity in SCALES:
            return SCALES[quantity]
        centre_c = 33.0 if self._centre_c is None else self._centre_c
        return centre_c - SCALE_K, centre_c + SCALE_K

    def at(self, x_m: float, y_m: float, radius_m: float = REACH_M) -> ExploredPlace:
        """Combine the samples within `radius_m` of a place."""
        found = {name: _together(layer, name, x_m, y_m, radius_m) for name, layer in self.layers.items()}
        votes = {name: sum(s.value for s in layer.near(x_m, y_m, radius_m)) for name, layer in self.named.items()}
        best = max(votes, key=votes.__getitem__, default="")
        all_votes = sum(votes.values())
        material = (best, votes[best] / all_votes) if all_votes > 0.0 else None
        lump = None if found["stiffness"] is None else self.stiffness.lump_at(x_m, y_m)
        return ExploredPlace(x_m, y_m, found["temperature"], found["roughness"], found["stiffness"], material, lump)

    def around(self, x_m: float, y_m: float) -> ExploredPlace:
        """Return median and spread of the samples in the surroundings of a place."""
        found = {name: _surroundings(layer, name, x_m, y_m) for name, layer in self.layers.items()}
        return ExploredPlace(x_m, y_m, found["temperature"], found["roughness"], found["stiffness"], None)

    def _follow(self, x_m: float, y_m: float) -> None:
        """Move the frame by whole tiles, so that a place lies at least one tile inside it."""
        column, row = tile_of(x_m, y_m)
        if self._corner is None:
            corner = column - _FRAME_TILES // 2, row - _FRAME_TILES // 2
        else:
            low = column - _FRAME_TILES + 2, row - _FRAME_TILES + 2
            corner = (
                min(max(self._corner[0], low[0]), column - 1),
                min(max(self._corner[1], low[1]), row - 1),
            )
        if corner != self._corner:
            self._corner, self.framed = corner, self.revision

    def _centre(self, sample: Sample) -> None:
        if self._centred_by and self._centred_by[-1][0] == sample.key:
            self._centred_by.pop()
        if len(self._centred_by) < CENTRED_BY:
            self._centred_by.append((sample.key, sample.value))
            self._centre_c = round(2.0 * float(np.median([value for _, value in self._centred_by]))) / 2.0


def _is_shared(rows: Sequence[TouchRow], finger: int) -> bool:
    """Return whether another finger in contact has exactly the same temperature and standard deviation."""
    mine = rows[finger]
    return any(
        other.contact and other.object_c == mine.object_c and other.object_c_sd == mine.object_c_sd
        for number, other in enumerate(rows)
        if number != finger
    )


def _together(layer: Layer, name: str, x_m: float, y_m: float, radius_m: float) -> Measured | None:
    """Return the precision-weighted mean of the samples; disagreement increases its standard deviation."""
    samples = list(layer.near(x_m, y_m, radius_m))
    if not samples:
        return None
    weights = [1.0 / sample.variance for sample in samples]
    mean = sum(w * s.value for w, s in zip(weights, samples, strict=True)) / sum(weights)
    disagreement = sum(w * (s.value - mean) ** 2 for w, s in zip(weights, samples, strict=True))
    variance = max(1.0, disagreement / max(len(samples) - 1, 1)) / sum(weights)
    return _measured(name, mean, math.sqrt(variance), samples)


def _surroundings(layer: Layer, name: str, x_m: float, y_m: float) -> Measured | None:
    near = layer.near(x_m, y_m, AROUND_M)
    samples = [s for s in near if math.dist((x_m, y_m), (s.x_m, s.y_m)) >= BESIDE_M]
    if not samples:
        return None
    values = np.array([sample.value for sample in samples])
    median = float(np.median(values))
    spread = 1.4826 * float(np.median(np.abs(values - median)))
    return _measured(name, median, max(spread, math.sqrt(min(s.variance for s in samples))), samples)


def _measured(name: str, value: float, sd: float, samples: Sequence[Sample]) -> Measured:
    touches, last_s = len({(s.finger, s.touch) for s in samples}), max(s.t_s for s in samples)
    if name in LOGARITHMIC:
        return Measured(math.exp(value), sd * math.exp(value), touches, last_s)
    return Measured(value, sd, touches, last_s)
