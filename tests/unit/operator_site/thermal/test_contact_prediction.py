"""Contacts that are known before they happen."""

import math

import pytest

from operator_site.thermal.contact_prediction import SPEED_LAG_S, ContactPrediction, contact_c, contact_in_s
from operator_site.thermal.skin_model import Touched


def test_downward_speed_follows_within_its_lag_and_restarts_after_a_pause() -> None:
    approach = ContactPrediction()
    speeds = [approach.step(0.002 * i, -0.05 * 0.002 * i) for i in range(100)]
    assert speeds[0] == 0.0
    assert speeds[round(SPEED_LAG_S / 0.002)] == pytest.approx(0.05 * (1.0 - math.exp(-1.0)), rel=0.15)
    assert speeds[-1] == pytest.approx(0.05, rel=1e-3)
    for t_s, z_m in ((0.198, -0.5), (1.0, -0.6), (0.5, -0.7), (0.502, math.nan), (0.504, -0.7)):
        assert approach.step(t_s, z_m) == 0.0, "time stood still, jumped, or the place was not known"


def test_time_to_contact_is_height_over_speed() -> None:
    assert contact_in_s(0.006, 0.02) == pytest.approx(0.3)
    assert contact_in_s(-0.001, 0.02) == 0.0


@pytest.mark.parametrize("approach", [0.0, -0.1, 0.002, math.nan])
def test_a_finger_that_does_not_descend_has_no_predicted_contact(approach: float) -> None:
    assert contact_in_s(0.001, approach) == math.inf


def test_metal_is_met_near_its_own_temperature_and_foam_near_the_skins() -> None:
    assert contact_c(33.0, Touched.of("copper"), 23.0) == pytest.approx(23.3, abs=0.1)
    assert contact_c(33.0, Touched.of("pu_foam"), 23.0) == pytest.approx(32.6, abs=0.1)
    assert contact_c(33.0, Touched.of("pvc"), 33.0) == pytest.approx(33.0)
