"""From samples to curvature along the way."""

import numpy as np
import pytest

from remote_site.texture.curvature_noise import CurvatureNoise
from remote_site.texture.tip_path import CELL_M, RATE_HZ, TipPath


def curvature(signal, speed_m_s, viscous_s=0.0, leak_hz=0.0):
    path, found = TipPath(viscous_s, leak_hz), []
    for first in range(0, len(signal) - 9, 10):
        found += path.step(signal[first : first + 10].tolist(), (first + 10) / RATE_HZ, speed_m_s)
    return np.array(found)


def way(speed_m_s, seconds=1.0):
    return speed_m_s * np.arange(1, 1 + round(RATE_HZ * seconds)) / RATE_HZ


@pytest.mark.parametrize("speed_m_s", [0.01, 0.02, 0.05, 0.15, 0.3])
def test_a_groove_has_one_place_and_depth_at_any_speed(speed_m_s):
    x = way(speed_m_s, 0.012 / speed_m_s)
    found = curvature(-np.exp(-(((x - 0.006) / 0.3e-3) ** 2)), speed_m_s)
    time_s, place_m, curved_v, _ = found[found[:, 2].argmin()]
    assert place_m == pytest.approx(0.006, abs=1.5 * CELL_M)
    assert time_s == pytest.approx(0.006 / speed_m_s, abs=1e-3 + CELL_M / speed_m_s)
    assert curved_v == pytest.approx(-0.31, rel=0.15)


def test_pressure_swing_and_tilt_are_no_curvature():
    x = way(0.05)
    slow = 3.0 + 40.0 * x + 2.0 * np.sin(2.0 * np.pi * x / 0.02)
    assert np.abs(curvature(slow, 0.05)[:, 2]).max() < 0.01


def test_viscosity_is_undone():
    x, tau = way(0.15), 1e-3
    height = np.sin(2.0 * np.pi * x / 1e-3)
    felt = height + tau * np.gradient(height, 1.0 / RATE_HZ)
    bare, undone = curvature(height, 0.15), curvature(felt, 0.15, viscous_s=tau)
    assert undone[200:, 2].std() == pytest.approx(bare[200:, 2].std(), rel=0.1)
    assert curvature(felt, 0.15)[200:, 2].std() > 1.25 * bare[200:, 2].std()


def test_the_leak_of_the_integrator_is_undone():
    x = way(0.02)
    true = np.where((x > 0.008) & (x < 0.0085), -1.0, 0.0)
    leak, leaky, state = 2.0 * np.pi * 3.0 / RATE_HZ, np.empty_like(true), 0.0
    for k, value in enumerate(true):
        leaky[k] = (value - state) / (1.0 + leak)
        state += leak * leaky[k]
    after = slice(95, 120)  # just behind the groove, where the leak's tail would be
    undone, left = (np.abs(curvature(leaky, 0.02, leak_hz=hz)[after, 2]).max() for hz in (3.0, 0.0))
    assert undone < 0.25 * left


def test_a_rest_interrupts_the_path():
    path = TipPath(0.0, 0.0)
    assert path.step([0.0] * 100, 0.05, 0.05)
    assert path.step([1.0] * 400, 0.25, 0.002) == []
    first = path.step([1.0] * 100, 0.30, 0.05)
    assert len(first) < 25
    assert max(abs(curve.curvature_v) for curve in first) < 1e-9


@pytest.mark.parametrize("viscous_s", [0.0, 1e-3])
@pytest.mark.parametrize("speed_m_s", [0.02, 0.05, 0.15])
def test_the_power_of_noise_is_known(viscous_s, speed_m_s):
    noise = np.random.default_rng(3).normal(0.0, 1.0, 40_000)
    found = curvature(noise, speed_m_s, viscous_s)
    expected = CurvatureNoise(viscous_s).power(float(found[:, 3].mean()))
    assert np.square(found[50:, 2]).mean() == pytest.approx(expected, rel=0.1)
