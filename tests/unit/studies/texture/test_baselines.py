"""Band powers and moments of known signals, and classes that the classifiers distinguish."""

import numpy as np
import pytest

from studies.texture.baselines import BANDS, band_powers, classifiers, moments


@pytest.mark.parametrize("rate_hz", [35.7, 2000.0])
def test_a_tone_is_in_its_band(rate_hz):
    time_s = np.arange(1000) / rate_hz
    tone_hz = 0.5 * rate_hz * 2.0**-2.25
    powers = band_powers(np.sin(2.0 * np.pi * tone_hz * time_s), rate_hz)
    assert len(powers) == BANDS
    assert np.argmax(powers) == BANDS - 5


def test_signals_stand_beside_each_other():
    noise = np.random.default_rng(0).normal(size=(300, 2)) * [1.0, 10.0]
    assert band_powers(noise, 100.0) == pytest.approx(
        np.concatenate([band_powers(noise[:, 0], 100.0), band_powers(noise[:, 1], 100.0)])
    )
    assert moments(noise)[[1, 6]] == pytest.approx(np.log([1.0, 10.0]), abs=0.15)


def test_a_flat_or_short_signal_has_finite_features():
    assert np.isfinite(band_powers(np.full(20, 3.3), 35.7)).all()
    assert moments(np.full(20, 3.3))[[0, 2, 3]] == pytest.approx([3.3, 0.0, 0.0])
    with pytest.raises(ValueError, match="16 samples"):
        moments(np.zeros(15))


@pytest.mark.long
def test_both_classifiers_tell_loud_from_soft():
    chance = np.random.default_rng(1)
    loud = [k % 2 for k in range(40)]
    rows = np.array([band_powers(chance.normal(size=200) * (1.0 + one), 100.0) for one in loud])
    for name, classifier in classifiers().items():
        classifier.fit(rows[:20], loud[:20])
        assert list(classifier.predict(rows[20:])) == loud[20:], name
