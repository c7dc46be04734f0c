"""Roughness in um: fitted to surfaces of known roughness, and only where it was calibrated."""

import math

import pytest

from remote_site.texture.calibration.roughness_fit import ASSUMED_SD, KnownRoughness, fit_scale


def known(exponent, *roughness_um, strokes=3):
    return [
        KnownRoughness(f"{um} um", (um / 50.0) ** (1.0 / exponent) * (1.0 + 0.02 * stroke), um)
        for um in roughness_um
        for stroke in range(strokes)
    ]


def test_three_surfaces_show_the_exponent():
    scale = fit_scale(known(1.5, 2.0, 5.0, 10.0))
    assert scale is not None
    assert scale.exponent == pytest.approx(1.5, rel=0.01)
    found = scale.at((4.0 / 50.0) ** (1.0 / 1.5))
    assert found is not None
    assert found == pytest.approx((4.0, 4.0 * scale.ln_sd), rel=0.05)


@pytest.mark.parametrize("roughness_um", [(5.0,), (5.0, 8.0)])
def test_fewer_surfaces_give_a_proportional_scale(roughness_um):
    scale = fit_scale(known(1.0, *roughness_um))
    assert scale is not None
    assert scale.exponent == 1.0
    assert scale.ln_sd >= (ASSUMED_SD if len(roughness_um) == 1 else 0.05)


def test_beyond_the_calibrated_range_there_is_none():
    scale = fit_scale(known(1.0, 2.0, 5.0, 10.0, strokes=1))
    assert scale is not None
    assert scale.at(2.0 / 50.0) is not None
    assert scale.at(math.exp(-0.26) * 2.0 / 50.0) is None
    assert scale.at(math.exp(0.26) * 10.0 / 50.0) is None


def test_without_a_known_surface_there_is_no_scale():
    assert fit_scale([]) is None
