"""The most tender place is found from presses with and without pain."""

import math

import numpy as np
import pytest

from common.tenderness.presses import Press
from common.tenderness.reaction import ReactionTime
from common.tenderness.tender_place import tender_place
from tests.unit.common.tenderness.made import finder, press


def examined(threshold_of, levels_n=(1.0, 2.0, 3.0), **how):
    found, reaction, t_s = finder(), ReactionTime(), 0.0
    for level_n in levels_n:
        for x_m in np.linspace(0.0, 0.04, 6):
            for y_m in np.linspace(0.0, 0.04, 6):
                threshold_n = threshold_of(float(x_m), float(y_m))
                x, y = float(x_m), float(y_m)
                changed = press(found, start_s=t_s, level_n=level_n, threshold_n=threshold_n, x_m=x, y_m=y, **how)
                if changed:
                    reaction.learn(found.presses[-1])
                t_s += 20.0
    return tender_place(found.presses, reaction)


def tender(x_m, y_m):
    return 6.0 - 4.2 * math.exp(-0.5 * ((x_m - 0.025) ** 2 + (y_m - 0.013) ** 2) / 0.01**2)


def test_centre_and_threshold_are_found():
    place = examined(tender)
    assert math.dist((place.x_m, place.y_m), (0.025, 0.013)) < 0.004
    assert place.sd_m < 0.004
    assert place.low_n < place.threshold_n < place.high_n
    assert place.threshold_n == pytest.approx(1.8, rel=0.25)
    assert place.probability > 0.95


def test_a_finger_that_presses_lightly_beside_it_does_not_move_it():
    place = examined(tender, lightly_n=0.4)
    assert math.dist((place.x_m, place.y_m), (0.025, 0.013)) < 0.005


def test_a_finger_that_does_not_touch_is_nowhere():
    apart = [0.0, 0.0], [0.0, 1.0]
    press = Press([0.0, 2.0], [(0.0, 0.0), (2.0, 0.0)], *apart, [2.0, 0.0], risen_s=1.8, fallen_s=2.4)
    place = tender_place([press], ReactionTime())
    assert math.dist((place.x_m, place.y_m), (0.0, 0.0)) < 0.001
    assert place.sd_m < 0.01


def test_without_pain_there_is_no_place():
    assert examined(lambda x_m, y_m: 9.0, levels_n=(1.0,)) is None


def test_a_threshold_that_is_the_same_everywhere_is_no_place():
    place = examined(lambda x_m, y_m: 1.8, levels_n=(1.0, 2.5))
    assert place.probability < 0.5
    assert place.sd_m > 0.01
