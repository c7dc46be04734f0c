"""Offset of a force sensor, and modes and contacts of a finger whose sensor has one."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from common.exploration.exploration_mode import ModeDetector
from common.exploration.force_offset import LEAST_N, MOST_N, WAY_M, ForceOffset
from common.exploration.hand_motion import HandMotion
from common.wire.messages import ExplorationMode

NOISE_N, COUNT_N = 0.011, 0.01


def offset_after(
    force_n: np.ndarray, z_m: np.ndarray, x_m: np.ndarray | None = None, *, rate_hz: float = 500.0
) -> float:
    """Largest offset of a finger on a way, N; it is the last one where it only rises."""
    offset, largest_n = ForceOffset(), 0.0
    for tick, (reading_n, at_m) in enumerate(zip(force_n.tolist(), z_m.tolist(), strict=True)):
        offset.step(tick / rate_hz, reading_n, 0.0 if x_m is None else float(x_m[tick]), 0.0, at_m)
        largest_n = max(largest_n, offset.offset_n)
    return largest_n


@given(st.floats(LEAST_N, MOST_N), st.sampled_from([250, 500, 1000]), st.sampled_from([-0.02, 0.012, 0.05]))
def test_a_finger_that_moves_in_the_air_shows_it_at_any_rate(offset_n: float, rate_hz: int, speed_m_s: float) -> None:
    z_m = speed_m_s * np.arange(round(1.5 * WAY_M / abs(speed_m_s) * rate_hz)) / rate_hz
    assert offset_after(np.full(len(z_m), offset_n), z_m, rate_hz=rate_hz) == pytest.approx(offset_n)


@given(st.floats(50.0, 20_000.0), st.floats(1e-3, 50e-3), st.sampled_from([250, 500, 1000]))
def test_no_press_is_an_offset(stiffness_n_m: float, speed_m_s: float, rate_hz: int) -> None:
    """A press of 5 N or 10 mm from the first touch on, and back."""
    deep_m = min(5.0 / stiffness_n_m, 0.010)
    depth_m = np.arange(0.0, deep_m, speed_m_s / rate_hz)
    depth_m = np.concatenate([depth_m, depth_m[::-1]])
    assert offset_after(stiffness_n_m * depth_m, -depth_m, rate_hz=rate_hz) == 0.0


@given(st.floats(50.0, 400.0), st.floats(1.0, 3.0), st.integers(0, 2**32))
@settings(max_examples=20, deadline=None)
def test_a_hand_on_soft_tissue_that_breathes_shows_hardly_an_offset(stiffness_n_m: float, p: float, seed: int) -> None:
    """A hand that presses and lifts anyhow for 20 s, with its own stiffness at a depth of 2 mm."""
    rng = np.random.default_rng(seed)
    t_s = np.arange(10_000) / 500.0
    z_m = np.interp(t_s, np.sort(rng.uniform(0.0, 20.0, 16)), rng.uniform(-6e-3, 8e-3, 16))
    breath_m = 1.5e-3 * np.sin(2.0 * np.pi * t_s * 14.0 / 60.0)
    force_n = stiffness_n_m * 2e-3 * (np.maximum(0.0, breath_m - z_m) / 2e-3) ** p
    noise_n = NOISE_N * rng.standard_normal(len(t_s))
    assert offset_after(np.maximum(0.0, COUNT_N * np.round((force_n + noise_n) / COUNT_N)), z_m) < 0.06


def test_a_rest_and_a_stroke_over_a_slope_are_no_offset() -> None:
    rng = np.random.default_rng(0)
    force_n = 0.3 + NOISE_N * rng.standard_normal(5000)
    assert offset_after(force_n, 1e-5 * rng.standard_normal(5000)) == 0.0
    x_m = np.linspace(0.0, 0.1, 5000)
    assert offset_after(force_n, 0.5 * x_m, x_m) == 0.0


def test_noise_that_is_cut_off_at_0_is_no_offset() -> None:
    noise_n = np.maximum(0.0, 3.0 * NOISE_N * np.random.default_rng(0).standard_normal(5000))
    assert offset_after(noise_n, np.linspace(0.0, 0.1, 5000)) == 0.0


def test_readings_that_are_not_finite_do_not_count() -> None:
    z_m = np.linspace(0.0, 0.1, 1000)
    force_n = np.where(np.arange(1000) % 100 < 50, 0.1, math.nan)
    assert offset_after(force_n, z_m) == pytest.approx(0.1)
    assert offset_after(np.full(1000, 0.1), np.full(1000, math.nan)) == 0.0


@pytest.mark.parametrize("offset_n", [0.0, 0.05, 0.12, 0.2, 0.25])
@pytest.mark.parametrize("rate_hz", [250, 500, 1000])
def test_taps_and_their_speeds_do_not_depend_on_it(offset_n: float, rate_hz: int) -> None:
    rng, hand = np.random.default_rng(0), HandMotion()
    exploration, speeds_m_s, free = ModeDetector(hand), [], 0
    for tick in range(8 * rate_hz):
        t_s = tick / rate_hz
        z_m = float(np.interp(t_s % 2.0, [0.0, 1.0, 1.3, 1.6], [10e-3, 10e-3, -1e-3, 10e-3]))
        force_n = COUNT_N * round((max(0.0, -1000.0 * z_m) + offset_n + NOISE_N * rng.standard_normal()) / COUNT_N)
        hand.step(t_s, 0.0, 0.0)
        free += exploration.step(t_s, force_n, z_m) is ExplorationMode.FREE
        if exploration.began:
            speeds_m_s.append(exploration.approach_m_s)
    assert speeds_m_s == pytest.approx([0.0367] * 4, abs=0.003)
    assert free / rate_hz == pytest.approx(7.83, abs=0.05)
