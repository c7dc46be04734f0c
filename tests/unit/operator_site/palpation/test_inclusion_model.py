"""The lift of an inclusion has the right limits, and fades with depth and distance."""

import math

import numpy as np
import pytest
from scipy.integrate import dblquad

from operator_site.palpation.inclusion_model import (
    ESHELBY,
    HERTZ,
    contact_radius_m,
    energy_above,
    energy_share,
    ln_lift,
)


def test_the_energy_of_the_half_space_is_whole() -> None:
    assert energy_above(1e3, 2e-3) == pytest.approx(1.0, abs=1e-5)
    b = HERTZ * 2e-3
    numeric, _ = dblquad(
        lambda rho, z: 8.0 * b / math.pi**2 * z**2 / (rho**2 + z**2 + b**2) ** 3 * 2.0 * math.pi * rho,
        0.0,
        0.005,
        0.0,
        1.0,
    )
    assert energy_above(0.005, 2e-3) == pytest.approx(numeric, rel=1e-4)


def test_the_share_of_a_small_sphere_is_the_density_times_its_volume() -> None:
    top_m, radius_m, b = 5e-3, 0.1e-3, HERTZ * 2e-3
    z = top_m + radius_m
    density = 8.0 * b / math.pi**2 * z**2 / (z**2 + 3e-3**2 + b**2) ** 3
    expected = density * 4.0 / 3.0 * math.pi * radius_m**3 / energy_above(0.03, 2e-3)
    assert energy_share([3e-3], top_m, radius_m, 2e-3, 0.03)[0] == pytest.approx(expected, rel=1e-2)


def test_the_lift_has_its_limits() -> None:
    assert ln_lift(0.0, 20.0) == 0.0
    assert ln_lift(0.5, 1.0) == 0.0
    assert ln_lift(1.0, 7.0) == pytest.approx(math.log(7.0))
    assert ln_lift(1e-6, 7.0) == pytest.approx(1e-6 * 6.0 / (1.0 + ESHELBY * 6.0), rel=1e-4)


def test_the_lift_fades_with_depth_and_distance_and_grows_with_size() -> None:
    shares = [energy_share([0.0], top, 4e-3, 2e-3, 0.03)[0] for top in (1e-3, 3e-3, 8e-3)]
    assert shares == sorted(shares, reverse=True)
    across = energy_share(np.linspace(0.0, 0.02, 9), 3e-3, 4e-3, 2e-3, 0.03)
    assert (np.diff(across) < 0.0).all()
    assert energy_share([0.0], 3e-3, 6e-3, 2e-3, 0.03)[0] > shares[1]


def test_a_deeper_press_reaches_deeper() -> None:
    shallow, deep = (contact_radius_m(4e-3, depth) for depth in (0.5e-3, 3e-3))
    assert shallow < deep <= 4e-3
    gain = [
        energy_share([0.0], top, 4e-3, deep, 0.03)[0] / energy_share([0.0], top, 4e-3, shallow, 0.03)[0]
        for top in (1e-3, 8e-3)
    ]
    assert gain[1] > gain[0]
