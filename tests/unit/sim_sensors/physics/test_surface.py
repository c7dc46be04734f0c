import numpy as np
import pytest

from common.scenes.surfaces import surfaces
from sim_sensors.physics import surface
from sim_sensors.physics.surface import GRID_M, ROUGHNESS_M, make_profile, relief_of


def profile(name, length_m=0.05, seed=0):
    return make_profile(relief_of(name), length_m, np.random.default_rng(seed))


def test_every_surface_has_a_relief_and_every_relief_a_surface():
    assert set(ROUGHNESS_M) == set(surfaces())


def test_same_seed_same_surface_and_another_seed_another():
    assert np.array_equal(profile("sandpaper").height_m, profile("sandpaper").height_m)
    assert not np.array_equal(profile("sandpaper").height_m, profile("sandpaper", seed=1).height_m)


def test_every_finger_has_a_track_of_its_own_but_grooves_are_common():
    smooth, grooved = profile("sandpaper").height_m, profile("widely_grooved_pvc")
    assert abs(np.corrcoef(smooth[0], smooth[1])[0, 1]) < 0.2
    at = np.rint(np.array(grooved.grooves_m) / GRID_M).astype(int)
    assert np.all(grooved.height_m[:, at] < -60e-6)


@pytest.mark.parametrize("name", ["foam", "skin", "pine"])
def test_height_and_correlation_length_of_the_drawn_process(name):
    kind = relief_of(name)
    height = surface.draw_roughness(kind, 40_000, np.random.default_rng(2))
    assert height.std() == pytest.approx(kind.rms_m, rel=0.06)
    lag = round(kind.correlation_m / GRID_M)
    correlation = np.mean(height[:, lag:] * height[:, :-lag]) / np.mean(height**2)
    assert correlation == pytest.approx(np.exp(-1.0), abs=0.07)


def test_the_tip_rests_on_the_surface_and_touches_it_somewhere():
    rough = surface.draw_roughness(relief_of("sandpaper"), 3000, np.random.default_rng(3))
    path = surface.roll_tip(rough)
    assert np.all(path >= rough - 1e-12)
    assert np.isclose(path, rough, atol=1e-9).any()


def test_a_groove_takes_the_ball_in_only_as_far_as_it_fits():
    samples = 401
    notch = surface.groove_heights([0.002], samples, surface.GROOVE_DEPTH_M)[None, :]
    path = surface.roll_tip(notch)
    half = 0.5 * surface.GROOVE_WIDTH_M
    fits = surface.TIP_RADIUS_M - np.sqrt(surface.TIP_RADIUS_M**2 - half**2)
    assert notch.min() == pytest.approx(-surface.GROOVE_DEPTH_M)
    assert path.min() == pytest.approx(-fits, rel=0.02)


@pytest.mark.parametrize(
    ("name", "low_m", "high_m"),
    [
        ("closely_grooved_pvc", 2e-3, 2e-3),
        ("widely_grooved_pvc", 8e-3, 8e-3),
        ("arbitrarily_grooved_pvc", 2e-3, 8e-3),
    ],
)
def test_groove_spacing(name, low_m, high_m):
    spacing = np.diff(profile(name, 0.2).grooves_m)
    assert spacing.min() >= low_m - 1e-9
    assert spacing.max() <= high_m + 1e-9
    if high_m > low_m:
        assert spacing.std() > 0.5e-3


def test_grooves_take_contact_area_away():
    assert relief_of("closely_grooved_pvc").contact_fraction == pytest.approx(0.8)
    assert relief_of("plain_pvc").contact_fraction == 1.0
