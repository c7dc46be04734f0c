"""The plate's temperature at contact, from the readings before."""

import numpy as np
import pytest

from remote_site.thermal.touch_start import READING_S, SHORT, WARMING, find_touch, reading_at_contact
from remote_site.traces.trace_files import ThermalTrace
from tests.unit.remote_site.made_touches import made_touches

NOISE_K = 0.02
BEFORE_S = (READING_S * np.arange(1 - WARMING, 1)).tolist()


def lines(reading_k: np.ndarray, count: int = 400) -> np.ndarray:
    """Reading at contact and slope, (count, 2), of noisy readings."""
    rng = np.random.default_rng(0)
    noisy = reading_k + NOISE_K * rng.normal(size=(count, len(reading_k)))
    return np.array([reading_at_contact(BEFORE_S, row.tolist()) for row in noisy])


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
    assert reading_at_contact(BEFORE_S[:8], [29.0] * 3 + [30.0] * 5) == (30.0, 0.0)
    with pytest.raises(ValueError, match="no reading"):
        reading_at_contact([], [])


def test_a_sensor_whose_clock_stands_still_gives_no_slope() -> None:
    assert reading_at_contact([5.0] * WARMING, [29.0, 31.0] * (WARMING // 2)) == (30.0, 0.0)


@pytest.mark.parametrize("step_s", [0.005, 0.01, 0.04])
def test_the_slope_is_in_kelvin_a_second_at_any_rate_of_a_recording(step_s: float) -> None:
    time_s = np.arange(0.0, 6.0, step_s)
    pressed_n = np.where(time_s >= 3.0, 1.0, 0.0)
    found = find_touch(ThermalTrace(time_s, 33.0 - 1.0 * time_s, pressed_n))
    assert found is not None
    assert found.slope_k_s == pytest.approx(-1.0, abs=1e-6)
    assert found.start_c == pytest.approx(30.0, abs=1.5 * step_s)


def test_a_logger_that_repeats_each_reading_ten_times_gives_the_same_touch() -> None:
    """Ten times as many samples are no more readings, and 50 of them no half second of warming."""
    (made,) = made_touches("metal", 1, 1, 2.0)
    slow = ThermalTrace(made.time_s, made.sensor_c, 1.1 * made.force_n, np.full(len(made.time_s), 23.0))
    columns = (slow.sensor_c, slow.force_n, slow.ambient_c)
    fast = ThermalTrace(READING_S / 10.0 * np.arange(10 * len(slow.time_s)), *(np.repeat(each, 10) for each in columns))
    expected, found = find_touch(slow), find_touch(fast)
    assert expected is not None
    assert found is not None
    assert (found.start_c, found.slope_k_s) == pytest.approx((expected.start_c, expected.slope_k_s), abs=1e-6)
    assert np.array(list(found.readings())) == pytest.approx(np.array(list(expected.readings())), abs=1e-9)
