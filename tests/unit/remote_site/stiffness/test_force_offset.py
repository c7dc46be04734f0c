"""Offset of a force sensor, and presses with one."""

import math

import numpy as np
import pytest

from common.exploration.contact_detector import ContactDetector
from remote_site.stiffness.force_offset import LEAST_N, SETTLES_S, ForceOffset
from remote_site.stiffness.surface_estimate import SurfaceEstimate

TICK_S = 0.002
NOISE_N, COUNT_N = 0.011, 0.01


def offset_after(force_n: np.ndarray, tick_s: float = TICK_S, touching: bool = False) -> float:
    """Offset after readings of a finger, N."""
    offset, found_n = ForceOffset(), 0.0
    for tick, reading_n in enumerate(force_n.tolist()):
        found_n = offset.step(tick_s * tick, reading_n, touching)
    return found_n


@pytest.mark.parametrize("tick_s", [0.001, 0.002, 0.004])
def test_it_settles_alike_at_any_rate(tick_s: float) -> None:
    ticks = round(SETTLES_S / tick_s)
    force_n = np.concatenate([np.zeros(ticks + 1), np.full(ticks, 0.1)])
    assert offset_after(force_n, tick_s) == pytest.approx(0.1 * (1.0 - math.exp(-1.0)), rel=0.01)


def test_it_is_known_at_once_after_the_start() -> None:
    assert offset_after(np.full(3, 0.1)) == pytest.approx(0.1)


def test_noise_that_is_cut_off_at_0_is_no_offset() -> None:
    noise_n = np.maximum(0.0, 3.0 * NOISE_N * np.random.default_rng(0).standard_normal(5000))
    assert noise_n.mean() < LEAST_N
    assert offset_after(noise_n) == 0.0


def test_a_contact_and_readings_that_are_not_finite_do_not_count() -> None:
    assert offset_after(np.full(5000, 1.0), touching=True) == 0.0
    assert offset_after(np.full(5000, math.nan)) == 0.0


@pytest.mark.parametrize("offset_n", [0.0, 0.03, 0.06, 0.10, 0.15])
@pytest.mark.parametrize("stiffness_n_m", [300.0, 1000.0, 3000.0])
def test_a_sensor_with_an_offset_shows_the_same_surface(offset_n: float, stiffness_n_m: float) -> None:
    """Three presses of 1.5 N, with 1.5 s in the air before each."""
    rng, surface, contact, offset = np.random.default_rng(3), SurfaceEstimate(), ContactDetector(), ForceOffset()
    deep_m = 1.5 / stiffness_n_m
    from_start_s = np.arange(0.0, 4.0, TICK_S)
    knots_s = [0.0, 0.8, 1.3, 1.6, 2.6, 2.9, 3.4]
    way_m = np.interp(from_start_s, knots_s, [10e-3, 10e-3, 0.5e-3, -deep_m, -deep_m, 0.5e-3, 10e-3])
    for press in range(3):
        noise_n = NOISE_N * rng.standard_normal(len(way_m))
        force_n = COUNT_N * np.round((np.maximum(0.0, -stiffness_n_m * way_m) + offset_n + noise_n) / COUNT_N)
        for at_s, reading_n, z_m in zip(from_start_s.tolist(), force_n.tolist(), way_m.tolist(), strict=True):
            t_s = 4.0 * press + at_s
            contact.step(t_s, reading_n)
            surface.step(t_s, reading_n, 0.0, 0.0, z_m, offset.step(t_s, reading_n, contact.touching))
            if at_s == from_start_s[1200]:  # 2.4 s: at rest in the press
                assert surface.known
                assert surface.stiffness_n_m == pytest.approx(stiffness_n_m, rel=0.05)
                assert surface.surface_z_m == pytest.approx(0.0, abs=0.1 / stiffness_n_m)
        assert surface.stiffness_n_m == 0.0, "the contact has ended"
