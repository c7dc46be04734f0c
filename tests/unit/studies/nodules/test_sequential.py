"""Presses one after another: the ground stays the same, and the comparison finds what a way saves."""

import numpy as np
import pytest

from studies.nodules.phantoms import draw_phantom
from studies.nodules.sequential import (
    INNER,
    MOST,
    NEXT,
    RASTER,
    RASTERS,
    RIM_MM,
    WAYS,
    PressedPhantom,
    chosen_mm,
    curves,
    gains,
    judged_sequence,
    raster_mm,
    saved,
)

NUMBERS = [a * b for a, b in RASTERS]


def rows(worth: float) -> list[dict[str, object]]:
    """Rows of 40 phantoms in which a press of NEXT is worth `worth` presses of the other ways."""
    rng = np.random.default_rng(0)
    draws = rng.standard_normal((40, 2, 4))
    return [
        {
            "phantom": phantom,
            "way": way,
            "presses": presses,
            "nodules": (draws[phantom, 0] + 0.03 * presses * (worth if way == NEXT else 1.0)).tolist(),
            "controls": draws[phantom, 1].tolist(),
            "place_mm": [1.0, 5.0, None, None],
            "moved_m": 1.0,
        }
        for phantom in range(40)
        for way in WAYS
        for presses in NUMBERS
    ]


def test_more_presses_leave_the_earlier_ones_as_they_were() -> None:
    pressed = PressedPhantom(draw_phantom(3_000_000))
    few, many = pressed.press(raster_mm(4, 4)), pressed.press(np.concatenate([raster_mm(4, 4), raster_mm(5, 5)]))
    np.testing.assert_array_equal(many.force_n[:16], few.force_n)


def test_a_way_that_is_worth_more_saves_presses() -> None:
    found = {(row["raster_presses"], row["way"]): row for row in saved(rows(2.0))}
    assert found[60, NEXT]["saved"] == pytest.approx(0.5, abs=0.03)
    assert found[60, NEXT]["saved_from"] > 0.4
    assert found[60, "random"]["saved"] == pytest.approx(0.0, abs=0.03)


def test_the_gain_is_that_of_the_way_that_is_worth_more() -> None:
    found = {(row["way"], row["over"]): row for row in gains(rows(2.0))}
    assert found[NEXT, RASTER]["gain"] > 5.0 * found[NEXT, RASTER]["standard_error"]
    assert found[NEXT, RASTER]["gain"] == found[NEXT, INNER]["gain"]
    assert found[INNER, RASTER] == {"way": INNER, "over": RASTER, "gain": 0.0, "standard_error": 0.0}


def test_an_inner_raster_is_even_and_leaves_the_rim() -> None:
    x = np.unique(raster_mm(4, 8, RIM_MM)[:, 0])
    np.testing.assert_allclose(x, np.linspace(6.0 + 58.0 / 8.0, 64.0 - 58.0 / 8.0, 4))


def test_a_draw_of_phantoms_without_a_nodule_is_left_out() -> None:
    few = [row | {"controls": [0.5]} for row in rows(2.0) if row["phantom"] in {0, 1, 2}]
    for row in saved([row | ({} if row["phantom"] == 0 else {"nodules": []}) for row in few]):
        assert row["saved_from"] == pytest.approx(row["saved"]) == row["saved_to"]


def test_a_curve_has_the_share_of_nodules_in_their_place() -> None:
    row = next(row for row in curves(rows(1.0)) if row["way"] == RASTER and row["presses"] == 30)
    assert row["within_3_mm"] == 0.25
    assert row["place_median_mm"] is None


@pytest.mark.long
@pytest.mark.timeout(300)
def test_each_way_presses_inside_and_repeats() -> None:
    first, second = (chosen_mm(PressedPhantom(draw_phantom(3_000_000)), NEXT) for _ in range(2))
    np.testing.assert_array_equal(first, second)
    assert first.shape == (MOST, 2)
    assert ((first >= 0.0) & (first <= 70.0)).all()


@pytest.mark.study
@pytest.mark.timeout(600)
def test_all_ways_are_judged() -> None:
    found = list(judged_sequence(3_000_000))
    assert {(row["way"], row["presses"]) for row in found} == {(way, presses) for way in WAYS for presses in NUMBERS}
