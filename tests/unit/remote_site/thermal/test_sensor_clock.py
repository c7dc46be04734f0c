"""Readings that arrive irregularly are timed by their sensor's own clock."""

from itertools import pairwise

import numpy as np
import pytest

from remote_site.thermal.finger_thermal import LOST_S, STEP_S, SensorClock

PERIOD_S = 0.01
WRAPS = 1 << 32


def times(arrived_s: list[float], taken_s: list[float] | None = None, powered_us: int = 0) -> list[float]:
    """Times of readings taken every 10 ms, or when the sensor says."""
    clock = SensorClock()
    taken = [PERIOD_S * n for n in range(len(arrived_s))] if taken_s is None else taken_s
    return [clock.step(a, (powered_us + round(t * 1e6)) % WRAPS) for a, t in zip(arrived_s, taken, strict=True)]


def test_jitter_of_the_transport_does_not_move_readings() -> None:
    late = np.random.default_rng(0).uniform(0.0, 0.008, 400)
    found = times((PERIOD_S * np.arange(400) + late).tolist())
    gaps = np.diff(found)
    assert np.abs(gaps - PERIOD_S).max() < 2.0 * STEP_S
    assert np.mean(np.abs(gaps - PERIOD_S) < 1e-9) > 0.8
    assert found[-1] - 399 * PERIOD_S == pytest.approx(late.mean(), abs=2.0 * STEP_S)


def test_a_reading_that_was_overtaken_leaves_its_time() -> None:
    moments = [0.0, 0.010, 0.030, 0.040]
    assert times(moments, moments) == pytest.approx(moments)


@pytest.mark.parametrize("held_up_s", [0.05, 0.5])
def test_readings_that_a_busy_machine_holds_up_keep_their_times(held_up_s: float) -> None:
    taken = PERIOD_S * np.arange(200)
    arrived = taken.copy()
    stall = (taken >= 1.0) & (taken < 1.0 + held_up_s)
    arrived[stall] = 1.0 + held_up_s
    assert times(arrived.tolist()) == pytest.approx(taken.tolist(), abs=0.013)
    assert np.abs(np.diff(times(arrived.tolist())) - PERIOD_S).max() < 2.0 * STEP_S


def test_readings_that_a_sensor_left_out_are_not_made_up() -> None:
    taken = [t for t in (PERIOD_S * np.arange(200)).tolist() if not 1.0 < t < 1.045]
    assert times(taken, taken) == pytest.approx(taken)


def test_a_sensor_that_runs_a_little_fast_is_followed() -> None:
    arrived = (0.99 * PERIOD_S * np.arange(1000)).tolist()
    found = times(arrived)
    assert max(abs(a - b) for a, b in zip(arrived, found, strict=True)) < 0.004
    assert all(b > a for a, b in pairwise(found))


def test_a_sensors_clock_may_begin_at_0_again() -> None:
    arrived = (PERIOD_S * np.arange(100)).tolist()
    assert times(arrived, powered_us=WRAPS - 500_000) == pytest.approx(arrived)


@pytest.mark.parametrize("off_s", [2.0 * LOST_S, 5.0])
def test_a_restarted_sensor_is_timed_again(off_s: float) -> None:
    found = times([0.0, 0.010, 0.020 + off_s, 0.030 + off_s], [3.0, 3.010, 3.020, 3.030])
    assert found == pytest.approx([0.0, 0.010, 0.020 + off_s, 0.030 + off_s])
