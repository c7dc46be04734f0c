"""A simulated finger that follows commands: motion, force, truth, and the readings of noisy sensors."""

import numpy as np
import pytest

from sim_sensors.physics.true_mode import FREE, QUIESCENT, STROKING, TAPPING
from sim_sensors.traces.commanded_hand import TICK_S, CommandedHand
from sim_sensors.traces.simulated_exploration import FORCE_STEP_N, Explored, explore, sense

STIFFNESS_N_M = 3000.0


def lived(hand: CommandedHand, seed: int = 0) -> Explored:
    return explore(hand, STIFFNESS_N_M, np.random.default_rng(seed))


def landed() -> CommandedHand:
    hand = CommandedHand()
    hand.stay(0.1)
    hand.height(-0.0015, 0.3)
    hand.stay(0.3)
    return hand


def order(explored: Explored) -> list[int]:
    mode = explored.mode
    return [int(mode[0]), *mode[1:][np.diff(mode) != 0].tolist()]


def test_touch_rest_stroke_rest_lift() -> None:
    hand = landed()
    hand.stroke(0.03, 0.05)
    hand.stay(0.3)
    hand.height(0.006, 0.2)
    hand.stay(0.1)
    explored = lived(hand)
    assert order(explored) == [FREE, TAPPING, QUIESCENT, STROKING, QUIESCENT, FREE]
    assert np.hypot(explored.x_m[-1] - explored.x_m[0], explored.y_m[-1] - explored.y_m[0]) == pytest.approx(
        0.03, abs=0.5e-3
    )
    ((tick, approach_m_s),) = explored.landings
    fell_m_s = (explored.z_m[tick - 6] - explored.z_m[tick - 3]) / (3 * TICK_S)
    assert approach_m_s == pytest.approx(fell_m_s, rel=0.2)


def test_a_shaking_arm_is_no_stroke_but_a_slip_is_one() -> None:
    shaken, slipped = landed(), landed()
    shaken.shake(0.5e-3, 8.0, 1.0)
    slipped.slip(0.004, 0.08)
    slipped.stay(0.3)
    assert order(lived(shaken)) == [FREE, TAPPING, QUIESCENT]
    assert np.ptp(lived(shaken).x_m) + np.ptp(lived(shaken).y_m) > 0.9e-3
    assert order(lived(slipped)) == [FREE, TAPPING, QUIESCENT, STROKING, QUIESCENT]


def test_a_finger_goes_up_while_the_hand_goes_on() -> None:
    hand = landed()
    hand.change_speed(0.0, 0.05)
    hand.height(0.0015, 0.06, along_speed_m_s=0.05)
    hand.height(-0.0015, 0.06, along_speed_m_s=0.05)
    hand.sway(0.0002, 2.0, 1.0, along_speed_m_s=0.05)
    assert order(lived(hand)) == [FREE, TAPPING, QUIESCENT, STROKING, FREE, TAPPING, STROKING]


@pytest.mark.long
def test_noise_is_what_it_is_said_to_be() -> None:
    hand = CommandedHand()
    hand.stay(60.0)
    explored = lived(hand)
    for noise in (1.0, 3.0):
        sensed = sense(explored, noise, np.random.default_rng(1))
        error_m = sensed.x_m - explored.x_m[sensed.tick]
        expected_m = noise * np.hypot(10e-6, 20e-6 / np.sqrt(12.0))
        assert float(error_m.std()) == pytest.approx(expected_m, rel=0.1)
        assert sensed.force_n.min() == 0.0
        assert np.allclose(np.round(sensed.force_n / FORCE_STEP_N), sensed.force_n / FORCE_STEP_N)
        assert float(np.sqrt(2.0 * (sensed.force_n**2).mean())) == pytest.approx(noise * 0.01, rel=0.2)
        assert (np.diff(sensed.time_s) > 0.0).all()
        assert np.diff(sensed.tick).max() > 2, "some ticks are lost"


def test_the_same_seed_is_the_same_finger() -> None:
    assert (lived(landed(), 3).x_m == lived(landed(), 3).x_m).all()
    assert (lived(landed(), 3).x_m != lived(landed(), 4).x_m).any()
