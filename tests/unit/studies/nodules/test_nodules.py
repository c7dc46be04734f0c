"""Random phantoms, the judge of detectors, and the reference."""

import math
from dataclasses import replace
from functools import cache
from itertools import chain
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from operator_site.palpation.nodule_search import RIGHT_WHEN_SURE
from sim_sensors.tissue.contrast import Sphere
from studies.nodules.detector import detect
from studies.nodules.figure import plot
from studies.nodules.judge import (
    Answer,
    FoundNodule,
    area_under_curve,
    by_cell,
    cells,
    control_sites,
    differences,
    judge,
    overall,
    places_mm,
    reliability,
    standard_error,
)
from studies.nodules.phantoms import Phantom, Presses, draw_phantom, press
from studies.nodules.ranges import (
    DEPTH_EDGES_MM,
    DEPTH_STEPS,
    FORCE_LIMIT_N,
    RANGES,
    RATIO_EDGES,
    SIZE_EDGES_MM,
    Ranges,
)
from studies.nodules.reference import Reference, correction
from studies.nodules.run import judge_detector, judged_seeds, run, tables
from tests.unit.studies.written import draw_figure, write_tables

CALM = Ranges(
    nodules=(0.0, 1.0, 0.0),
    size_mm=(14.0, 16.0),
    depth_mm=(2.5, 3.5),
    ratio=(10.0, 12.0),
    ground_sd=(0.02, 0.03),
    breath_mm=(0.0, 0.05),
    force_noise_n=(0.005, 0.008),
    presses_a_side=(10,),
)
"""Ranges of phantoms with one nodule that any detector should find."""


@cache
def phantoms() -> tuple[Phantom, ...]:
    return tuple(draw_phantom(seed) for seed in range(60))


def truth(phantom: Phantom) -> Answer:
    """The answer of a detector that knows the truth."""
    places = places_mm()
    probability = np.zeros(len(places))
    for s in phantom.spheres:
        near = np.hypot(places[:, 0] - s.x_mm, places[:, 1] - s.y_mm) < max(0.5 * s.size_mm, 3.0)
        probability[near] = 1.0
    return Answer(probability, tuple(FoundNodule(s.x_mm, s.y_mm, s.size_mm, 1.0) for s in phantom.spheres))


def nothing(presses: Presses) -> Answer:
    """A detector that finds nothing."""
    return Answer(np.full(len(places_mm(presses.side_mm)), 0.1), ())


def test_ends_of_the_cells_are_those_of_the_ranges() -> None:
    for edges, limits in (
        (DEPTH_EDGES_MM, RANGES.depth_mm),
        (SIZE_EDGES_MM, RANGES.size_mm),
        (RATIO_EDGES, RANGES.ratio),
    ):
        assert (edges[0], edges[-1]) == limits
    assert len(cells()) == 27
    assert sum(RANGES.nodules) == pytest.approx(1.0)


def test_phantoms_are_within_their_ranges_and_repeat() -> None:
    assert draw_phantom(3) == draw_phantom(3) != draw_phantom(4)
    for phantom in phantoms():
        for name in ("ground_sd", "tilt_deg", "breath_mm", "friction", "force_noise_n", "place_noise_mm", "press_mm"):
            low, high = getattr(RANGES, name)
            assert low <= getattr(phantom, name) <= high
        for index, sphere in enumerate(phantom.spheres):
            assert sphere.depth_mm + sphere.size_mm + RANGES.beneath_mm <= phantom.ground.layer_mm
            for other in phantom.spheres[:index]:
                gap = math.dist((sphere.x_mm, sphere.y_mm), (other.x_mm, other.y_mm))
                assert gap - 0.5 * (sphere.size_mm + other.size_mm) >= RANGES.apart_mm
    assert {len(phantom.spheres) for phantom in phantoms()} == {0, 1, 2}


@pytest.mark.long
def test_presses_repeat_grow_with_depth_and_end_at_the_limit() -> None:
    hard = draw_phantom(
        0, Ranges(ground_kpa=(39.0, 40.0), exponent=(2.9, 3.0), probe_mm=(7.9, 8.0), press_mm=(3.9, 4.0))
    )
    ended = 0
    for phantom in (*phantoms()[:10], hard):
        presses, again = press(phantom), press(phantom)
        np.testing.assert_array_equal(presses.force_n, again.force_n)
        count = phantom.presses_a_side**2
        assert presses.force_n.shape == presses.depth_mm.shape == presses.time_s.shape == (count, DEPTH_STEPS)
        assert np.all(np.nanmean(np.diff(presses.force_n, axis=1), axis=0) > 0.0)
        known = np.isfinite(presses.force_n)
        assert np.all(known[:, :-1] >= known[:, 1:])
        assert np.nanmax(presses.force_n) < FORCE_LIMIT_N + 6.0 * phantom.force_noise_n
        ended += int((~known).sum())
    assert ended > 0


def test_a_press_over_a_nodule_meets_more_force_than_one_beside_it() -> None:
    for seed in range(5):
        phantom = draw_phantom(seed, CALM)
        (sphere,) = phantom.spheres
        away = 60.0 if sphere.x_mm < 35.0 else -40.0
        places = np.array([[sphere.x_mm, sphere.y_mm], [sphere.x_mm + away, sphere.y_mm]])
        there, beside = np.nanmax(press(phantom, places).force_n, axis=1)
        assert there > 1.05 * beside


def test_area_under_curve_counts_ties_half() -> None:
    assert area_under_curve([1.0, 1.0], [0.0]) == 1.0
    assert area_under_curve([0.5], [0.5, 0.5]) == 0.5
    assert area_under_curve([0.2, 0.8], [0.5]) == 0.5
    assert area_under_curve([], [0.5]) is None


def test_more_sites_of_the_same_phantoms_do_not_make_the_standard_error_smaller() -> None:
    chance = np.random.default_rng(1)
    nodules, controls = (chance.normal(middle, 1.0, (40, 1)).tolist() for middle in (1.0, 0.0))
    once = standard_error(nodules, controls)
    assert standard_error([3 * each for each in nodules], [6 * each for each in controls]) == pytest.approx(once)


def test_the_standard_error_is_the_scatter_over_draws_of_the_phantoms() -> None:
    chance = np.random.default_rng(2)
    draws, stated = [], []
    for _ in range(400):
        own = chance.normal(size=(30, 1))
        nodules = (own + chance.normal(1.0, 0.5, (30, 2))).tolist()
        controls = (own + chance.normal(0.0, 0.5, (30, 4))).tolist()
        nodules[::3] = [[] for _ in nodules[::3]]
        draws.append(area_under_curve([*chain(*nodules)], [*chain(*controls)]))
        stated.append(standard_error(nodules, controls))
    assert np.mean(stated) == pytest.approx(np.std(draws), rel=0.1)


def test_a_detector_that_shares_the_errors_of_the_reference_differs_by_less_than_either_scatters() -> None:
    chance = np.random.default_rng(3)
    places = len(places_mm())
    one, same, other = [], [], []
    for phantom in phantoms():
        probability, noise = chance.uniform(size=(2, places))
        one.append(judge(phantom, Answer(probability, ())))
        same.append(judge(phantom, Answer(0.99 * probability + 0.01 * noise, ())))
        other.append(judge(phantom, Answer(noise, ())))
    *by_cells, whole = differences(same, one)
    *_, apart = differences(other, one)
    assert whole["difference_se"] < 0.3 * apart["difference_se"]
    assert [row["nodules"] for row in by_cells] == [row["nodules"] for row in by_cell(one)]
    assert sum(row["nodules"] for row in by_cells) == whole["nodules"]
    assert {row["difference"] for row in differences(one, one)} <= {0.0, None}


def test_one_phantom_has_no_standard_error() -> None:
    assert standard_error([[0.5, 0.7], []], [[0.1], [0.2]]) is None
    assert standard_error([[], []], [[0.1], [0.2]]) is None


@pytest.mark.long
def test_the_truth_is_perfect_and_nothing_is_chance() -> None:
    perfect = [judge(phantom, truth(phantom)) for phantom in phantoms()]
    figures = overall(perfect, by_cell(perfect))
    assert figures["nodules"] == sum(len(phantom.spheres) for phantom in phantoms())
    assert figures["good_nodules"] == figures["nodules"]
    assert (figures["auc"], figures["within_3_mm"], figures["size_order"]["right"]) == (1.0, 1.0, 1.0)
    blind = [judge(phantom, nothing(press(phantom))) for phantom in phantoms()]
    assert {row["auc"] for row in by_cell(blind)} <= {0.5, None}
    figures = overall(blind, by_cell(perfect))
    assert (figures["auc"], figures["within_3_mm"], figures["size_order"]["right"]) == (0.5, 0.0, 0.0)
    (row,) = [row for row in reliability(blind) if row["places"]]
    assert row["stated"] == pytest.approx(0.1)
    assert row["places"] == len(places_mm()) * len(phantoms())


def test_control_sites_are_clear_of_nodules_and_repeat() -> None:
    for phantom in phantoms():
        sites = control_sites(phantom)
        assert sites == control_sites(phantom)
        for x_mm, y_mm, size_mm in sites:
            for s in phantom.spheres:
                assert math.dist((x_mm, y_mm), (s.x_mm, s.y_mm)) - 0.5 * (size_mm + s.size_mm) >= 8.0


@pytest.mark.parametrize(
    "probability", [np.zeros(3), np.full(len(places_mm()), 1.2), np.full(len(places_mm()), np.nan)]
)
def test_a_malformed_answer_is_refused(probability: np.ndarray[Any, Any]) -> None:
    with pytest.raises(ValueError, match="a detector gives 784 probabilities from 0 to 1"):
        judge(phantoms()[0], Answer(probability, ()))


@pytest.mark.long
def test_any_detector_can_be_judged() -> None:
    judged = judge_detector(nothing, judged_seeds(0, 12))
    assert [each.seed for each in judged] == list(range(12))
    assert judged_seeds(0) == range(500)
    assert not set(judged_seeds(0)) & set(judged_seeds(1))


@pytest.mark.long
def test_the_reference_finds_a_plain_nodule_in_its_place() -> None:
    for seed in range(3):
        phantom = draw_phantom(seed, CALM)
        answer = Reference()(press(phantom))
        best = max(answer.found, key=lambda found: found.probability)
        (sphere,) = phantom.spheres
        assert best.probability > 0.9
        assert math.dist((best.x_mm, best.y_mm), (sphere.x_mm, sphere.y_mm)) < 3.0


@pytest.mark.long
def test_the_detector_finds_a_plain_nodule_in_its_place() -> None:
    for seed in range(3):
        phantom = draw_phantom(seed, CALM)
        answer = detect(press(phantom))
        best = max(answer.found, key=lambda found: found.probability)
        (sphere,) = phantom.spheres
        assert best.probability > 0.9 * RIGHT_WHEN_SURE
        assert math.dist((best.x_mm, best.y_mm), (sphere.x_mm, sphere.y_mm)) < 3.0


def test_the_correction_learns_from_overconfidence() -> None:
    places = places_mm()
    phantom = replace(phantoms()[0], spheres=(Sphere(35.0, 35.0, 20.0, 3.0, 10.0),))
    inside = np.hypot(places[:, 0] - 35.0, places[:, 1] - 35.0) < 10.0
    rng = np.random.default_rng(0)
    mistaken = rng.uniform(size=len(places)) < np.where(inside, 0.3, 0.05)
    stated = np.where(inside ^ mistaken, 0.999, 0.001)
    learned = correction([(phantom, Answer(stated, ()))])
    assert 0.0 < learned.slope < 1.0


@pytest.mark.study
@pytest.mark.timeout(600)
def test_the_study_reports_every_nodule_and_draws_its_figure(tmp_path: Path) -> None:
    data = run(quick=True, seed=0, progress=lambda _: None)
    assert data["overall"]["phantoms"] == 24
    assert len(data["nodules"]) == data["overall"]["nodules"]
    assert data["overall"]["auc"] > 0.6
    assert data["detector_overall"]["auc"] > 0.6
    write_tables(tables(data), tmp_path)
    draw_figure(plot, data, tmp_path)
