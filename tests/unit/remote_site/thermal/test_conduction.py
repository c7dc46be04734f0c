"""The kernel of heat conduction against theory: half space, slab by Fourier's series, and the range between."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from remote_site.thermal.conduction import DECAYS_PER_S, mode_weights, steady_flux_response

TIMES_S = np.geomspace(0.002, 30.0, 97)
"""Not those that the modes are fitted at."""


def by_modes(times_s, slab_s):
    slow = np.maximum(DECAYS_PER_S, 1e-12)
    return (-np.expm1(-np.outer(times_s, slow)) / slow) @ mode_weights(slab_s)


def by_fourier(times_s, slab_s):
    """Carslaw & Jaeger 1959, section 3.8, Eq. 3: the other series, which converges where the images do not."""
    n = np.arange(1, 400)
    fourier = times_s / slab_s
    series = (np.exp(-np.outer(fourier, n * n) * np.pi**2) / n**2).sum(axis=1)
    return np.sqrt(slab_s) * (fourier + 1.0 / 3.0 - 2.0 / np.pi**2 * series)


@pytest.mark.parametrize("slab_s", [0.1, 0.3, 1.0, 3.0, 10.0, 30.0, np.inf])
def test_the_modes_give_the_response_to_a_steady_flux(slab_s):
    wanted = 2.0 * np.sqrt(TIMES_S / np.pi) if np.isinf(slab_s) else by_fourier(TIMES_S, slab_s)
    assert by_modes(TIMES_S, slab_s) == pytest.approx(wanted, rel=0.005)
    assert (mode_weights(slab_s) >= 0.0).all()


@given(st.floats(0.1, 100.0))
def test_images_and_fourier_series_are_one_solution(slab_s):
    late = TIMES_S[1e-3 * slab_s < TIMES_S]  # before, the other series needs more terms
    assert steady_flux_response(late, slab_s) == pytest.approx(by_fourier(late, slab_s), rel=1e-4)


def test_a_slab_is_a_half_space_until_its_back_answers():
    early = TIMES_S[TIMES_S < 0.1]
    assert steady_flux_response(early, 10.0) == pytest.approx(steady_flux_response(early, np.inf), rel=1e-6)
    assert steady_flux_response(TIMES_S, 10.0)[-1] > 1.2 * steady_flux_response(TIMES_S, np.inf)[-1]
