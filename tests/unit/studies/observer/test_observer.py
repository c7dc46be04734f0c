"""The study of the two experiments: what its fingertips feel, and what it makes of it."""

from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from common.scenes.materials import material
from common.scenes.surfaces import surface_kind
from operator_site.thermal.skin_model import contact_resistance_m2k_w
from sim_sensors.physics.finger_plate import ROOM_C, FingerPlates
from sim_sensors.physics.surface import make_profile, relief_of
from studies.observer.figure import plot
from studies.observer.paper_tables import MATCHED, MATCHING_OF, beside
from studies.observer.remote_stroke import remote_stroke
from studies.observer.run import findings, tables
from studies.observer.stroke_features import FLOOR_RAD_S, motor_features, surface_features
from studies.observer.texture_comparison import (
    BY_INTENSITY,
    BY_ROUGHNESS,
    BY_ROUGHNESS_SLOWLY,
    OWN_STIFFNESS,
    SLOWLY,
    SURFACES,
    Strokes,
    by_roughness,
    felt_features,
    real_features,
)
from studies.observer.texture_observer import Features, matching
from studies.observer.thermal_comparison import DWELLS_S, KNOWN_AHEAD, OBJECT_C, OBJECTS, PAIRS, ablation_rows
from studies.thermal_rendering.reference_finger import felt_course
from studies.touches.ideal_plate import ideal_plate_touch
from studies.touches.real_touch import real_touch
from studies.touches.remote_touch import remote_touch
from studies.touches.rendered_stroke import FingertipCourse, VirtualSurface, left_to_itself, rendered_stroke
from studies.touches.rendered_touch import rendered_touches
from studies.touches.simulated_finger import STEP_S, SimulatedFinger
from studies.touches.stroke_path import LENGTH_M, REST_S, SLOW_M_S, SPEED_M_S, measured
from teletaction.testbed.rendered_fingers import TICK_S
from tests.unit.studies.written import draw_figure, write_tables

AT_3_S = round(3.0 / STEP_S)


@cache
def virtual() -> dict[str, np.ndarray]:
    return rendered_touches(("aluminium", "wood"), OBJECT_C, 3.0, seed=1)


@cache
def stroke(name: str) -> FingertipCourse:
    return rendered_stroke(VirtualSurface.of(name, profile(name).grooves_m))


@cache
def profile(name: str) -> Any:
    return make_profile(relief_of(name), LENGTH_M, np.random.default_rng(2))


def real(name: str) -> Features:
    return surface_features(surface_kind(name).stiffness_n_m, profile(name))


@pytest.mark.long
@pytest.mark.parametrize("name", ["aluminium", "pvc", "wood"])
def test_a_real_touch_is_that_of_another_finger_but_for_its_constants(name: str) -> None:
    """The reference has other cells, another integrator, and skin constants that differ by a tenth."""
    it = material(name)
    heat, contact = it.density_kg_m3 * it.specific_heat_j_kgk, contact_resistance_m2k_w(it.conductivity_w_mk)
    course = felt_course(it.conductivity_w_mk, heat, contact, air_c=ROOM_C)
    reference = np.interp([1.0, 3.0, 5.0], course.time_s, course.at(OBJECT_C) - course.at(OBJECT_C)[0])
    found = real_touch(name, OBJECT_C, 5.0)
    assert found[0] == 0.0
    assert found[[100, 300, 500]] == pytest.approx(reference, rel=0.08)


def test_the_finger_in_the_air_is_that_on_the_simulated_plate_before_it_moves() -> None:
    finger, plates = SimulatedFinger.with_deep_tissue_at(), FingerPlates(1, 0)
    assert finger.felt_c(finger.in_air_c()) == pytest.approx(plates.felt_c[0], abs=1e-9)


def test_an_object_as_warm_as_the_skin_is_felt_as_little_as_the_air_it_takes_the_place_of() -> None:
    surface_c = 32.2
    assert abs(real_touch("aluminium", surface_c, 3.0)[-1]) < 0.25 < abs(real_touch("aluminium", 25.0, 3.0)[-1])


def test_a_worse_contact_or_a_warmer_finger_changes_what_is_felt() -> None:
    usual, worse, warmer = (
        real_touch("aluminium", OBJECT_C, 1.0, **changed) for changed in ({}, {"contact_m2k_w": 3e-3}, {"deep_c": 35.5})
    )
    assert warmer[-1] < usual[-1] < worse[-1] < 0.0


@pytest.mark.long
def test_the_simulated_plate_is_behind_the_ideal_one_and_that_behind_the_object() -> None:
    real, ideal = real_touch("aluminium", OBJECT_C, 3.0), ideal_plate_touch("aluminium", OBJECT_C, 3.0)
    assert (real[50:] < ideal[50:]).all()
    # In the first second the Peltiers are strong enough; later they lose to the warmth of their other side.
    for step in (200, 300):
        assert ideal[step] < virtual()["aluminium"][step] < 0.0
    assert virtual()["wood"][AT_3_S] == pytest.approx(real_touch("wood", OBJECT_C, 3.0)[AT_3_S], abs=0.1)


def test_an_ideal_plate_that_is_faster_is_nearer_to_the_object() -> None:
    real = real_touch("aluminium", OBJECT_C, 3.0)
    errors = [
        np.abs(ideal_plate_touch("aluminium", OBJECT_C, 3.0, faster=faster) - real).max() for faster in (1, 2, 4, 16)
    ]
    assert sorted(errors, reverse=True) == errors
    assert errors[-1] < 0.2 * errors[0]


@pytest.mark.long
def test_a_remote_object_is_felt_later_than_a_virtual_one() -> None:
    felt = remote_touch("wood", OBJECT_C, 3.0, seed=1)
    assert virtual()["wood"][100] < felt[100] < 0.0
    assert felt[AT_3_S] == pytest.approx(virtual()["wood"][AT_3_S], abs=0.15)


@pytest.mark.long
def test_a_tap_and_grooves_reach_the_motor_and_a_stroke_continues() -> None:
    course = stroke("widely_grooved_pvc")
    at_rest = (course.time_s > 0.45) & (course.time_s < REST_S)
    tapped = course.time_s < 0.45
    assert course.wanted_rad_s[tapped].max() > FLOOR_RAD_S
    assert course.speed_rad_s[tapped].max() > 0.9 * FLOOR_RAD_S
    assert course.wanted_rad_s[at_rest].max() == 0.0
    wanted = measured(course.wanted_rad_s)
    grooves = np.count_nonzero(np.diff(wanted) > 100.0)
    assert grooves == pytest.approx(len(wanted) * TICK_S * SPEED_M_S / 8e-3, abs=1)
    assert measured(course.force_n) == pytest.approx(1.0, abs=0.01)


@pytest.mark.long
def test_a_motor_left_to_itself_smooths_the_grooves_that_a_driven_one_shows() -> None:
    course = stroke("arbitrarily_grooved_pvc")
    driven, alone = (measured(each.speed_rad_s) for each in (course, left_to_itself(course)))
    wanted = measured(course.wanted_rad_s)
    assert driven.max() > 0.9 * wanted.max() > 1.3 * alone.max()
    assert abs(np.log(motor_features(driven).ln_period / motor_features(wanted).ln_period)) < 0.05


@pytest.mark.long
def test_grooves_that_come_slowly_enough_are_resolved() -> None:
    name = "closely_grooved_pvc"
    surface = VirtualSurface.of(name, profile(name).grooves_m)
    course = rendered_stroke(surface, stroke_m_s=SLOW_M_S)
    found = motor_features(measured(course.speed_rad_s), stroke_m_s=SLOW_M_S)
    assert found.ln_period == pytest.approx(np.log(2.0), abs=0.05)


def test_features_of_a_course_are_those_that_it_was_made_with() -> None:
    since_s = TICK_S * (np.arange(2000) % 50)  # 5 mm at 50 mm/s
    course = 300.0 + 200.0 * np.exp(-30.0 * since_s)
    found = motor_features(course)
    assert (found.pattern, found.ln_period) == (3.0, pytest.approx(np.log(5.0)))
    assert found.irregularity == pytest.approx(0.0, abs=1e-9)
    assert found.ln_intensity == pytest.approx(np.log((course**2).mean() + FLOOR_RAD_S**2))
    weak = motor_features(300.0 + 30.0 * np.exp(-30.0 * since_s))
    assert (weak.pattern, weak.ln_period, weak.irregularity) == (0.0, 0.0, 0.0)
    assert motor_features(np.zeros(2000)).ln_intensity == pytest.approx(2.0 * np.log(FLOOR_RAD_S))


def test_features_of_real_surfaces_are_those_of_their_kind() -> None:
    closely, widely, arbitrarily = (
        real(name) for name in ("closely_grooved_pvc", "widely_grooved_pvc", "arbitrarily_grooved_pvc")
    )
    assert closely.ln_period == pytest.approx(np.log(2.0))
    assert widely.ln_period == pytest.approx(np.log(8.0))
    assert arbitrarily.irregularity > 1.5 > 1e-6 > widely.irregularity
    rough, plain = (real(name) for name in ("sandpaper", "plain_pvc"))
    assert rough.ln_intensity - plain.ln_intensity > 2.0
    assert (rough.pattern, plain.pattern) == (0.0, 0.0)


@pytest.mark.long
def test_a_remote_stroke_reaches_the_motor_through_sensor_and_identification() -> None:
    course = remote_stroke("sandpaper", seed=1)
    assert measured(course.speed_rad_s).mean() == pytest.approx(
        measured(stroke("sandpaper").speed_rad_s).mean(), rel=0.1
    )


@cache
def data() -> dict[str, Any]:
    """All that follows, with an ideal plate and virtual strokes in place of what takes long."""
    sides = {
        "real": {letter: [real_touch(name, OBJECT_C, 5.0)] for letter, name in OBJECTS.items()},
        "virtual": {letter: [ideal_plate_touch(name, OBJECT_C, 5.0)] for letter, name in OBJECTS.items()},
    }
    sides[KNOWN_AHEAD] = sides["remote"] = sides["virtual"]
    strokes = [stroke(name) for name in SURFACES]
    soft = rendered_stroke(replace(VirtualSurface.of("foam"), stiffness_n_m=40.0))
    others = dict.fromkeys((SLOWLY, BY_INTENSITY, BY_ROUGHNESS, BY_ROUGHNESS_SLOWLY), strokes)
    varied = {**others, OWN_STIFFNESS: [soft, *strokes[1:]]}
    one = Strokes([profile(name) for name in SURFACES], strokes, strokes, varied)
    return findings(sides, [one], ablation_rows(), seed=0, draws=500)


@pytest.mark.long
def test_every_real_cell_of_table_2_is_inside_the_paper_s_interval() -> None:
    rows = [row for row in data()["answers"] if row["side"] == "real" and row["paper_count"] is not None]
    assert len(rows) == 4 * len(DWELLS_S) * 3
    assert all(row["inside"] for row in rows)
    assert {row["pair"] for row in data()["answers"]} == set(PAIRS)


@pytest.mark.long
def test_oak_feels_like_pvc_and_a_faster_plate_distinguishes_more() -> None:
    def colder(varied: str, pair: str, side: str, value: str) -> float:
        (row,) = (
            row
            for row in data()["ablations"]
            if (row["varied"], row["pair"], row["side"], row["value"]) == (varied, pair, side, value)
        )
        return float(row["colder_percent"])

    assert colder("wood is", "p-w", "real", "oak") < 25.0 < colder("as it is", "p-w", "real", "")
    rates = [colder("as it is", "a-p", "ideal plate", "")]
    rates += [colder("plate", "a-p", "ideal plate", f"{n} times faster") for n in (2, 4)]
    assert sorted(rates) == rates
    assert rates[-1] < colder("as it is", "a-p", "real", "") + 2.0


@pytest.mark.long
def test_foam_that_is_soft_is_always_found() -> None:
    found = {
        row["features"]: row["predicted_percent"]
        for row in data()["matching"]
        if row["surface"] == "foam" and row["side"] == "virtual"
    }
    assert found["measured"] < 85.0 < found[OWN_STIFFNESS]


@pytest.mark.long
def test_constants_by_roughness_and_slow_strokes_reproduce_table_1() -> None:
    """The order of foam and plain PVC and the folding of close grooves are to blame, and not the observer."""
    profiles = [profile(name) for name in SURFACES]
    strokes = [rendered_stroke(surface, stroke_m_s=SLOW_M_S) for surface in by_roughness(profiles)]
    how = {"stroke_m_s": SLOW_M_S}
    one = Strokes(profiles, strokes, strokes, {})
    shares = matching(real_features(one, **how), felt_features(strokes, **how), 0, 2000)
    rows = [beside(share, MATCHED[name], MATCHING_OF) for name, share in zip(SURFACES, shares, strict=True)]
    assert all(row["inside"] for row in rows), rows


@pytest.mark.long
def test_a_prediction_holds_where_what_is_found_is_enough() -> None:
    rows = data()["predictions"]
    assert len(rows) == 4
    assert all(row["holds"] == (row["found"] >= row["at_least"]) for row in rows)
    assert rows[-1]["found"] == rows[-1]["at_least"] == 12.0


@pytest.mark.long
def test_it_is_written_and_drawn(tmp_path: Path) -> None:
    write_tables(tables(data()), tmp_path)
    draw_figure(plot, data(), tmp_path, 50_000)
