"""Tiles as bytes: a page reads the measured values to the codec's step."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.wire.touch_summary import NOTHING
from operator_site.console.map.map_layer import TILE
from operator_site.console.map.map_tiles import (
    CONFIDENT_SD,
    HIGHEST,
    MIDDLE,
    OCTAVE,
    RANGES,
    STEEP,
    UNEXPLORED,
    WORST,
    MapTile,
    changed,
    picture,
    value_of,
)
from operator_site.console.map.tactile_map import QUANTITIES, TactileMap
from tests.unit.operator_site.console.page_messages import read_tile
from tests.unit.operator_site.console.touch_rows import INDEX, hand, row, sample


@given(
    st.sampled_from(QUANTITIES), st.integers(0, 7), st.integers(0, 7), st.integers(0, 2**32 - 1), st.integers(0, 2**32)
)
def test_a_tile_comes_back_as_it_was(quantity: str, column: int, row: int, revision: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    value = rng.integers(0, UNEXPLORED + 1, (TILE, TILE)).astype(np.uint16)
    spread = np.where(value == UNEXPLORED, WORST, rng.integers(0, 256, (TILE, TILE))).astype(np.uint8)
    message = MapTile(quantity, column, row, revision, value, spread).encode()
    assert len(message) == 12 + 3 * 1024
    again = read_tile(message)
    assert again[:4] == (quantity, column, row, revision)
    np.testing.assert_array_equal(again.value, value)
    np.testing.assert_array_equal(again.spread, spread)


@pytest.mark.parametrize(
    ("quantity", "value", "sd", "confidence"),
    [
        ("temperature", 36.4, 0.2, 3),
        ("temperature", 36.4, 0.4, 2),
        ("temperature", 36.4, 0.9, 1),
        ("temperature", 36.4, 1.1, 0),
        ("roughness", 0.09, 0.07, 3),
        ("roughness", 0.09, 0.2, 1),
        ("roughness", 0.0001, 0.5, 0),
    ],
)
def test_values_and_confidence_of_one_touch(quantity: str, value: float, sd: float, confidence: int) -> None:
    surface = TactileMap()
    stored = value if quantity == "temperature" else math.log(value)
    surface.take(sample(quantity, 1, 0.0005, 0.0005, stored, sd * sd))
    (tile,) = [one for one in changed(surface, quantity, 0) if (one.column, one.row) == (4, 4)]
    low, high = RANGES[quantity]
    expected = min(max(value, low), high)
    step = (high - low) / HIGHEST if quantity == "temperature" else expected * math.log(high / low) / HIGHEST
    assert value_of(quantity, tile.value)[0, 0] == pytest.approx(expected, abs=step)
    assert tile.confidence[0, 0] == confidence
    coded_sd = CONFIDENT_SD[quantity] * 2.0 ** ((int(tile.spread[0, 0]) - MIDDLE) / OCTAVE)
    assert sd <= coded_sd * (1.0 + 1e-6)
    assert coded_sd <= sd * 2.0 ** (1.0 / OCTAVE) * (1.0 + 1e-6), "the code never understates the spread"


@pytest.mark.parametrize(("others", "confidence"), [(0, 3), (1, 2), (3, 1), (11, 0)])
def test_the_spread_of_a_material_is_the_share_that_was_named_otherwise(others: int, confidence: int) -> None:
    surface = TactileMap()
    for touch in range(10 + others):
        name = "pvc" if touch < 10 else f"other {touch}"
        surface.take(sample("material", touch, 0.0005, 0.0005, 1.0, 1.0, name))
    (tile,) = [one for one in changed(surface, "material", 0) if (one.column, one.row) == (4, 4)]
    assert tile.spread[0, 0] == math.ceil(100.0 * others / (10 + others))
    assert tile.confidence[0, 0] == confidence


def test_steep_cells_are_marked_where_a_finger_met_them_and_only_there() -> None:
    surface = TactileMap()
    level, rows = (hand(index=row(INDEX, 0.0105, 0.0205, slope_x=slope)) for slope in (0.9, 1.0))
    surface.take(sample("temperature", 1, 0.0105, 0.0205, 33.0, 1e-4))
    before = surface.revision
    surface.add(1.0, level, [NOTHING] * 5)
    assert changed(surface, "temperature", before) == [], "42 degrees are not steep"
    surface.add(1.1, rows, [NOTHING] * 5)
    tiles = changed(surface, "temperature", before)
    assert tiles, "a tile that becomes steep is sent again"
    shown = picture(surface, "temperature")
    assert shown is not None
    steep = np.argwhere(shown.steep)
    assert 4 <= len(steep) <= 16
    place_m = np.array((shown.left_m, shown.near_m)) + 1e-3 * (steep[:, ::-1] + 0.5)
    assert np.abs(place_m - (0.0105, 0.0205)).max() < 2.1e-3
    assert np.isfinite(shown.value[shown.steep]).all()
    assert (shown.confidence[shown.steep] == 3).all(), "how well a value is known has nothing to do with it"
    assert any((tile.spread >= STEEP).any() for tile in tiles)
    before = surface.revision
    surface.add(1.2, rows, [NOTHING] * 5)
    assert changed(surface, "temperature", before) == []


def test_only_changes_are_sent_and_the_oldest_first() -> None:
    surface = TactileMap()
    for n, x_m in enumerate((0.016, 0.048, 0.080), 1):
        surface.take(sample("temperature", n, x_m, 0.016, 33.0, 0.04))
    tiles = changed(surface, "temperature", 0)
    assert [tile.revision for tile in tiles] == sorted(tile.revision for tile in tiles)
    seen = tiles[1].revision
    assert [t.column for t in changed(surface, "temperature", seen)] == [t.column for t in tiles if t.revision > seen]
    assert changed(surface, "temperature", surface.revision) == []
    assert changed(surface, "stiffness", 0) == []
    with pytest.raises(ValueError, match="no quantity 'colour'"):
        changed(surface, "colour", 0)


def test_after_the_frame_has_moved_all_tiles_are_sent_again() -> None:
    surface = TactileMap()
    surface.take(sample("temperature", 1, 0.001, 0.001, 33.0, 0.04))
    before = surface.revision
    surface.take(sample("temperature", 2, 0.200, 0.001, 34.0, 0.04))
    columns = {tile.column: tile for tile in changed(surface, "temperature", before)}
    assert len([t for t in columns.values() if (t.value != UNEXPLORED).any()]) >= 2
