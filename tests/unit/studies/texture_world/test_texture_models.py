"""Haptic texture models: reading, line spectral frequencies, interpolation, and the power of what is rendered."""

import numpy as np
import pytest
from scipy.signal import lfilter

from studies.running import Unavailable
from studies.texture_world.models import polynomials, read_model, read_models
from studies.texture_world.strokes import LONGEST_S, own_ln_rms, rendered, stroke_over
from tests.unit.studies.texture_world.made_models import models_in, write_model


@pytest.fixture(scope="module")
def model(tmp_path_factory):
    path = tmp_path_factory.mktemp("models") / "one.xml"
    write_model(path, "made", 3)
    return read_model(path)


@pytest.mark.parametrize("order", [4, 5, 10])
def test_frequencies_give_the_polynomial_that_they_came_from(order):
    chance = np.random.default_rng(order)
    poles = 0.8 * chance.uniform(0.3, 1.0, order // 2) * np.exp(1j * chance.uniform(0.2, 2.9, order // 2))
    roots = [*poles, *poles.conj(), *([0.4] if order % 2 else [])]
    coefficients = np.real(np.poly(roots))
    longer, mirrored = np.append(coefficients, 0.0), np.append(0.0, coefficients[::-1])
    angles = np.concatenate([np.angle(np.roots(longer + mirrored)), np.angle(np.roots(longer - mirrored))])
    lsf = np.sort(angles[(angles > 1e-6) & (angles < np.pi - 1e-6)])
    assert len(lsf) == order
    assert polynomials(lsf[None])[0] == pytest.approx(coefficients, abs=1e-9)


def test_a_point_has_its_own_model_and_between_points_it_is_mixed(model):
    found = model.at(np.array([100.0, 160.0, 220.0]), np.array([1.5, 1.5, 1.5]))
    assert found.deviation[0] ** 2 == pytest.approx(model.variance[4])
    assert found.denominator[0] == pytest.approx(polynomials(model.ar_lsf[4:5])[0])
    assert found.deviation[1] ** 2 == pytest.approx(0.5 * (model.variance[4] + model.variance[5]))
    beyond = model.at(np.array([500.0]), np.array([9.0]))
    assert beyond.deviation[0] ** 2 == pytest.approx(model.variance[-1])


@pytest.mark.long
def test_a_rendered_stroke_has_the_power_of_its_model(model):
    speed, force = np.full(200_000, 150.0), np.full(200_000, 2.0)
    sensed = rendered(model, speed, force, np.random.default_rng(1))
    assert sensed[1000:].std() == pytest.approx(model.at(speed[:1], force[:1]).rms()[0], rel=0.03)


def test_a_filter_that_changes_keeps_its_state(model):
    speed, force = np.full(1000, 150.0), np.full(1000, 2.0)
    arma = model.at(speed[:1], force[:1])
    excitation = arma.deviation[0] * np.random.default_rng(2).standard_normal(1000)
    whole = lfilter(arma.numerator[0], arma.denominator[0], excitation)
    assert rendered(model, speed, force, np.random.default_rng(2)) == pytest.approx(whole)


def test_a_stroke_rests_first_and_has_its_own_speed_and_force(model):
    one, again, other = (stroke_over(model, 1, 0, number) for number in (2, 2, 3))
    assert one.acceleration_m_s2 == pytest.approx(again.acceleration_m_s2)
    assert one.speed_mm_s[:500].max() == 0.0
    assert one.speed_mm_s.max() != pytest.approx(other.speed_mm_s.max(), rel=0.01)
    assert one.spectrum(LONGEST_S).seconds == LONGEST_S
    assert np.isfinite(own_ln_rms(model))


def test_what_is_no_model_is_refused(tmp_path):
    with pytest.raises(Unavailable, match="no texture models"):
        read_models(tmp_path)
    write_model(tmp_path / "whole.xml", "made", 1)
    whole = (tmp_path / "whole.xml").read_text()
    for name, text, why in (
        ("cut.xml", whole[:200], "no haptic texture model"),
        ("nameless.xml", whole.replace("material>", "other>"), "<material> is missing"),
        ("word.xml", whole.replace("<var>0.0", "<var>no", 1), "could not convert"),
        ("gone.xml", whole.replace("<tri>", "<not>").replace("</tri>", "</not>"), "no triangle"),
        ("square.xml", whole.replace("</tri>", "<value>1</value></tri>"), "no triangle"),
        ("beyond.xml", whole.replace("<speedList><value>0.0", "<speedList><value>1e999", 1), "not a finite number"),
        ("unknown.xml", whole.replace("<gain>2.0", "<gain>nan", 1), "not a finite number"),
        ("negative.xml", whole.replace("<var>0.0", "<var>-1.0", 1), "a negative variance"),
    ):
        (tmp_path / name).write_text(text)
        with pytest.raises(ValueError, match=f"{name}: no haptic texture model.*") as error:
            read_model(tmp_path / name)
        assert why in str(error.value)


def test_models_are_in_the_order_of_their_files(tmp_path):
    found = read_models(models_in(tmp_path / "some", 3))
    assert [model.material for model in found] == ["made 0", "made 1", "made 2"]
