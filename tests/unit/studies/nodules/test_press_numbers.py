"""Numbers of presses: contact and exponent of the median press, and presses that are too short."""

import numpy as np
import pytest

from studies.nodules.press_numbers import FEWEST_STEPS, press_numbers
from tests.unit.studies.nodules.breathing_presses import CONTACT_N, PROBE_M, SINCE_S, numbers_of, pressed


def test_contact_and_exponent_of_the_median_press_are_found() -> None:
    numbers = numbers_of(0.0)
    assert numbers.contact_m == pytest.approx(1e-3, rel=0.1)
    assert numbers.exponent == pytest.approx(2.0, rel=0.05)


def test_a_press_that_ended_early_says_nothing_about_the_depth_beyond() -> None:
    places_m, depth_m, force_n, contact_s = pressed(0.0)
    force_n[3, 6:] = np.nan
    numbers = press_numbers(places_m, depth_m, force_n, CONTACT_N, PROBE_M, SINCE_S, contact_s)
    assert numbers.variance[1, 3] > 10.0 > 1e-2 > numbers.variance[0, 3]


def test_a_press_needs_some_readings() -> None:
    places_m, depth_m, force_n, contact_s = pressed(0.0)
    few = FEWEST_STEPS - 1
    with pytest.raises(ValueError, match=f"a press needs {FEWEST_STEPS} readings"):
        press_numbers(places_m, depth_m[:few], force_n[:, :few], CONTACT_N, PROBE_M, SINCE_S[:few], contact_s)
