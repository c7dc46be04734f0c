"""Speeds and position spread of a finger from noisy, quantised positions at uneven times."""

import math

import numpy as np
import pytest

from common.exploration.approach_speed import ApproachSpeed
from common.exploration.hand_motion import HandMotion
from common.exploration.position_spread import EVERY_S, SPREAD_WINDOW_S, PositionSpread

TICK_S = 0.002


@pytest.mark.parametrize("step_m", [20e-6, 60e-6])
def test_stroke_speed_survives_quantisation(step_m: float) -> None:
    motion, speeds = HandMotion(), []
    for tick in range(100):
        time_s = TICK_S * tick
        motion.step(time_s, round(0.03 * time_s / step_m) * step_m, round(-0.04 * time_s / step_m) * step_m)
        speeds.append(motion.speed_m_s)
    assert max(abs(v - 0.05) for v in speeds[15:]) < 0.1 * step_m / 2e-3 + 0.001


def test_a_still_hand_is_slow_with_three_times_the_noise() -> None:
    draw, motion, speeds = np.random.default_rng(0), HandMotion(), []
    for tick in range(5000):
        x_m, y_m = np.round(30e-6 * draw.standard_normal(2) / 60e-6) * 60e-6
        motion.step(TICK_S * tick, x_m, y_m)
        speeds.append(motion.speed_m_s)
    assert np.quantile(speeds[15:], 0.999) < 0.007


@pytest.mark.parametrize("speed_m_s", [0.02, 0.05, 0.1, 0.3])
def test_the_approach_speed_tolerates_repeated_and_late_readings(speed_m_s: float) -> None:
    """Devices and loop keep their own time: a tick may get the last reading again, and the next one two at once."""
    draw, shares = np.random.default_rng(1), []
    for _ in range(200):
        descent, phase = ApproachSpeed(), draw.uniform()
        for tick in range(12):
            time_s = TICK_S * (tick + phase) + draw.uniform(0.0, 0.001)
            descent.step(time_s, round(-speed_m_s * TICK_S * (time_s // TICK_S) / 5e-6) * 5e-6)
        shares.append(descent.speed_m_s / speed_m_s)
    assert abs(np.mean(shares) - 1.0) < 0.03
    assert np.quantile(np.abs(np.array(shares) - 1.0), 0.95) < 0.15


def test_late_ticks_and_a_clock_set_back() -> None:
    motion, descent = HandMotion(), ApproachSpeed()
    for time_s in (0.0, 0.002, 0.004, 0.060):
        motion.step(time_s, 0.05 * time_s, 0.0)
        descent.step(time_s, -0.05 * time_s)
    assert motion.speed_m_s == pytest.approx(0.05)
    assert descent.speed_m_s == pytest.approx(0.05)
    for time_s in (0.5, 0.4, 0.4):
        motion.step(time_s, 1.0, 0.0)
        descent.step(time_s, 1.0)
    assert (motion.speed_m_s, descent.speed_m_s) == (0.0, 0.0)


def test_position_spread_distinguishes_a_shaking_finger_from_a_travelling_one() -> None:
    shaking, going = PositionSpread(), PositionSpread()
    for tick in range(500):
        time_s = TICK_S * tick
        shaking.step(time_s, 0.5e-3 * math.sin(2.0 * math.pi * 8.0 * time_s), 0.0)
        going.step(time_s, 0.010 * time_s, 0.0)
    assert 0.4e-3 < shaking.reach_m() < 0.6e-3
    assert going.reach_m() == pytest.approx(0.5 * 0.010 * SPREAD_WINDOW_S, rel=0.1)
    assert going.away_m(0.010 * 0.998, 0.0) == pytest.approx(going.reach_m(), rel=0.15)


def test_position_spread_needs_time_and_forgets() -> None:
    spread = PositionSpread()
    for tick in range(round(SPREAD_WINDOW_S / TICK_S) - 10):
        spread.step(TICK_S * tick, 0.01 * (tick < 50), 0.0)
    assert spread.reach_m() == math.inf
    assert spread.away_m(0.0, 0.0) > 1e-3
    assert spread.away_m(0.0, 0.0, TICK_S * 60) == 0.0
    spread.step(0.0, 0.02, 0.0)
    assert spread.away_m(0.02, 0.0) == 0.0, "a clock set back starts over"
    assert spread.away_m(0.02, 0.0, EVERY_S) == 0.0, "the newest place is kept"
