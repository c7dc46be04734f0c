"""Stated deviations of made-up presses hold their errors, also those that all presses of an object share."""

from dataclasses import replace

import numpy as np
import pytest

from remote_site.stiffness.recorded.identify_stiffness import identify_presses
from remote_site.traces.press_files import Contact, Press
from tests.presses import spring_presses

TRUE_N_M = 500.0


def errors_sd(presses: list[Press]) -> np.ndarray:
    """Return the errors of ln stiffness, in stated standard deviations; the presses are of one stiffness."""
    answers = identify_presses(presses)
    assert all(answer["stiffness_n_m"] for answer in answers)
    value, sd = (np.array([answer[key] for answer in answers]) for key in ("stiffness_n_m", "stiffness_sd_n_m"))
    return np.log(value / TRUE_N_M) * value / sd


@pytest.mark.parametrize(
    ("exponent", "contact_mm", "noise_n"),
    [(1.0, 0.0, 0.005), (1.3, -0.1, 0.005), (1.3, -0.3, 0.005), (1.0, 0.2, 0.05), (2.2, -0.1, 0.02)],
)
def test_an_error_that_all_presses_share_is_within_the_deviation(exponent, contact_mm, noise_n):
    how = {"exponent": exponent, "contact_mm": contact_mm, "noise_n": noise_n, "spread": 0.0, "samples": 14}
    errors = errors_sd(spring_presses(20, **how, seed=5))
    assert abs(np.median(errors)) < 2.0


@pytest.mark.long
def test_one_in_twenty_truths_is_outside_two_deviations():
    random, outside = np.random.default_rng(8), []
    for exponent in (1.0, 1.3, 1.5, 2.2, 3.0):
        for seed in range(3):
            contact_mm, noise_n = random.uniform(-0.2, 0.15), np.exp(random.uniform(np.log(0.008), np.log(0.054)))
            how = {"exponent": exponent, "contact_mm": contact_mm, "noise_n": noise_n, "spread": 0.0}
            outside.append(np.mean(np.abs(errors_sd(spring_presses(8, **how, seed=seed))) > 2.0))
    assert np.mean(outside) < 0.12


def test_a_stated_contact_gives_a_smaller_deviation():
    presses = spring_presses(20, exponent=1.5)
    stated = [replace(press, contact=Contact(status="ok")) for press in presses]
    for assumed, known in zip(identify_presses(presses), identify_presses(stated), strict=True):
        assert known["stiffness_sd_n_m"] < assumed["stiffness_sd_n_m"]
        assert known["stiffness_repeat_sd_n_m"] == pytest.approx(assumed["stiffness_repeat_sd_n_m"], rel=0.1)


def test_more_presses_do_not_remove_the_error_that_they_share():
    few, many = (identify_presses(spring_presses(count, exponent=1.5, spread=0.0)) for count in (8, 40))
    assert np.median([answer["stiffness_sd_n_m"] for answer in many]) > 0.6 * np.median(
        [answer["stiffness_sd_n_m"] for answer in few]
    )


@pytest.mark.parametrize("count", [1, 10])
def test_what_differs_between_presses_is_a_part_of_the_whole(count):
    for answer in identify_presses(spring_presses(count, exponent=1.3)):
        assert 0.0 < answer["stiffness_repeat_sd_n_m"] < answer["stiffness_sd_n_m"]


def test_air_before_the_press_leaves_only_the_error_of_the_law():
    depth_mm = np.linspace(-0.6, 3.0, 18)
    random, presses = np.random.default_rng(4), []
    for press in range(20):
        force_n = (np.maximum(depth_mm, 0.0) / 2.0) ** 1.3 + 0.005 * random.standard_normal(len(depth_mm))
        presses.append(Press(press, depth_mm, force_n))
    shifted = [replace(press, depth_mm=press.depth_mm[4:], force_n=press.force_n[4:]) for press in presses]
    through_air, from_surface = identify_presses(presses), identify_presses(shifted)
    assert np.median([answer["stiffness_sd_n_m"] for answer in through_air]) < np.median(
        [answer["stiffness_sd_n_m"] for answer in from_surface]
    )
