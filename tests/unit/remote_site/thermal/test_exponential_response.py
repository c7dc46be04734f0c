"""Eq. 11 fitted online: exact without noise, near the bound with it."""

import numpy as np
import pytest

from remote_site.thermal.exponential_response import ExponentialResponse


def fit(tau, noise=0.0, seconds=8.0, seed=0):
    rng = np.random.default_rng(seed)
    response = ExponentialResponse(33.0)
    for t in np.arange(0.0, seconds, 0.01):
        response.add(t, 23.0 + 10.0 * np.exp(-t / tau) + noise * rng.normal())
    return response.fit()


@pytest.mark.parametrize("tau", [1.0, 1.7, 2.9, 8.0])
def test_a_clean_exponential_is_recovered(tau):
    found = fit(tau)
    assert 1 / found.rate_per_s == pytest.approx(tau, rel=0.003)
    assert found.object_c == pytest.approx(23.0, abs=0.05)
    assert found.offset_k == pytest.approx(10.0, abs=0.05)


def test_noise_costs_no_more_than_twice_the_bound():
    # Cramer-Rao at window/tau = 0.9, all unknown, scaled to 0.02 K, 100 Hz: sd(tau)/tau about 0.5 %
    errors = [np.log(8.0 * fit(8.0, 0.02, seed=k).rate_per_s) for k in range(30)]
    assert np.std(errors) < 0.01


def test_no_estimate_without_readings_or_change():
    assert ExponentialResponse(30.0).fit() is None
    still = ExponentialResponse(30.0)
    for k in range(200):
        still.add(0.01 * k, 30.0)
    assert still.fit() is None
