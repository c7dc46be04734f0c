"""The lift of an inclusion has the right limits, and fades with depth and distance."""

import math

import numpy as np
import pytest
from scipy.integrate import dblquad

from operator_site.palpation.inclusion_model import (
    ESHELBY,
    contact_radius_m,
    energy_density,
    energy_share,
    ln_lift,
)
from sim_sensors.tissue.contrast import Sphere, taken_share


def test_the_energy_of_the_half_space_is_whole() -> None:
    whole, _ = dblquad(
        lambda rho, z: float(energy_density(rho, z, 1.0)) * 2.0 * math.pi * rho, 0.0, 60.0, 0.0, 60.0, epsabs=1e-3
    )
    assert whole == pytest.approx(1.0, abs=0.03)  # the rest lies farther away


def test_far_away_the_energy_is_that_of_a_point_force() -> None:
    rho, z, a = 60.0, 80.0, 1.0
    assert float(energy_density(rho, z, a)) == pytest.approx(6.0 * a / math.pi**2 * z**2 / 100.0**6, rel=1e-3)


def test_no_energy_is_below_the_middle_of_the_contact() -> None:
    """An incompressible body bears the punch's pressure there without a change of shape."""
    assert float(energy_density(0.0, 0.01, 1.0)) < 1e-3 * float(energy_density(0.0, 0.6, 1.0))


def test_the_share_of_a_small_sphere_is_the_density_times_its_volume() -> None:
    top_m, radius_m, contact_m = 5e-3, 0.1e-3, 2e-3
    expected = float(energy_density(3e-3, top_m + radius_m, contact_m)) * 4.0 / 3.0 * math.pi * radius_m**3
    assert energy_share([3e-3], top_m, radius_m, contact_m)[0] == pytest.approx(expected, rel=1e-2)


@pytest.mark.long
def test_the_lift_is_near_that_of_finite_elements() -> None:
    """The simulated tissue is computed independently. Its layer of 40 mm is stiffer than a half space."""
    for size_mm, top_mm, radius_mm in ((6.5, 4.0, 2.0), (9.0, 2.5, 4.4), (12.0, 7.0, 4.4), (17.0, 4.0, 3.0)):
        sphere = Sphere(0.0, 0.0, size_mm, top_mm, 6.0)
        taken = taken_share(sphere, 40.0, np.array([radius_mm]), np.array([0.0]))[0]
        share = energy_share([0.0], 1e-3 * top_mm, 0.5e-3 * size_mm, 1e-3 * radius_mm)[0]
        assert float(ln_lift(share, 6.0)) == pytest.approx(-math.log1p(-float(taken)), rel=0.2)


def test_the_lift_has_its_limits() -> None:
    assert ln_lift(0.0, 20.0) == 0.0
    assert ln_lift(0.5, 1.0) == 0.0
    assert ln_lift(1.0, 7.0) == pytest.approx(math.log(7.0))
    assert ln_lift(1e-6, 7.0) == pytest.approx(1e-6 * 6.0 / (1.0 + ESHELBY * 6.0), rel=1e-4)


def test_the_lift_fades_with_depth_and_distance_and_grows_with_size() -> None:
    shares = [energy_share([0.0], top, 4e-3, 2e-3)[0] for top in (1e-3, 3e-3, 8e-3)]
    assert shares == sorted(shares, reverse=True)
    across = energy_share(np.linspace(0.0, 0.02, 9), 3e-3, 4e-3, 2e-3)
    assert (np.diff(across) < 0.0).all()
    assert energy_share([0.0], 3e-3, 6e-3, 2e-3)[0] > shares[1]


def test_a_deeper_press_reaches_deeper() -> None:
    shallow, deep = (contact_radius_m(4e-3, depth) for depth in (0.5e-3, 3e-3))
    assert shallow < deep <= 4e-3
    gain = [
        energy_share([0.0], top, 4e-3, deep)[0] / energy_share([0.0], top, 4e-3, shallow)[0] for top in (1e-3, 8e-3)
    ]
    assert gain[1] > gain[0]
