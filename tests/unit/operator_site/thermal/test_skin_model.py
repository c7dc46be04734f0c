"""The three-layer finger against a fine grid, against closed form, and in mid-contact changes."""

import math

import numpy as np
import pytest
from scipy.special import erfcx

from common.scenes.materials import material
from operator_site.thermal.scene_skin import SceneSkin, touched_object
from operator_site.thermal.skin_model import SkinModel, Touched, contact_resistance_m2k_w, ladder_m, skin_step
from operator_site.thermal.tissue import Body

FINE = SkinModel(60, 60, 70, 100)
USUAL = SkinModel(4, 1, 1, 6)


def felt(model: SkinModel, name: str, object_c: float, steps: int = 1000) -> np.ndarray:
    skin = SceneSkin(model, fingers=1)
    start = skin.state().epidermis_c[0]
    skin.touch(0, Touched.of(name), object_c)
    return np.array([start, *(skin.step().epidermis_c[0] for _ in range(steps))])


@pytest.mark.parametrize("name", ["aluminium", "ceramic_tile", "pvc", "pine"])
@pytest.mark.parametrize("object_c", [25.0, 15.0, 40.0])
def test_felt_temperature_agrees_with_a_fine_grid(name, object_c):
    reference = felt(FINE, name, object_c)
    tolerance = np.maximum(0.1, 0.1 * np.abs(reference - reference[0]))
    error = np.abs(felt(USUAL, name, object_c) - reference)
    assert np.max(error / tolerance) <= 1.0


def test_flux_into_a_fine_grid_is_that_of_two_half_spaces_at_first():
    skin = SceneSkin(FINE, Body(deep_c=33.0, arterial_c=33.0, air_c=33.0), fingers=1)
    skin.touch(0, Touched.of("pvc"), 23.0)
    e_skin, e_object = math.sqrt(0.24 * 1200.0 * 3590.0), material("pvc").effusivity
    r_c = contact_resistance_m2k_w(material("pvc").conductivity_w_mk)
    for step in range(1, 31):  # heat has not reached the dermis
        flux = skin.step().flux_w_m2[0]
        b = (e_skin + e_object) / (r_c * e_skin * e_object)
        assert flux == pytest.approx(-10.0 / r_c * erfcx(b * math.sqrt(step * 0.01)), rel=0.02)


def test_start_is_the_steady_state_of_a_free_finger():
    skin = SceneSkin()
    before = skin.state()
    assert 32.0 <= before.surface_c[0] <= 34.0
    for _ in range(500):
        after = skin.step()
    assert np.allclose(after.epidermis_c, before.epidermis_c, atol=1e-9)
    assert before.flux_w_m2[0] == pytest.approx(10.0 * (25.0 - before.surface_c[0]))


def test_heat_is_conserved_in_contact():
    """What leaves the object arrives in the tissue, but for what blood and deep tissue take."""
    step = skin_step(USUAL, Touched.of("aluminium"))
    # With everything as warm as the skin at rest, and no flux there, nothing may change.
    assert np.allclose(step.a @ np.zeros(12) + step.b @ np.zeros(2), 0.0)
    it, tissue = Touched.of("aluminium"), USUAL.tissue
    heat = np.concatenate((tissue.heat_j_m2k, ladder_m(6, it) * it.density_kg_m3 * it.specific_heat_j_kgk))
    x = np.concatenate((np.zeros(6), np.full(6, -10.0)))
    after = step.a @ x
    lost = float(heat[:6] @ after[:6])
    won = float(heat[6:] @ (after - x)[6:])
    assert lost < -1.0
    assert won == pytest.approx(-lost, rel=1e-4)


def test_each_finger_has_its_own_object():
    skin = SceneSkin(USUAL)
    for finger, name in enumerate(("copper", "ceramic_tile", "pvc", "pu_foam")):
        skin.touch(finger, Touched.of(name), 20.0)
    for _ in range(200):
        state = skin.step()
    assert list(np.argsort(state.epidermis_c)) == [0, 1, 2, 3, 4]
    assert skin.models == [USUAL] * 5, "a fixed model stays"
    alone = felt(USUAL, "pvc", 20.0, 200)
    assert state.epidermis_c[2] == pytest.approx(alone[-1])


def test_better_estimates_in_mid_contact_make_no_step_and_reach_the_same_end():
    skin = SceneSkin(fingers=1)
    skin.touch(0, Touched.of("ceramic_tile"), 27.0)
    for _ in range(100):
        before = skin.step()
    skin.touch(0, Touched.of("aluminium"), 25.0)
    after = skin.step()
    assert abs(after.epidermis_c[0] - before.epidermis_c[0]) < 0.1
    for _ in range(900):
        end = skin.step().epidermis_c[0]
    assert end == pytest.approx(felt(USUAL, "aluminium", 25.0)[-1], abs=0.4)


@pytest.mark.parametrize("name", ["pine", "pvc", "copper"])
def test_short_interruptions_of_a_contact_leave_the_felt_temperature(name: str) -> None:
    """Lost packets end a contact for 0.1 s or more; the object keeps the heat that it took from the finger."""
    steady, interrupted = SceneSkin(fingers=1), SceneSkin(fingers=1)
    for step in range(1000):
        steady.touch(0, Touched.of(name), 15.0)
        interrupted.touch(0, None if step % 150 > 135 else Touched.of(name), 15.0)
        felt_c, after_c = steady.step().epidermis_c[0], interrupted.step().epidermis_c[0]
    assert after_c == pytest.approx(felt_c, abs=0.3)


def test_an_object_touched_again_later_has_its_own_temperature() -> None:
    skin, first = SceneSkin(fingers=1), SceneSkin(fingers=1)
    skin.touch(0, Touched.of("pvc"), 15.0)
    for _ in range(100):
        skin.step()
    skin.touch(0, None, 0.0)
    for _ in range(200):
        skin.step()
    skin.touch(0, Touched.of("pvc"), 15.0)
    first.touch(0, Touched.of("pvc"), 15.0)
    assert skin.step().flux_w_m2[0] < 0.8 * first.step().flux_w_m2[0] < 0.0


def test_without_a_ladder_the_object_keeps_its_temperature():
    model = SkinModel.parse("3")
    assert model == SkinModel(1, 1, 1, 0)
    x = felt(model, "pine", 25.0, 5000)
    assert x[-1] < felt(USUAL, "pine", 25.0, 5000)[-1] - 1.0


def test_model_names():
    for text in ("4+1+1+6", "1+1+1"):
        assert str(SkinModel.parse(text)) == text
    for text in ("", "4", "4+1", "a+1+1", "4+1+1+0", "4+1+1+6+1", "999+1+1+6", "4+-1+1+6"):
        with pytest.raises(ValueError, match="model"):
            SkinModel.parse(text)


def test_ladder_is_finest_at_the_skin():
    widths = ladder_m(6, Touched.of("pvc"))
    assert np.all(np.diff(widths) > 0.0)


def test_objects_are_known_by_their_constants_or_not_at_all():
    aluminium = touched_object(230.0, 2700.0, 900.0)
    assert aluminium is not None
    assert aluminium.conductivity_w_mk == pytest.approx(230.0, rel=0.006)
    assert aluminium == touched_object(230.3, 2701.0, 900.3)
    for constants in ((0.0, 0.0, 0.0), (0.0, 2700.0, 900.0), (230.0, 0.0, 900.0), (230.0, 2700.0, 5.0)):
        assert touched_object(*constants) is None
    assert touched_object(math.nan, 2700.0, 900.0) is None


def test_contact_resistance_falls_with_conductivity_to_a_floor() -> None:
    values = [contact_resistance_m2k_w(k) for k in (0.03, 0.2, 1.0, 50.0, 400.0)]
    assert values == sorted(values, reverse=True)
    assert values[-1] == 1e-3
    assert values[1] == pytest.approx(0.57 / 374.0)
