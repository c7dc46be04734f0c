"""Compliance below a finger on a surface that moves by itself."""

import math

import numpy as np
import pytest

from remote_site.stiffness.moving_surface import MOTION_M, MovingSurface, motion_sd_m

TICK_S, SOFT_M_N = 0.02, 1.0 / 500.0
NOISE_M2 = (20e-6) ** 2


def followed(presses: int, press_s: float, seed: int) -> tuple[MovingSurface, float]:
    """Press on 500 N/m that breathes by 2 mm; return the filter and the true height of the surface."""
    rng, phase = np.random.default_rng(seed), 2.0 * math.pi * np.random.default_rng(seed).random()
    surface = MovingSurface(0.0, 1.0, 0.3 * SOFT_M_N, 1.3 * SOFT_M_N, SOFT_M_N**2)
    last_n, height_m = 1.0, 0.0
    for tick in range(1, round(2.0 * presses * press_s / TICK_S)):
        t_s = TICK_S * tick
        force_n = 2.0 - math.cos(math.pi * t_s / press_s)
        height_m = 2e-3 * (math.sin(2.0 * math.pi * 0.3 * t_s + phase) - math.sin(phase))
        z_m = height_m - SOFT_M_N * force_n + 20e-6 * rng.standard_normal()
        teaches = abs(force_n - last_n) > 0.05
        last_n = force_n if teaches else last_n
        surface.step(t_s, z_m, -force_n, NOISE_M2, 0.0, teaches)
    return surface, height_m


@pytest.mark.parametrize("seed", range(5))
def test_fast_presses_give_the_compliance_of_a_breathing_surface(seed: int) -> None:
    surface, height_m = followed(8, 0.2, seed)
    ln_sd = math.sqrt(surface.variance_m2_n2) / surface.compliance_m_n
    assert ln_sd < 0.06
    assert surface.compliance_m_n == pytest.approx(SOFT_M_N, rel=0.15)
    assert surface.surface_m == pytest.approx(height_m, abs=0.5e-3)


def test_slow_presses_teach_less_than_fast_ones() -> None:
    fast, slow = (followed(4, press_s, 0)[0].variance_m2_n2 for press_s in (0.2, 1.0))
    assert slow > 4.0 * fast


def test_a_resting_finger_teaches_no_compliance_and_follows_the_surface() -> None:
    surface = MovingSurface(0.0, 2.0, 2.0 * SOFT_M_N, SOFT_M_N, (0.2 * SOFT_M_N) ** 2)
    for tick in range(1, 200):
        surface.step(TICK_S * tick, 1e-3 * math.sin(TICK_S * tick), -2.0, NOISE_M2, 0.0, teaches=False)
    assert surface.compliance_m_n == SOFT_M_N
    assert surface.variance_m2_n2 >= (0.2 * SOFT_M_N) ** 2
    assert surface.surface_m == pytest.approx(1e-3 * math.sin(TICK_S * 199) + 2.0 * SOFT_M_N, abs=0.1e-3)


def test_the_surface_moves_less_within_less_time() -> None:
    assert motion_sd_m(0.0) == 0.0
    assert motion_sd_m(0.1) < motion_sd_m(0.3) < motion_sd_m(1.0)
    assert motion_sd_m(100.0) == pytest.approx(math.sqrt(2.0) * MOTION_M, rel=1e-3)
