"""The plate's temperature at contact, from the readings before."""

import numpy as np
import pytest

from remote_site.thermal.touch_start import READING_S, SHORT, WARMING, reading_at_contact

NOISE_K = 0.02


def lines(reading_k: np.ndarray, count: int = 400) -> np.ndarray:
    """Reading at contact and slope, (count, 2), of noisy readings."""
    rng = np.random.default_rng(0)
    noisy = reading_k + NOISE_K * rng.normal(size=(count, len(reading_k)))
    return np.array([reading_at_contact(row.tolist()) for row in noisy])


@pytest.mark.parametrize("slope_k_s", [0.0, -0.3])
def test_a_plate_at_rest_is_known_from_the_longer_line(slope_k_s: float) -> None:
    found = lines(30.0 + slope_k_s * READING_S * np.arange(1 - WARMING, 1))
    assert found.mean(axis=0) == pytest.approx([30.0, slope_k_s], abs=0.01)
    from_short = 2.0 * np.sqrt(3.0) * NOISE_K / (SHORT * READING_S * np.sqrt(SHORT))
    assert found[:, 1].std() < 0.7 * from_short


def test_a_plate_whose_heater_was_just_switched_is_known_from_the_shorter_line() -> None:
    before_s = READING_S * np.arange(1 - WARMING, 1)
    found = lines(np.where(before_s < -READING_S * SHORT, 30.0 + 2.0 * (before_s + READING_S * SHORT), 30.0))
    assert np.abs(found[:, 0] - 30.0).max() < 5.0 * NOISE_K
    assert np.abs(found[:, 1]).mean() < 0.3


def test_few_readings_give_no_slope() -> None:
    assert reading_at_contact([29.0] * 3 + [30.0] * 5) == (30.0, 0.0)
    with pytest.raises(ValueError, match="no reading"):
        reading_at_contact([])
