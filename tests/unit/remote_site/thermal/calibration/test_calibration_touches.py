"""Readings of calibration touches, and the steps in which a model reaches them."""

import numpy as np
import pytest

from remote_site.thermal.calibration.calibration_touches import BLOCK, EACH_UNTIL, CalibrationReadings, CalibrationTouch
from remote_site.thermal.touch_start import READING_S


@pytest.mark.parametrize("length", [EACH_UNTIL - 1, EACH_UNTIL, EACH_UNTIL + BLOCK, EACH_UNTIL + 10 * BLOCK + 3])
def test_a_step_of_a_model_ends_at_the_middle_of_each_mean(length: int) -> None:
    readings = np.arange(length, dtype=np.float64)
    seen = CalibrationReadings.of([CalibrationTouch(0, readings, readings, 0.0, 0.0, 0.0, 0.0)])
    steps_s, of_step, ends = seen.steps
    ends_s = np.cumsum(steps_s)
    np.testing.assert_allclose(ends_s[ends], seen.times_s)
    # A mean over equal steps of a straight line is its value in the middle.
    np.testing.assert_allclose(seen.reading_k[0], seen.times_s / READING_S - 1.0)
    middles_s = ends_s - 0.5 * np.array(steps_s)
    since_s = (np.cumsum(seen.count) - seen.count)[of_step] * READING_S
    assert (middles_s >= since_s).all(), "the force of a step is that of its reading"
    assert (middles_s <= since_s + seen.count[of_step] * READING_S + 0.5 * READING_S).all()
    assert len(set(steps_s)) <= 3
