"""The map shows samples where they were taken, in any order, and nothing elsewhere."""

import math
import pickle
from itertools import product

import msgpack
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from common.fingers import FINGERS
from common.wire.messages import ThermalStatus
from common.wire.touch_summary import NOTHING
from operator_site.console.map import map_tiles
from operator_site.console.map.finger_samples import Sample, samples_of, slant
from operator_site.console.map.map_layer import CELL_M, REACH_M, TILE
from operator_site.console.map.tactile_map import SHARED_SD_K, TactileMap
from tests.unit.operator_site.console.touch_rows import INDEX, hand, row, sample

PLACES = st.floats(-0.040, 0.040)
SAMPLES = st.lists(st.tuples(PLACES, PLACES, st.floats(20.0, 45.0), st.floats(0.01, 1.0)), min_size=1, max_size=12)


def made(samples: list[Sample]) -> TactileMap:
    surface = TactileMap()
    for one in samples:
        surface.take(one)
    return surface


def temperatures(rows: list[tuple[float, float, float, float]]) -> list[Sample]:
    return [sample("temperature", number, *one) for number, one in enumerate(rows, 1)]


@pytest.mark.long
@settings(deadline=None, max_examples=40)
@given(SAMPLES)
def test_nothing_is_shown_where_nothing_was_measured(rows: list[tuple[float, float, float, float]]) -> None:
    surface = made(temperatures(rows))
    shown = 0
    for (column, line), tile in surface.layers["temperature"].tiles.items():
        for y, x in np.argwhere(tile.explored):
            place = (column * TILE + x + 0.5) * CELL_M, (line * TILE + y + 0.5) * CELL_M
            assert min(math.dist(place, one[:2]) for one in rows) <= REACH_M + 1e-9
            shown += 1
    assert shown >= 20  # one sample alone reaches 28 cells or so


@pytest.mark.long
@settings(deadline=None, max_examples=40)
@given(SAMPLES, st.randoms(use_true_random=False))
def test_the_order_of_samples_does_not_matter(rows: list[tuple[float, float, float, float]], chance: object) -> None:
    samples = temperatures(rows)
    shuffled = list(samples)
    chance.shuffle(shuffled)  # type: ignore[attr-defined]
    one, other = made(samples).layers["temperature"], made(shuffled).layers["temperature"]
    assert one.tiles.keys() == other.tiles.keys()
    for place, tile in one.tiles.items():
        for mine, theirs in zip(tile.mean(), other.tiles[place].mean(), strict=True):
            np.testing.assert_allclose(mine, theirs, rtol=1e-6, atol=1e-6)


@pytest.mark.long
@settings(deadline=None, max_examples=40)
@given(SAMPLES)
def test_a_replaced_sample_leaves_no_trace(rows: list[tuple[float, float, float, float]]) -> None:
    samples = temperatures(rows)
    first = [one._replace(value=one.value + 7.0, x_m=one.x_m + 0.001) for one in samples]
    replaced = made([each for pair in zip(first, samples, strict=True) for each in pair]).layers["temperature"]
    plain = made(samples).layers["temperature"]
    for place, tile in replaced.tiles.items():
        if place in plain.tiles:
            np.testing.assert_array_equal(tile.explored, plain.tiles[place].explored)
            np.testing.assert_allclose(tile.mean()[0], plain.tiles[place].mean()[0], atol=1e-5)
        else:
            assert not tile.explored.any()


NAMES = ("pvc", "pine")
KEPT = st.tuples(
    st.sampled_from(("temperature", "roughness", "stiffness", "slant", *NAMES)), st.booleans(), PLACES, PLACES
)


@pytest.mark.long
@settings(deadline=None, max_examples=40)
@given(st.lists(st.tuples(KEPT, st.booleans()), min_size=1, max_size=25))
def test_a_map_made_of_what_was_kept_now_and_then_shows_the_same(
    course: list[tuple[tuple[str, bool, float, float], bool]],
) -> None:
    """Samples that are replaced during a touch, also by another material's, are kept in between or not."""
    surface, again, touch = TactileMap(), TactileMap(), 1
    for second, ((what, lifted, x_m, y_m), keeps) in enumerate(course):
        touch += lifted
        quantity, name = ("material", what) if what in NAMES else (what, "")
        surface.take(sample(quantity, touch, x_m, y_m, 0.5 + 0.01 * second, 0.04, name)._replace(t_s=float(second)))
        if keeps or second == len(course) - 1:
            for one in samples_of(msgpack.unpackb(msgpack.packb({"samples": surface.unkept()}))):
                again.restore(one)
    for old, new in ((surface.layers, again.layers), (surface.named, again.named)):
        for layer, tiles in old.items():
            for place, tile in tiles.tiles.items():
                if tile.explored.any():
                    assert tile.samples == new[layer].tiles[place].samples
                    for mine, theirs in zip(tile.mean(), new[layer].tiles[place].mean(), strict=True):
                        np.testing.assert_allclose(mine, theirs, rtol=1e-6, atol=1e-6)
    for place in product(range(-2, 2), repeat=2):  # PLACES are within these tiles
        np.testing.assert_array_equal(again.steep(place), surface.steep(place))
    assert again.at(0.0, 0.0, 1.0) == surface.at(0.0, 0.0, 1.0)


def test_every_sample_is_kept_once_although_the_sites_clock_begins_again() -> None:
    """Both touches of a place are before and after a restart; the clock then passes the times of the first ones."""
    surface, again = TactileMap(), TactileMap()
    for touch, t_s in enumerate((3600.0, 3601.0, 100.0, 101.0, 3600.5, 3602.0), 1):
        surface.take(sample("stiffness", touch, 0.0, 0.0, 6.0, 0.01)._replace(t_s=t_s))
        surface.take(slant(t_s, INDEX, 0.01 * touch, 0.0))
        kept = surface.unkept()
        assert [(one.quantity, one.t_s) for one in kept] == [("stiffness", t_s), ("slant", t_s)]
        for one in kept:
            again.restore(one)
    assert again.unkept() == surface.unkept() == []
    assert again.at(0.0, 0.0) == surface.at(0.0, 0.0)
    place = again.at(0.0, 0.0).stiffness
    assert place is not None
    assert place.touches == 6


def test_a_touch_after_what_was_kept_replaces_nothing_of_it() -> None:
    surface = TactileMap()
    surface.restore(sample("temperature", 7, 0.0, 0.0, 36.0, 0.01))
    for tick in range(40):
        known = row(INDEX, 0.0, 0.0, object_c=33.0, object_c_sd=0.1, thermal_status=float(ThermalStatus.IDENTIFIED))
        surface.add(100.0 + 0.1 * tick, hand(index=known), (NOTHING,) * len(FINGERS))
    place = surface.at(0.0, 0.0)
    assert place.temperature is not None
    assert place.temperature.touches == 2


def test_a_cell_has_the_mean_of_its_samples_by_their_precision() -> None:
    surface = made([sample("temperature", 1, 0.0, 0.0, 36.0, 0.01), sample("temperature", 2, 0.0, 0.0, 36.2, 0.01)])
    value, sd = surface.layers["temperature"].tiles[0, 0].mean()
    assert value[0, 0] + 30.0 == pytest.approx(36.1)
    assert 0.07 < sd[0, 0] < 0.12


def test_samples_that_disagree_by_more_than_they_say_are_not_believed_as_much() -> None:
    surface = made([sample("temperature", 1, 0.0, 0.0, 33.0, 0.01), sample("temperature", 2, 0.0, 0.0, 35.0, 0.01)])
    assert surface.at(0.0, 0.0).temperature is not None
    assert surface.at(0.0, 0.0).temperature.sd == pytest.approx(1.0)  # type: ignore[union-attr]
    assert surface.layers["temperature"].tiles[0, 0].mean()[1][0, 0] > 0.9


def test_a_place_has_value_touches_and_time() -> None:
    surface = made([sample("stiffness", n, 1e-3 * n, 0.0, math.log(600.0 + n), 0.03**2) for n in (1, 2, 9)])
    here = surface.at(0.0, 0.0).stiffness
    assert here is not None
    assert here.value == pytest.approx(601.5, rel=1e-4)
    assert here.sd == pytest.approx(0.03 * 601.5 / math.sqrt(2.0), rel=1e-3)
    assert (here.touches, here.last_s) == (2, 2.0)
    assert surface.at(0.0, 0.05).stiffness is None
    assert surface.at(0.0, 0.0).temperature is None


def test_the_surroundings_leave_the_place_itself_out() -> None:
    ring = [
        sample("temperature", n, 0.02 * math.cos(n), 0.02 * math.sin(n), 33.0 + 0.1 * (n % 3), 0.04) for n in range(9)
    ]
    surface = made(
        [*ring, sample("temperature", 99, 0.0, 0.0, 35.0, 0.04), sample("temperature", 98, 0.1, 0.0, 20.0, 0.04)]
    )
    around = surface.around(0.0, 0.0).temperature
    assert around is not None
    assert around.value == pytest.approx(33.1)
    assert around.touches == 9


def test_a_temperature_that_fingers_share_is_not_of_their_places() -> None:
    surface = TactileMap()
    known = {"object_c": 33.0, "object_c_sd": 0.1}
    for tick in range(60):
        rows = hand(index=row(1, 0.0, 0.0, **known), ring=row(3, 0.0, 0.04, **known), little=row(4, 0.0, 0.06))
        surface.add(0.05 * tick, rows, (NOTHING,) * len(FINGERS))
    shared = surface.at(0.0, 0.0).temperature
    assert shared is not None
    assert shared.sd == pytest.approx(math.hypot(0.1, SHARED_SD_K))
    tile = {one.column: one for one in map_tiles.changed(surface, "temperature", 0)}
    assert max(one.confidence.max() for one in tile.values()) == 1


def test_materials_by_the_votes_of_those_that_named_one() -> None:
    votes = [("pvc", 0.99, 1), ("pvc", 0.98, 2), ("pine", 0.9, 3)]
    surface = made([sample("material", n, 0.0, 0.0, p, 1.0, name) for name, p, n in votes])
    assert surface.materials == ["pvc", "pine"]
    assert surface.at(0.0, 0.0).material == ("pvc", pytest.approx(1.97 / 2.87))


def test_a_touch_that_names_another_material_has_named_only_that() -> None:
    surface = made([sample("material", 1, 0.0, 0.0, 0.99, 1.0, name) for name in ("pvc", "pine")])
    assert surface.at(0.0, 0.0).material == ("pine", 1.0)
    cells = [one for one in map_tiles.changed(surface, "material", 0) if (one.value != map_tiles.UNEXPLORED).any()]
    assert {int(v) for one in cells for v in one.value[one.value != map_tiles.UNEXPLORED]} == {1}


def test_the_first_temperatures_centre_the_scale_and_it_stays() -> None:
    surface = TactileMap()
    assert surface.legend("temperature") == (30.0, 36.0)
    for n in range(10):
        surface.take(sample("temperature", n, 0.01 * n, 0.0, 25.1, 0.04))
    assert surface.legend("temperature") == (22.0, 28.0)
    for n in range(10, 40):
        surface.take(sample("temperature", n, 0.01 * n, 0.0, 40.0, 0.04))
    assert surface.legend("temperature") == (22.0, 28.0)


def test_the_frame_follows_the_touches_by_whole_tiles() -> None:
    surface = made([sample("temperature", 1, 0.0, 0.0, 33.0, 0.04)])
    assert surface.frame == pytest.approx((-0.128, -0.128))
    surface.take(sample("temperature", 2, 0.05, 0.0, 33.0, 0.04))
    assert surface.frame == pytest.approx((-0.128, -0.128))
    surface.take(sample("temperature", 3, 0.15, -0.2, 33.0, 0.04))
    left_m, near_m = surface.frame
    assert left_m <= 0.15 - 0.032 < 0.15 + 0.032 <= left_m + 0.256
    assert near_m <= -0.2 - 0.016 < -0.2 + 0.032 <= near_m + 0.256
    assert left_m / (TILE * CELL_M) == pytest.approx(round(left_m / (TILE * CELL_M)))


def test_stiffness_between_presses_is_shown_with_less_confidence_and_not_beyond() -> None:
    surface = made([sample("stiffness", n, 0.016 * n, 0.008, math.log(600.0 + 900.0 * n), 0.03**2) for n in range(2)])
    shown = map_tiles.picture(surface, "stiffness")
    assert shown is not None
    assert shown.felt is not None
    column, row = (round((at - corner) / CELL_M) for at, corner in ((0.0, shown.left_m), (0.008, shown.near_m)))
    assert shown.confidence[row, column] > shown.confidence[row, column + 8]
    assert np.isfinite(shown.value[row, column + 8])
    assert shown.felt[row, column]
    assert not shown.felt[row, column + 8]
    assert np.isnan(shown.value[row, column - 12])


def test_a_place_has_the_probability_of_a_lump_once_enough_places_are_pressed() -> None:
    grid = [(0.005 * column, 0.005 * line) for column, line in product(range(-4, 5), repeat=2)]
    presses = [
        sample("stiffness", n, x, y, math.log(900.0 if math.hypot(x, y) < 0.006 else 600.0 + n % 7), 0.03**2)
        for n, (x, y) in enumerate(grid)
    ]
    assert made(presses[:5]).at(*grid[0]).lump is None
    surface = made(presses)
    lump, ground = surface.at(0.0, 0.0).lump, surface.at(0.018, 0.018).lump
    assert lump is not None
    assert ground is not None
    assert lump > 0.9
    assert ground < 0.1
    assert surface.at(0.2, 0.2).lump is None, "nothing was pressed there"


def test_a_map_is_stored_without_its_field_and_shows_the_same() -> None:
    surface = made([sample("stiffness", n, 0.004 * n, 0.0, 6.0 + 0.1 * n, 1e-4) for n in range(9)])
    unread = len(pickle.dumps(surface))
    place = surface.at(0.0, 0.0)
    stored = pickle.dumps(surface)
    assert len(stored) == unread
    assert pickle.loads(stored).at(0.0, 0.0) == place


@pytest.mark.parametrize(
    "damaged",
    [{"x_m": math.inf}, {"y_m": math.nan}, {"value": math.nan}, {"variance": 0.0}, {"variance": math.inf}, {"t_s": ""}],
)
def test_a_damaged_sample_of_a_journal_is_refused(damaged: dict[str, float]) -> None:
    good = sample("stiffness", 1, 0.001, 0.001, 6.4, 1e-3)
    assert samples_of({"samples": [tuple(good)]}) == [good]
    with pytest.raises((TypeError, ValueError)):
        samples_of({"samples": [tuple(good), tuple(good._replace(**damaged))]})


@settings(deadline=None, max_examples=40)
@given(SAMPLES)
def test_the_felt_area_and_its_cells_are_known(rows: list[tuple[float, float, float, float]]) -> None:
    assert TactileMap().felt_m is None
    surface = made(temperatures(rows))
    xs, ys = [one[0] for one in rows], [one[1] for one in rows]
    assert surface.felt_m == (min(xs), min(ys), max(xs), max(ys))
    layer = surface.layers["temperature"]
    assert layer.felt_cells == sum(int(tile.explored.sum()) for tile in layer.tiles.values()) > 0
    assert surface.layers["stiffness"].felt_cells == 0
