"""Readings that arrive irregularly are timed by the sensor's own regularity."""

from itertools import pairwise

import numpy as np
import pytest

from remote_site.reading_clock import LOST_S, READING_S, STEP_S, ReadingClock


def times(arrived_s: list[float], numbers: list[int] | None = None) -> list[float]:
    clock = ReadingClock()
    return [clock.step(t, n) for n, t in zip(numbers or range(len(arrived_s)), arrived_s, strict=True)]


def test_jitter_of_the_way_is_not_the_readings() -> None:
    late = np.random.default_rng(0).uniform(0.0, 0.008, 400)
    taken = times((READING_S * np.arange(400) + late).tolist())
    gaps = np.diff(taken)
    assert np.abs(gaps - READING_S).max() < 2.0 * STEP_S
    assert np.mean(np.abs(gaps - READING_S) < 1e-9) > 0.8
    assert taken[-1] - 399 * READING_S == pytest.approx(late.mean(), abs=2.0 * STEP_S)


def test_a_reading_that_was_overtaken_leaves_its_time() -> None:
    taken = times([0.0, 0.010, 0.030, 0.040], [0, 1, 3, 4])
    assert taken == pytest.approx([0.0, 0.010, 0.030, 0.040])


def test_a_sensor_that_runs_a_little_fast_is_followed() -> None:
    arrived = (0.99 * READING_S * np.arange(1000)).tolist()
    taken = times(arrived)
    assert max(abs(a - b) for a, b in zip(arrived, taken, strict=True)) < 0.004
    assert all(b > a for a, b in pairwise(taken))


@pytest.mark.parametrize("off_s", [2.0 * LOST_S, 5.0])
def test_after_a_pause_the_count_begins_anew(off_s: float) -> None:
    taken = times([0.0, 0.010, 0.020 + off_s, 0.030 + off_s])
    assert taken == pytest.approx([0.0, 0.010, 0.020 + off_s, 0.030 + off_s])
