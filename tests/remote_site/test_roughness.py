"""Roughness with pattern hold: grooves are flagged once and stay out of the mean."""

import numpy as np
import pytest

from common.messages import ExplorationMode
from remote_site.groove_period import GroovePeriod
from remote_site.roughness import Roughness

SPEED = 0.05
STROKING, QUIESCENT = ExplorationMode.STROKING, ExplorationMode.QUIESCENT


def play(signal, modes=None, roughness=None):
    roughness = roughness or Roughness(leak_hz=0.0)
    readings = []
    for k in range(len(signal) // 10):
        mode = STROKING if modes is None else modes[k]
        readings.append(roughness.step(0.005 * (k + 1), signal[10 * k : 10 * k + 10], mode, SPEED, 1.0))
    return readings


def noise(seconds, sd, seed=0):
    return np.random.default_rng(seed).normal(0.0, sd, round(2000 * seconds))


def grooves(signal, period_mm, start_s=0.2):
    times = np.arange(start_s, len(signal) / 2000 - 0.05, period_mm / 1000 / SPEED)
    for t in times:
        signal[round(2000 * t) : round(2000 * t) + 12] -= 0.8
    return times


@pytest.mark.parametrize("period_mm", [2.0, 8.0])
def test_regular_grooves_are_neither_missed_nor_invented(period_mm):
    signal = noise(4.0, 0.012)
    times = grooves(signal, period_mm)
    readings = play(signal)
    flags = [0.005 * (k + 1) for k, r in enumerate(readings) if r.impulse]
    assert len(flags) == len(times)
    assert max(abs(a - b) for a, b in zip(flags, times, strict=True)) < 0.011
    assert readings[-1].roughness_v == pytest.approx(0.012 * 0.8, rel=0.2)


def test_nothing_is_flagged_on_a_rough_surface():
    assert not any(r.impulse for seed in range(5) for r in play(noise(4.0, 0.3, seed)))


@pytest.mark.parametrize("period_mm", [2.0, 8.0])
def test_a_jolt_at_the_start_does_not_hide_the_grooves(period_mm):
    signal = noise(4.0, 0.012)
    times = grooves(signal, period_mm, start_s=0.0)
    for begin, level in ((0.0, 0.5), (0.05, 1.8), (0.10, 0.6)):
        signal[round(2000 * begin) : round(2000 * (begin + 0.05))] += level * np.sin(np.arange(100))
    readings = play(signal)
    flags = [0.005 * (k + 1) for k, r in enumerate(readings) if r.impulse and 0.005 * (k + 1) > 1.0]
    assert len(flags) == pytest.approx(sum(times > 0.995), abs=1)


def test_a_rougher_surface_does_not_latch():
    signal = np.concatenate((noise(1.0, 0.01), noise(1.0, 0.3, 1)))
    readings = play(signal)
    assert sum(r.surface_changed for r in readings) >= 1
    assert readings[-1].roughness_v == pytest.approx(0.24, rel=0.25)
    assert not readings[-1].pattern


def test_a_smoother_surface_is_learned_within_a_second():
    readings = play(np.concatenate((noise(1.0, 0.3), noise(1.2, 0.02, 1))))
    assert readings[-1].roughness_v < 0.05


def test_the_mean_is_frozen_at_rest_and_forgotten_with_the_contact():
    signal = noise(0.6, 0.1)
    modes = [STROKING] * 60 + [QUIESCENT] * 60
    readings = play(signal, modes)
    assert readings[-1].roughness_v == readings[59].roughness_v
    roughness = Roughness()
    play(signal, [STROKING] * 60 + [ExplorationMode.FREE] * 60, roughness)
    assert not roughness.step(1.0, signal[:10], STROKING, SPEED, 1.0).valid


def test_a_clipped_chunk_is_no_data():
    roughness = Roughness(leak_hz=0.0)
    before = play(noise(0.5, 0.1), roughness=roughness)[-1].roughness_v
    reading = roughness.step(0.6, np.full(10, -10.0), STROKING, SPEED, 1.0)
    assert reading.saturated
    assert reading.roughness_v == before


def test_the_leak_of_the_integrator_is_undone():
    true = noise(2.0, 0.01) + 1.0
    times = grooves(true, 8.0)
    leak = 2 * np.pi * 3.0 / 2000
    leaky, state = np.empty_like(true), 0.0
    for k, value in enumerate(true):
        leaky[k] = (value - state) / (1.0 + leak)
        state += leak * leaky[k]
    readings = play(leaky, roughness=Roughness())
    assert sum(r.impulse for r in readings) == len(times)
    assert readings[-1].roughness_v < 0.012


def test_period_is_the_middle_gap():
    period = GroovePeriod()
    period.flag()
    for gap in (0.004, 0.0041, 0.008, 0.0039, 0.004):
        period.move(gap)
        period.flag()
    assert period.estimate().period_m == pytest.approx(0.004, abs=1e-4)
    period.interrupt()
    period.flag()
    assert period.estimate().period_m == pytest.approx(0.004, abs=1e-4)
