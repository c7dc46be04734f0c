"""Each way in which a touch can fail to show its material gets its kind of answer, never a wrong name."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from common.wire.messages import OBJECT_UNKNOWN_SD_K, ThermalReason, ThermalStatus
from remote_site.thermal.thermal_identification import ThermalKnowledge
from remote_site.thermal.thermal_result import ThermalResult
from tests.unit.remote_site.made_touches import (
    MATERIALS,
    MadeMaterial,
    MadeSensor,
    MadeTouch,
    made_touches,
    pressed,
    true_table,
)
from tests.unit.remote_site.played_touches import Change, Hand, names, play

# --- small temperature difference ---


@pytest.mark.long
@pytest.mark.parametrize("name", MATERIALS)
@pytest.mark.parametrize("off_k", [-0.3, 0.3])
def test_no_temperature_difference(knowledge: ThermalKnowledge, name: str, off_k: float) -> None:
    (touch,) = made_touches(name, 1, seed=1, seconds=3.0, object_c=33.0 + off_k)
    answers = play(knowledge, touch)
    assert names(answers) == set()
    assert (answers[-1].status, answers[-1].reason) == (ThermalStatus.UNIDENTIFIABLE, ThermalReason.NO_DIFFERENCE)


@pytest.mark.long
def test_a_second_start_temperature_adds_information(knowledge: ThermalKnowledge) -> None:
    hand = Hand(knowledge, made_touches("stone", 2, seed=2, seconds=3.0, start_c=np.array([31.0, 37.0]), object_c=31.0))
    joint = hand.play()[-1]
    assert hand.fingers[0].answer.reason == ThermalReason.NO_DIFFERENCE
    assert joint is not None
    assert (joint.best, joint.reason) == ("stone", ThermalReason.NONE)
    assert joint.object_c == pytest.approx(31.0, abs=0.3)


# --- contact lost ---


@pytest.mark.long
def test_a_contact_lost_early_gives_no_result_and_one_lost_late_keeps_the_name(knowledge: ThermalKnowledge) -> None:
    (touch,) = made_touches("metal", 1, seed=3, seconds=6.0)
    early = play(knowledge, touch, lambda t, c, f: (t, c, f if t < 0.15 else 0.0))[-1]
    assert (early.status, early.reason) == (ThermalStatus.UNIDENTIFIABLE, ThermalReason.CONTACT_LOST)
    assert early.object_c is early.effusivity is None
    late = play(knowledge, touch, lambda t, c, f: (t, c, f if t < 5.0 else 0.0))[-1]
    assert (late.status, late.material, late.reason) == (ThermalStatus.IDENTIFIED, "metal", ThermalReason.CONTACT_LOST)


def test_a_moment_without_force_is_no_loss(knowledge: ThermalKnowledge) -> None:
    (touch,) = made_touches("stone", 1, seed=4, seconds=2.0)
    answers = play(knowledge, touch, lambda t, c, f: (t, c, 0.0 if 1.0 <= t < 1.03 else f))
    assert answers[-1].reason is ThermalReason.NONE
    assert answers[-1].best == "stone"


@pytest.mark.long
@pytest.mark.parametrize("name", MATERIALS)
def test_contact_that_is_lost_while_the_force_stays(knowledge: ThermalKnowledge, name: str) -> None:
    """The course has a kink that no material makes: noticed as a misfit, not averaged into another material."""
    (touch,) = made_touches(name, 1, seed=5, force=lambda t: np.where(t < 2.0, pressed()(t), 0.0))
    answers = play(knowledge, touch, lambda t, c, f: (t, c, 1.2 if t >= 2.0 else f))
    assert names(answers) <= {name}
    assert answers[-1].status is not ThermalStatus.IDENTIFIED


BORNE: dict[str, dict[str, Any]] = {
    "less pressure in the end": {"seed": 6, "force": lambda t_s: np.where(t_s < 1.5, pressed()(t_s), 0.5)},
    "more pressure in the end": {"seed": 6, "force": lambda t_s: np.where(t_s < 1.5, pressed()(t_s), 3.0)},
    "a light touch": {"seed": 8, "force": pressed(0.45)},
    "a slow approach": {"seed": 10, "force": pressed(1.2, ramp_s=0.4)},
    "a little more lag and leak": {"seed": 11, "sensor": MadeSensor(leak_w_m2k=88.0, lag_s=0.32)},
}


@pytest.mark.long
@pytest.mark.parametrize("how", BORNE)
def test_effects_within_or_near_the_model_change_no_name(knowledge: ThermalKnowledge, how: str) -> None:
    for name in MATERIALS:
        answers = play(knowledge, made_touches(name, 1, seconds=3.0, **BORNE[how])[0])
        assert names(answers) <= {name}
        assert answers[-1].best == name


# --- partial contact ---


@pytest.mark.long
def test_a_partial_contact_is_never_another_material(knowledge: ThermalKnowledge) -> None:
    """With 30 % of the area stone conducts like plastic: a set that holds stone, or unknown, but not `plastic`."""
    stone = MATERIALS["stone"]
    part = MadeMaterial(0.3 * stone.effusivity, 0.3 * stone.conductance_w_m2k, piece_sd=0.0)
    for touch in made_touches("stone", 2, seed=7, material=part):
        assert "plastic" not in names(play(knowledge, touch))


# --- onset ---


@pytest.mark.long
@pytest.mark.parametrize("late_s", [-0.04, -0.01, 0.01, 0.04])
def test_heat_and_force_need_not_begin_together(knowledge: ThermalKnowledge, late_s: float) -> None:
    """One reading apart changes nothing; four are more than the table knows of, and may cost the name."""
    for name in MATERIALS:
        (touch,) = made_touches(name, 1, seed=9, seconds=3.0)
        shifted = np.interp(touch.time_s - late_s, touch.time_s, touch.sensor_c)
        answers = play(knowledge, replace(touch, sensor_c=shifted))
        assert names(answers) <= {name}
        if abs(late_s) < 0.02:
            assert answers[-1].best == name
            assert answers[-1].status is not ThermalStatus.UNKNOWN


@pytest.mark.long
def test_a_sensor_that_is_not_the_tables_is_a_misfit(knowledge: ThermalKnowledge) -> None:
    """Readings ten times as noisy as calibrated: nothing is named from them."""
    for name in MATERIALS:
        answers = play(knowledge, made_touches(name, 1, seed=12, seconds=3.0, sensor=MadeSensor(noise_k=0.3))[0])
        assert names(answers) == set()
        assert (answers[-1].status, answers[-1].reason) == (ThermalStatus.UNKNOWN, ThermalReason.NO_FIT)


def test_readings_that_jump_state_no_temperature(knowledge: ThermalKnowledge) -> None:
    """Without this, -54.6 C with a standard deviation of 0.3 K was stated for an object of 21.4 C."""
    (touch,) = made_touches("metal", 1, seed=3)
    answers = play(knowledge, touch, lambda t, c, f: (t, c - 3.0 if t > 1.0 else c, f))
    assert answers[-1].reason is ThermalReason.NO_FIT
    assert answers[-1].object_c_sd == OBJECT_UNKNOWN_SD_K


# --- materials that were not calibrated ---


STRANGERS = [MadeMaterial(110.0, 500.0), MadeMaterial(900.0, 1200.0), MadeMaterial(5500.0, 2000.0)]
"""At least 0.6 in ln effusivity away from all calibrated ones."""


@pytest.fixture(scope="module")
def strange(knowledge: ThermalKnowledge) -> list[tuple[MadeTouch, list[ThermalResult]]]:
    return [
        (touch, play(knowledge, touch))
        for stranger in STRANGERS
        for touch in made_touches("stranger", 20, seed=13, seconds=5.0, material=stranger)
    ]


Strange = list[tuple[MadeTouch, list[ThermalResult]]]


@pytest.mark.long
def test_an_untrained_material_is_unknown_in_the_end_with_its_effusivity(strange: Strange) -> None:
    ends = [(touch, answers[-1]) for touch, answers in strange]
    assert [answer.status for _, answer in ends].count(ThermalStatus.UNKNOWN) >= 0.9 * len(ends)
    for touch, answer in ends:
        assert answer.effusivity is not None
        assert answer.effusivity_ln_sd is not None
        off = abs(np.log(answer.effusivity / touch.effusivity))
        assert off < max(3.0 * answer.effusivity_ln_sd, 0.2)


@pytest.mark.long
def test_an_untrained_material_is_rarely_mistaken_for_a_calibrated_one_during_a_touch(strange: Strange) -> None:
    taken = [names(answers) for _, answers in strange]
    assert sum(map(bool, taken)) <= 0.05 * len(taken), taken


@pytest.mark.long
def test_no_hypothesis_is_dropped_for_one_overshooting_step() -> None:
    """Exact readings make a step of the solver look impossible for a moment; what it leads to may be the truth."""
    quiet = MadeSensor(noise_k=0.005)
    exact = {
        name: MadeMaterial(made.effusivity, made.conductance_w_m2k, piece_sd=0.013, contact_sd=0.15)
        for name, made in MATERIALS.items()
    }
    steady = {"start_sd_k": 0.007, "ln_lag_sd": 0.01, "back_sd_k": 0.05}
    knowledge = ThermalKnowledge.of(true_table(exact, quiet).model_copy(update=steady))
    near_metal = MadeMaterial(21_000.0, 2100.0, piece_sd=0.013, contact_sd=0.15)
    for touch in made_touches("stranger", 16, seed=5, seconds=7.0, sensor=quiet, material=near_metal):
        assert play(knowledge, touch)[-1].status is ThermalStatus.UNKNOWN


# --- thin objects ---


@pytest.mark.long
@pytest.mark.parametrize(("slab_s", "fits_none"), [(1.0, 1), (2.0, 2), (4.0, 3), (9.0, 2)])
@pytest.mark.parametrize("name", MATERIALS)
def test_thin_pieces_of_a_material_calibrated_thick_fit_no_model(
    knowledge: ThermalKnowledge, name: str, slab_s: float, fits_none: int
) -> None:
    """Once they are warm throughout, another material and temperature explain the readings: 8 K off, with +-0.1 K."""
    thin = replace(MATERIALS[name], slab_s=slab_s)
    answers = [play(knowledge, touch) for touch in made_touches(name, 3, seed=31, material=thin)]
    assert all(names(each) <= {name} for each in answers)
    ends = [each[-1] for each in answers if each[-1].reason is ThermalReason.NO_FIT]
    assert len(ends) >= fits_none
    assert {(end.status, end.object_c_sd) for end in ends} == {(ThermalStatus.UNKNOWN, OBJECT_UNKNOWN_SD_K)}


@pytest.mark.long
def test_thin_pieces_that_were_calibrated_thin_are_named() -> None:
    materials = {**MATERIALS, "metal": MadeMaterial(14000.0, 2200.0, slab_s=0.5)}
    thin = ThermalKnowledge.of(true_table(materials))
    ends = [play(thin, touch)[-1].best for touch in made_touches("metal", 3, seed=15, material=materials["metal"])]
    assert ends == ["metal"] * 3


# --- near ties ---


def test_indistinguishable_materials_are_a_set() -> None:
    """PVC and oak: 3 % of effusivity between them."""
    twins = {
        **MATERIALS,
        "oak": MadeMaterial(488.0, 900.0, piece_sd=0.1),
        "plastic": MadeMaterial(475.0, 900.0, piece_sd=0.1),
    }
    tied = ThermalKnowledge.of(true_table(twins))
    for name in ("oak", "plastic"):
        (touch,) = made_touches(name, 1, seed=16, material=twins[name])
        answers = play(tied, touch)
        assert names(answers) == set()
        assert answers[-1].status is ThermalStatus.AMBIGUOUS
        assert set(answers[-1].candidates) == {"oak", "plastic"}
        assert answers[-1].effusivity == pytest.approx(touch.effusivity, rel=0.3)


# --- sensor faults ---


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (lambda t, c, f: (t, c if t < 0.15 else np.nan, f), ThermalReason.NOT_A_NUMBER),
        (lambda t, c, f: (t, 33.0, f), ThermalReason.READING_STUCK),
        (lambda t, c, f: (t if t < 0.15 else t + 0.5, c, f), ThermalReason.READINGS_MISSING),
        (lambda t, c, f: (t if t < 0.15 else t - 0.1, c, f), ThermalReason.READINGS_MISSING),
        (lambda t, c, f: (t if t < 0.15 else np.nan, c, f), ThermalReason.READINGS_MISSING),
    ],
    ids=["no number", "flat", "gap", "clock set back", "no time"],
)
def test_a_sensor_fault_is_no_material(knowledge: ThermalKnowledge, change: Change, reason: ThermalReason) -> None:
    answer = play(knowledge, made_touches("stone", 1, seed=17, seconds=2.0)[0], change)[-1]
    assert answer.status is ThermalStatus.UNIDENTIFIABLE
    assert answer.material is None
    assert answer.reason is reason


@pytest.mark.long
def test_a_fault_late_in_a_touch_keeps_the_name(knowledge: ThermalKnowledge) -> None:
    (touch,) = made_touches("stone", 1, seed=17, seconds=6.0)
    answer = play(knowledge, touch, lambda t, c, f: (t, c if t < 5.0 else np.nan, f))[-1]
    assert (answer.status, answer.material) == (ThermalStatus.IDENTIFIED, "stone")
    assert answer.reason is ThermalReason.NOT_A_NUMBER


@pytest.mark.long
@pytest.mark.parametrize("name", MATERIALS)
def test_readings_cut_off_by_saturation_are_no_other_material(knowledge: ThermalKnowledge, name: str) -> None:
    """The converter ends at 31 C, and the plate began at 33 C."""
    (touch,) = made_touches(name, 1, seed=18, seconds=4.0)
    assert names(play(knowledge, replace(touch, sensor_c=np.minimum(touch.sensor_c, 31.0)))) <= {name}
