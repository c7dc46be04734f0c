"""Spectra of surfaces at any speed and force: recognition, strangers, and the table's limits."""

import numpy as np
import pytest

from remote_site.texture.calibration.motion_spectrum_fit import fit_spectra
from remote_site.texture.motion_spectrum import EDGES_HZ, StrokeSpectrum
from remote_site.texture.recorded.stroke_spectrum import stroke_spectrum

BANDS = len(EDGES_HZ) - 1
SURFACES, STROKES = 12, 5


def surfaces(count, seed):
    """Coefficients of made-up surfaces, (count, 3, bands)."""
    chance = np.random.default_rng(seed)
    smooth = np.cumsum(chance.normal(0.0, 0.5, (count, 3, BANDS)), axis=2)
    return smooth * np.array([1.0, 0.2, 0.2])[:, None] + np.array([-6.0, 1.5, 0.5])[:, None]


def stroke(surface, chance, scatter=0.15):
    motion = np.array([1.0, chance.uniform(-0.5, 1.2), chance.uniform(-0.8, 1.0)])
    return StrokeSpectrum(motion @ surface + chance.normal(0.0, scatter, BANDS), motion, 3.0)


@pytest.fixture(scope="module")
def fitted():
    chance = np.random.default_rng(1)
    every = surfaces(SURFACES, 2)
    labels = [f"surface {number:02d}" for number in range(SURFACES) for _ in range(STROKES)]
    fit = fit_spectra([stroke(one, chance) for one in every for _ in range(STROKES)], labels)
    assert fit is not None
    return fit, every


def test_other_strokes_at_other_speeds_are_recognised(fitted):
    fit, every = fitted
    chance = np.random.default_rng(3)
    rankings = [(number, fit.spectra.rank(stroke(one, chance))) for number, one in enumerate(every) for _ in range(10)]
    assert np.mean([ranking.best == number for number, ranking in rankings]) > 0.9
    assert np.mean([ranking.known for _, ranking in rankings]) > 0.85
    assert all(ranking.probabilities.sum() == pytest.approx(1.0) for _, ranking in rankings)


def test_strokes_of_other_surfaces_are_strange(fitted):
    chance = np.random.default_rng(4)
    strange = [fitted[0].spectra.rank(stroke(one, chance)) for one in surfaces(40, 5)]
    assert np.mean([ranking.known for ranking in strange]) < 0.2


def test_left_out_strokes_are_judged_by_the_others(fitted):
    fit, _ = fitted
    assert len(fit.left_out) == SURFACES * STROKES
    assert fit.right == sum(label == answer for label, answer in fit.left_out)
    assert fit.right > 0.85 * len(fit.left_out)


def test_a_short_stroke_is_less_sure(fitted):
    fit, every = fitted
    chance = np.random.default_rng(6)
    drawn = [stroke(one, chance) for one in every]
    long = np.mean([fit.spectra.rank(one).probabilities.max() for one in drawn])
    assert np.mean([fit.spectra.rank(one._replace(seconds=0.15)).probabilities.max() for one in drawn]) < long


@pytest.mark.parametrize(("labels"), [["one"] * 4, ["one", "one", "one", "two"]])
def test_too_few_strokes_or_surfaces_give_no_spectra(labels):
    chance = np.random.default_rng(7)
    every = dict(zip(("one", "two"), surfaces(2, 8), strict=True))
    assert fit_spectra([stroke(every[label], chance) for label in labels], labels) is None


def test_a_spectrum_has_the_power_of_its_signal():
    chance = np.random.default_rng(9)
    noise = chance.normal(0.0, 0.5, 20_000)
    found = stroke_spectrum(noise, 2000.0, 0.1, 2.0)
    assert found is not None
    assert np.exp(found.ln_power) == pytest.approx(0.25 / 1000.0, rel=0.2)
    assert found.motion == pytest.approx([1.0, np.log(2.0), np.log(2.0)])
    assert found.seconds == 10.0
    assert stroke_spectrum(noise[:200], 2000.0, 0.1, 2.0) is None
