"""The smallest model that is right enough: against a finger that shares no code, for every material."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from common.scenes.materials import materials
from operator_site.thermal.model_selection import LONGEST_S, RUNGS, TOLERANCE_K, TOLERANCE_SHARE, choose, rung_table
from operator_site.thermal.scene_skin import AT_REST_K, SceneSkin
from operator_site.thermal.skin_model import STEP_S, SkinModel, Touched
from operator_site.thermal.tissue import Body, rest
from studies.thermal_rendering.reference_finger import FeltCourse, felt_course

NAMES = sorted(materials())
CASES = 600
SURFACE_C = rest(Body()).surface_c
STEPS = round(LONGEST_S / STEP_S)
TIMES_S = STEP_S * np.arange(STEPS + 1)


@cache
def true_course(name: str) -> FeltCourse:
    it = Touched.of(name)
    return felt_course(it.conductivity_w_mk, it.density_kg_m3 * it.specific_heat_j_kgk, it.contact_m2k_w)


@cache
def courses(model: SkinModel) -> dict[str, np.ndarray]:
    """Felt temperature of every material at 10 and at 50 C, (2, steps + 1)."""
    skin = SceneSkin(model, fingers=2 * len(NAMES))
    felt = [skin.state().epidermis_c]
    for number, name in enumerate(NAMES):
        skin.touch(2 * number, Touched.of(name), 10.0)
        skin.touch(2 * number + 1, Touched.of(name), 50.0)
    felt += [skin.step().epidermis_c for _ in range(STEPS)]
    pairs = np.array(felt).T.reshape(len(NAMES), 2, -1)
    return dict(zip(NAMES, pairs, strict=True))


def worst(model: SkinModel, name: str, object_c: float, dwell_s: float) -> float:
    """Largest error of a model as a share of the tolerance."""
    low, high = courses(model)[name]
    felt = low + (object_c - 10.0) / 40.0 * (high - low)
    course = true_course(name)
    true = np.interp(TIMES_S, course.time_s, course.at(object_c))
    within = dwell_s + 1e-9 >= TIMES_S
    tolerance = np.maximum(TOLERANCE_K, TOLERANCE_SHARE * np.abs(true - true[0]))
    return float(np.max((np.abs(felt - true) / tolerance)[within]))


@pytest.mark.long
def test_the_chosen_model_is_right_enough_and_hardly_ever_larger_than_needed() -> None:
    rng = np.random.default_rng(20261122)
    too_large, chosen = [], []
    for number in range(CASES):
        name = NAMES[number % len(NAMES)]
        difference_k, dwell_s = rng.uniform(-15.0, 15.0), float(np.exp(rng.uniform(np.log(0.3), np.log(LONGEST_S))))
        choice = choose(Touched.of(name), difference_k, dwell_s)
        share = worst(choice.model, name, SURFACE_C + difference_k, dwell_s)
        assert share <= 1.0, (name, difference_k, dwell_s, choice)
        assert choice.enough
        chosen.append(choice.rung)
        if choice.rung and worst(RUNGS[choice.rung - 1], name, SURFACE_C + difference_k, dwell_s) < 0.8:
            too_large.append((name, difference_k, dwell_s, choice))
    assert len(too_large) <= 0.05 * CASES, too_large
    assert set(chosen) == {0, 1, 2}


@pytest.mark.parametrize("difference_k", [-24.0, -12.0, 10.0])
def test_metal_that_touches_well_may_need_the_largest(difference_k: float) -> None:
    """With the contact of the formula (5.4e-4 m2K/W), which the runtime holds at 1e-3."""
    iron = replace(Touched.of("iron"), contact_m2k_w=5.4e-4)
    choice = choose(iron, difference_k)
    course = felt_course(iron.conductivity_w_mk, iron.density_kg_m3 * iron.specific_heat_j_kgk, iron.contact_m2k_w)
    true = np.interp(TIMES_S, course.time_s, course.at(SURFACE_C + difference_k))
    tolerance = np.maximum(TOLERANCE_K, TOLERANCE_SHARE * np.abs(true - true[0]))
    skin = SceneSkin(choice.model, fingers=1)
    felt = [skin.state().epidermis_c[0]]
    skin.touch(0, iron, SURFACE_C + difference_k)
    felt += [skin.step().epidermis_c[0] for _ in range(STEPS)]
    assert float(np.max(np.abs(np.array(felt) - true) / tolerance)) <= 1.0
    assert choice.rung == (3 if abs(difference_k) > 20.0 else choice.rung)


@pytest.mark.parametrize("name", ["copper", "ceramic_tile", "pvc", "pu_foam"])
def test_skin_at_rest_is_the_references(name: str) -> None:
    assert rest(Body()).layers_c[0] == pytest.approx(true_course(name).low[0], abs=1e-3)


def test_small_differences_need_little_and_large_ones_of_metal_most() -> None:
    assert choose(Touched.of("iron"), 0.9).model == RUNGS[0]
    assert choose(Touched.of("pvc"), -8.0).model == RUNGS[1]
    assert choose(Touched.of("copper"), -9.0).rung >= 2
    beyond = choose(replace(Touched.of("copper"), contact_m2k_w=4e-4), -90.0)
    assert (beyond.rung, beyond.enough) == (len(RUNGS) - 1, False)
    assert "not for 90.0 K" in beyond.why


def test_a_shorter_touch_never_needs_more() -> None:
    table = rung_table()
    assert np.all(np.diff(table.ln_largest_k, axis=3) <= 1e-12)


@pytest.mark.long
def test_a_finger_gets_the_chosen_model_and_nothing_once_it_is_at_rest() -> None:
    skin = SceneSkin(fingers=2)
    before = skin.state()
    assert skin.models == [None, None]
    skin.touch(0, Touched.of("aluminium"), 15.0)
    for _ in range(300):
        cold = skin.step()
    assert cold.epidermis_c[0] < before.epidermis_c[0] - 5.0
    assert skin.models == [choose(Touched.of("aluminium"), 15.0 - SURFACE_C).model, None]
    skin.touch(0, None, 0.0)
    skin.touch(0, None, 0.0)
    felt = [skin.step().epidermis_c[0]]
    while skin.models[0] is not None:
        felt.append(skin.step().epidermis_c[0])
        assert len(felt) < 60_000
    assert abs(felt[-1] - before.epidermis_c[0]) <= AT_REST_K
    after = skin.step()
    assert abs(after.epidermis_c[0] - felt[-1]) <= AT_REST_K
    assert after.flux_w_m2[0] == before.flux_w_m2[0]


@pytest.mark.parametrize("better", ["ceramic_tile", "aluminium", "copper"])
@pytest.mark.parametrize("since_s", [0.05, 0.5, 3.0])
def test_a_larger_model_in_mid_touch_makes_no_bump(better: str, since_s: float) -> None:
    """An estimate that becomes another material: the felt temperature continues where it was."""
    skin, plain = SceneSkin(fingers=1), SceneSkin(RUNGS[-1], fingers=1)
    for one in (skin, plain):
        one.touch(0, Touched.of("pine"), 26.0)
        for _ in range(round(since_s / STEP_S)):
            before = one.step()
        if one is skin:
            felt, small = before, skin.models[0]
        one.touch(0, Touched.of(better), 20.0)
    assert small is not None
    assert skin.models[0] is not None
    assert skin.models[0].states > small.states
    assert skin.state().epidermis_c[0] == pytest.approx(felt.epidermis_c[0], abs=1e-9)
    for _ in range(500):
        difference = abs(skin.step().epidermis_c[0] - plain.step().epidermis_c[0])
        assert difference <= max(TOLERANCE_K, TOLERANCE_SHARE * abs(plain.state().epidermis_c[0] - felt.epidermis_c[0]))
