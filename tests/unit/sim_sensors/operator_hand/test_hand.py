import itertools

import numpy as np
import pytest

from common.fingers import FINGERS
from common.scenes.scene import Scene, load_scene
from sim_sensors.operator_hand.hand import ScriptedHand
from sim_sensors.operator_hand.hand_plan import FREE, HOVER_M, QUIESCENT, STROKING, TAPPING

DT_S = 0.002
SCENE = Scene.model_validate(
    {
        "name": "test",
        "calibrated": ["pvc"],
        "objects": [
            {"name": "a", "material": "pvc", "surface": "plain_pvc", "x_m": 0.0, "length_m": 0.06},
            {"name": "b", "material": "pvc", "surface": "plain_pvc", "x_m": 0.06, "length_m": 0.06},
        ],
        "script": [
            {"act": "move", "object": "a", "u": 0.5},
            {"act": "touch"},
            {"act": "hold", "seconds": 1.0},
            {"act": "stroke", "to_object": "b", "u": 0.9, "speed_mm_s": 50},
            {"act": "hold", "seconds": 0.3},
            {"act": "lift"},
            {"act": "tap", "times": 2},
            {"act": "wait", "seconds": 0.5},
        ],
    }
)


class Trace:
    """A hand's whole way with a wall of given stiffness at z = 0."""

    def __init__(self, hand: ScriptedHand, seconds: float, wall_n_m: float) -> None:
        rows = []
        for _ in range(round(seconds / DT_S)):
            force = np.maximum(0.0, -hand.z_m * wall_n_m)
            hand.step(DT_S, force)
            rows.append((hand.x_m, *hand.z_m, *force, hand.mode))
        table = np.array(rows)
        self.x_m, self.z_m, self.force_n, self.mode = table[:, 0], table[:, 1:6], table[:, 6:11], table[:, 11]
        self.acts = hand.segment.act


def trace(seconds: float, wall_n_m: float = 400.0, seed: int = 0, fingers: tuple[str, ...] = FINGERS) -> Trace:
    hand = ScriptedHand(SCENE, seed=seed, fingers=fingers)
    hand.start()
    return Trace(hand, seconds, wall_n_m)


def test_it_hovers_over_the_first_object_until_it_is_started() -> None:
    waiting = Trace(ScriptedHand(SCENE, seed=0), 1.0, 400.0)
    assert np.all(np.abs(waiting.x_m - 0.03) < 0.5e-3)
    assert np.all(np.abs(waiting.z_m - HOVER_M) < 0.5e-3)
    assert not waiting.mode.any()


def test_it_meets_the_surface_at_a_persons_speed_and_presses_gently() -> None:
    touch = trace(1.2)
    met = np.argmax(touch.z_m < 0.0, axis=0)
    speed = (touch.z_m[met - 1, range(5)] - touch.z_m[met, range(5)]) / DT_S
    assert np.all((speed > 0.030) & (speed < 0.060))
    assert np.all(np.abs(touch.force_n[-1] - 0.8) < 0.15)


def test_without_force_it_stops_at_the_depth_it_wants() -> None:
    touch = trace(1.2, wall_n_m=0.0)
    assert np.all(np.abs(touch.z_m[-1] + 0.004) < 0.0008)
    assert touch.z_m.min() > -0.0055


def test_it_means_tapping_then_rest_then_stroking() -> None:
    modes = trace(6.0).mode
    order = modes[np.flatnonzero(np.diff(modes, prepend=-1))]
    assert order.tolist()[:6] == [FREE, TAPPING, QUIESCENT, STROKING, QUIESCENT, FREE]
    assert np.count_nonzero(modes == TAPPING) * DT_S == pytest.approx(3 * 0.15, abs=0.02)


def test_a_stroke_has_the_scripts_speed_and_rest_is_slower_than_a_stroke() -> None:
    whole = trace(4.2)
    speed = np.gradient(whole.x_m, DT_S)
    stroking = speed[whole.mode == STROKING]
    assert np.median(stroking) == pytest.approx(0.050, rel=0.12)
    resting = slice(round(0.6 / DT_S), round(1.3 / DT_S))
    assert np.all(whole.mode[resting] == QUIESCENT)
    assert np.abs(speed[resting]).max() < 0.004


def test_fingers_that_take_no_part_stay_up() -> None:
    z_m = trace(6.0, fingers=("index",)).z_m
    assert z_m[:, 1].min() < -0.001
    assert z_m[:, [0, 2, 3, 4]].min() > 0.004


def test_the_script_starts_again_and_goes_back() -> None:
    hand = ScriptedHand(SCENE, seed=3)
    hand.start()
    whole = Trace(hand, hand.total_seconds() + 1.7, 400.0)
    assert abs(whole.x_m[-1] - 0.03) < 1e-3
    assert whole.mode[-1] == QUIESCENT
    assert np.abs(np.diff(whole.x_m)).max() < 0.30 * DT_S


def test_the_seed_repeats_a_hand_and_another_seed_does_not() -> None:
    assert np.array_equal(trace(2.0, seed=1).z_m, trace(2.0, seed=1).z_m)
    assert not np.array_equal(trace(2.0, seed=1).z_m, trace(2.0, seed=2).z_m)


def test_finish_stops_and_lifts_from_the_middle_of_a_stroke() -> None:
    hand = ScriptedHand(SCENE, seed=0)
    hand.start()
    Trace(hand, 2.5, 400.0)
    assert hand.segment.act == "stroke"
    hand.finish()
    rest = Trace(hand, 1.0, 400.0)
    assert rest.z_m[200:].min() > 0.004
    assert np.ptp(rest.x_m[100:]) < 0.5e-3
    assert not rest.mode.any()


def test_a_pass_through_the_materials_scene_fits_into_a_minute_and_has_no_gaps() -> None:
    for seed in range(5):
        hand = ScriptedHand(load_scene("materials"), seed=seed)
        assert 50.0 < hand.total_seconds() < 60.0
        plan = hand.timeline()
        for before, after in itertools.pairwise(plan):
            assert after.start_s == pytest.approx(before.start_s + before.duration_s)
            assert after.from_x_m == before.to_x_m


def test_a_hand_without_a_script_hovers():
    hand = ScriptedHand(SCENE.model_copy(update={"script": ()}), seed=0)
    hand.start()
    for _ in range(500):
        hand.step(DT_S, np.zeros(len(FINGERS)))
    assert hand.mode == FREE
    assert hand.z_m == pytest.approx(np.full(len(FINGERS), HOVER_M), abs=0.5e-3)
