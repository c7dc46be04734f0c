"""Roughness, impulses and periods along the way."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from remote_site.texture.groove_detector import GrooveDetector
from remote_site.texture.groove_period import GroovePeriod
from remote_site.texture.roughness import PathCell, Roughness
from remote_site.texture.tip_path import CELL_M, Curve
from tests.unit.remote_site.simulated_strokes import held_values


def cells(seed, count, rms):
    """Curvature of a homogeneous surface: neighbours are alike."""
    white = np.random.default_rng(seed).normal(0.0, 1.0, count + 2)
    return rms * (white[:-2] + 2.0 * white[1:-1] + white[2:]) / np.sqrt(6.0)


def groove(values, at, depth):
    for offset, part in (
        (-4, 0.4),
        (-3, 0.5),
        (-2, 0.2),
        (-1, -0.8),
        (0, -1.0),
        (1, -0.8),
        (2, 0.2),
        (3, 0.5),
        (4, 0.4),
    ):
        if 0 <= at + offset < len(values):
            values[at + offset] += depth * part


def found(values, least_v=0.001):
    impulses, places = GrooveDetector(least_v), []
    for k, value in enumerate(values):
        impulse = impulses.step(Curve(0.001 * k, k * CELL_M, value, 4.0), float(value))
        places += [] if impulse is None else [impulse.place_m / CELL_M]
    return places


@pytest.mark.parametrize("apart", [20, 80])
def test_every_groove_is_one_impulse_at_its_place(apart):
    values = cells(0, 2000, 0.007)
    true = list(range(50, 1990, apart))
    for at in true:
        groove(values, at, 0.4)
    assert found(values) == pytest.approx(true, abs=1.0)


def test_a_surface_that_becomes_rougher_is_an_edge_and_nothing_latches():
    values = np.concatenate((cells(1, 1000, 0.007), cells(2, 2000, 0.17)))
    groove(values, 2900, 3.0)
    places = found(values)
    assert len([p for p in places if p < 1000]) == 0
    assert len([p for p in places if 1000 <= p < 1050]) <= 4
    assert [p for p in places if p >= 1050] == pytest.approx([2900], abs=1.0)


@pytest.mark.parametrize("step_v", [-0.5, 0.5])
def test_an_edge_is_one_impulse_in_either_direction(step_v):
    values = cells(4, 600, 0.007)
    values[296:300] += 0.5 * step_v
    values[300:304] -= 0.5 * step_v
    assert len(found(values)) == 1


def roughness_of(values, grooves=()):
    roughness, jumps = Roughness(), 0
    for k, value in enumerate(values):
        if k - 4 in grooves:
            roughness.groove((k - 4) * CELL_M)
        roughness.step(PathCell(k * CELL_M, float(value) ** 2, 0.0))
        jumps += roughness.changed
    return roughness, jumps


def test_grooves_stay_out_of_the_roughness():
    values = cells(5, 2000, 0.007)
    at = range(50, 1990, 20)
    for place in at:
        groove(values, place, 0.4)
    roughness, jumps = roughness_of(values, set(at))
    assert roughness.roughness_v == pytest.approx(0.007, rel=0.15)
    assert jumps == 0


@pytest.mark.parametrize(("before", "after"), [(0.007, 0.17), (0.17, 0.007)])
def test_another_surface_is_seen_and_learned_within_a_centimetre(before, after):
    roughness, jumps = roughness_of(np.concatenate((cells(6, 1000, before), cells(7, 150, after))))
    assert jumps == 1
    assert roughness.roughness_v == pytest.approx(after, rel=0.35)


@pytest.mark.long
def test_the_roughness_scatters_by_its_stated_deviation():
    """On many equal surfaces, roughness scatters by its reported deviation, after 3 mm and after 30 mm."""
    values, stated = {30: [], 300: []}, {30: [], 300: []}
    for seed in range(200):
        roughness = Roughness()
        for k, value in enumerate(cells(seed, 312, 0.1), 1):
            roughness.step(PathCell(k * CELL_M, value * value, 0.0))
            if k - 11 in values:
                values[k - 11].append(roughness.roughness_v)
                stated[k - 11].append(roughness.roughness_sd_v)
    for count, found in values.items():
        assert np.std(found) == pytest.approx(np.mean(stated[count]), rel=0.25)
    assert np.mean(stated[300]) < 0.5 * np.mean(stated[30])


def test_old_samples_are_forgotten_along_the_path():
    roughness, jumps = roughness_of(np.concatenate((cells(6, 1000, 0.010), cells(7, 600, 0.016))))
    assert jumps == 0
    assert roughness.roughness_v == pytest.approx(0.016, rel=0.2)


@given(st.lists(st.floats(-5.0, 5.0), min_size=1, max_size=400), st.integers(0, 50))
def test_memory_is_bounded_and_numbers_stay_finite(values, seed):
    values = np.concatenate((cells(seed, 300, 0.01), values))
    roughness, _ = roughness_of(values)
    assert np.isfinite(roughness.roughness_v)
    assert held_values(roughness) <= 4 * (12 + 51), "cells, a place and two powers each"
    found(values)


def period_of(places_m):
    period = GroovePeriod()
    for place_m in places_m:
        period.groove(place_m, (place_m, 0.0))
    return period.estimate()


def test_period_is_the_middle_gap():
    estimate = period_of(np.cumsum([0.0, 0.004, 0.0041, 0.008, 0.0039, 0.004]))
    assert estimate.period_m == pytest.approx(0.004, abs=1e-4)
    assert not estimate.irregular


def test_grooves_without_a_period_are_irregular():
    assert period_of(np.cumsum(np.random.default_rng(0).uniform(0.002, 0.008, 30))).irregular


def test_two_spacings_that_alternate_are_no_period():
    """The groove that is over makes one spacing the middle one, and half of the gaps equal it."""
    assert period_of(np.cumsum([0.002, 0.003] * 10)).irregular


def test_grooves_end_where_none_follows_and_another_grating_has_its_own_period():
    period, place_m = GroovePeriod(16), 0.0
    for spacing_m in (0.002, 0.008, 0.007):
        for _ in range(17):
            place_m += spacing_m
            period.stroke(spacing_m)
            period.groove(place_m, (place_m, 0.0))
        assert period.estimate().period_m == pytest.approx(spacing_m)
        assert not period.estimate().irregular
    period.stroke(0.024)
    assert period.estimate() is not None, "two grooves may be missed"
    period.stroke(0.001)
    assert period.estimate() is None


def test_an_interruption_makes_no_gap():
    period = GroovePeriod()
    for place_m in (0.000, 0.004, 0.008):
        period.groove(place_m, (place_m, 0.0))
    period.interrupt()
    for place_m in (0.015, 0.019):
        period.groove(place_m, (place_m, 0.0))
    assert period.estimate().irregularity == pytest.approx(0.0, abs=1e-9)
    assert period.estimate().period_sd_m > 0.0, "exactly even grooves are not known exactly"


@given(st.floats(0.002, 0.020), st.floats(0.05, 0.95), st.floats(0.05, 0.95), st.integers(2, 5), st.integers(2, 20))
def test_turns_do_not_change_the_period(spacing_m, before, after, grooves, ways):
    """The hand goes to and fro over the same grooves; it turns at a share of the spacing beyond them."""
    period, path_m = GroovePeriod(), 0.0
    for way in range(ways):
        places_m = spacing_m * np.arange(grooves)
        for place_m in places_m if way % 2 == 0 else places_m[::-1]:
            period.groove(path_m, (float(place_m), 0.0))
            path_m += spacing_m
        path_m += (2.0 * (after if way % 2 == 0 else before) - 1.0) * spacing_m
    found = period.estimate()
    if found is not None:
        assert found.period_m == pytest.approx(spacing_m)
        assert found.irregularity == pytest.approx(0.0, abs=1e-6)
