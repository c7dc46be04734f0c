"""Presses with a force sensor that has an offset."""

import numpy as np
import pytest

from common.exploration.exploration_mode import ModeDetector
from common.exploration.hand_motion import HandMotion
from remote_site.stiffness.surface_estimate import SurfaceEstimate

TICK_S = 0.002
NOISE_N, COUNT_N = 0.011, 0.01


@pytest.mark.parametrize("offset_n", [0.0, 0.03, 0.06, 0.10, 0.15, 0.25])
@pytest.mark.parametrize("stiffness_n_m", [300.0, 1000.0, 3000.0])
def test_a_sensor_with_an_offset_shows_the_same_surface(offset_n: float, stiffness_n_m: float) -> None:
    """Three presses of 1.5 N, with 1.5 s in the air before each."""
    rng, surface, hand = np.random.default_rng(3), SurfaceEstimate(), HandMotion()
    exploration, deep_m = ModeDetector(hand), 1.5 / stiffness_n_m
    from_start_s = np.arange(0.0, 4.0, TICK_S)
    knots_s = [0.0, 0.8, 1.3, 1.6, 2.6, 2.9, 3.4]
    way_m = np.interp(from_start_s, knots_s, [10e-3, 10e-3, 0.5e-3, -deep_m, -deep_m, 0.5e-3, 10e-3])
    for press in range(3):
        noise_n = NOISE_N * rng.standard_normal(len(way_m))
        force_n = COUNT_N * np.round((np.maximum(0.0, -stiffness_n_m * way_m) + offset_n + noise_n) / COUNT_N)
        for at_s, reading_n, z_m in zip(from_start_s.tolist(), force_n.tolist(), way_m.tolist(), strict=True):
            t_s = 4.0 * press + at_s
            hand.step(t_s, 0.0, 0.0)
            exploration.step(t_s, reading_n, z_m)
            surface.step(t_s, reading_n, 0.0, 0.0, z_m, exploration.offset_n)
            if at_s == from_start_s[1200]:  # 2.4 s: at rest in the press
                assert surface.known
                assert surface.stiffness_n_m == pytest.approx(stiffness_n_m, rel=0.05)
                assert surface.surface_z_m == pytest.approx(0.0, abs=0.1 / stiffness_n_m)
        assert surface.stiffness_n_m == 0.0, "the contact has ended"
