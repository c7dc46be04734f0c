"""A stuck joint is named within its time while there is a hand; a moving or an unworn finger never is."""

import math
from functools import cache

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.buses.encoder_glitches import FINGER_M_S, HAND_M_S, EncoderGlitches
from common.faults.fault import AXES, Fault, FaultCode
from common.fingers import FINGERS
from common.scenes.scene import SCENES, load_scene
from operator_site.devices.stuck_joint import LIVELY_S, PUSHED_N, STILL_S, STOP_M, StuckJoints
from sim_sensors.operator_hand.hand import ScriptedHand

TICK_S = 0.002
COUNT_M = 5e-6
SECONDS = 8.0
Frame = tuple[float, float, float, list[float], list[float]]


@cache
def worked(scene: str, wall_n_m: float) -> list[Frame]:
    """Time, x, y, heights and forces of a hand that works on a scene against walls; as the bus rounds them."""
    hand, force_n, frames = ScriptedHand(load_scene(scene), seed=0), np.zeros(5), []
    hand.start()
    for tick in range(round(SECONDS / TICK_S)):
        hand.step(TICK_S, force_n)
        z_m = np.round(hand.z_m / COUNT_M) * COUNT_M
        force_n = np.clip(-wall_n_m * z_m, 0.0, 10.0)
        frames.append((tick * TICK_S, hand.x_m, hand.y_m, z_m.tolist(), force_n.tolist()))
    return frames


def watch(frames: list[Frame], taking_part: tuple[bool, ...] = (True,) * 5) -> list[tuple[float, list[Fault]]]:
    pose, heights = EncoderGlitches(AXES, HAND_M_S), EncoderGlitches(FINGERS, FINGER_M_S)
    joints, found = StuckJoints(taking_part), []
    for sent_s, x_m, y_m, z_m, force_n in frames:
        pose.step(sent_s, (x_m, y_m))
        dt_s, _ = heights.step(sent_s, tuple(z_m))
        joints.step(dt_s, z_m, (x_m, y_m), force_n)
        found.append((sent_s, pose.faults + heights.faults + joints.faults))
    return found


def freeze(frames: list[Frame], finger: int, from_s: float) -> list[Frame]:
    held = next(frame[3][finger] for frame in frames if frame[0] >= from_s)
    return [
        (t_s, x_m, y_m, [held if n == finger and t_s >= from_s else z for n, z in enumerate(z_m)], force_n)
        for t_s, x_m, y_m, z_m, force_n in frames
    ]


@pytest.mark.long
@pytest.mark.parametrize("wall_n_m", [0.0, 400.0, 1200.0])
@pytest.mark.parametrize("scene", sorted(path.stem for path in SCENES.glob("*.toml")))
def test_no_hand_at_work_is_ever_a_fault(scene: str, wall_n_m: float) -> None:
    assert not any(faults for _, faults in watch(worked(scene, wall_n_m)))


@pytest.mark.parametrize("from_s", [1.0, 2.5, 4.0])
@pytest.mark.parametrize("finger", range(5))
def test_a_stuck_encoder_of_a_hand_at_work_is_named_within_its_time(finger: int, from_s: float) -> None:
    checked = watch(freeze(worked("materials", 400.0), finger, from_s))
    found_s, faults = next((t_s, faults) for t_s, faults in checked if faults)
    assert [fault[:3] for fault in faults] == [(FaultCode.FINGER_STILL, FINGERS[finger], "")]
    assert faults[0].limit == STILL_S == pytest.approx(faults[0].value, abs=0.01)
    assert found_s - from_s == pytest.approx(STILL_S, abs=0.05)


def test_a_finger_that_is_not_in_the_exoskeleton_may_stand_still() -> None:
    frames = freeze(worked("materials", 400.0), 4, 1.0)
    assert not any(faults for _, faults in watch(frames, (True, True, True, True, False)))


def step_still(
    fingers: StuckJoints, seconds: float, z_m: float = 0.0, pushed_n: tuple[float, ...] = (0.0,) * 5
) -> None:
    for _ in range(round(seconds / TICK_S)):
        fingers.step(TICK_S, [z_m] * 5, (0.0, 0.0), pushed_n)


def test_only_a_pushed_joint_that_does_not_give_is_stuck_without_a_hand() -> None:
    fingers = StuckJoints()
    step_still(fingers, 20.0)
    assert fingers.faults == []
    step_still(fingers, STILL_S + TICK_S, pushed_n=(0.0, PUSHED_N, 0.0, 0.0, 0.0))
    assert [fault.where for fault in fingers.faults] == ["index"]
    at_its_stop = StuckJoints()
    step_still(at_its_stop, 20.0, z_m=STOP_M, pushed_n=(10.0,) * 5)
    assert at_its_stop.faults == []


def test_a_brief_rest_of_a_hand_starts_no_check_beyond_its_active_time() -> None:
    fingers, random = StuckJoints(), np.random.default_rng(0)
    for _ in range(500):
        fingers.step(TICK_S, [0.0, *(COUNT_M * random.integers(0, 5, 4)).tolist()], (0.0, 0.0), (0.0,) * 5)
    before_s = fingers.stuck_s[0]
    step_still(fingers, 20.0)
    assert fingers.stuck_s[0] - before_s <= LIVELY_S + TICK_S


@given(st.lists(st.floats(allow_nan=True), min_size=1, max_size=20))
def test_no_gap_between_frames_is_more_than_a_frame(gaps_s: list[float]) -> None:
    fingers = StuckJoints()
    for gap_s in gaps_s:
        fingers.step(gap_s, [0.0] * 5, (0.0, 0.0), (1.0,) * 5)
    assert max(fingers.stuck_s) <= 0.010 * len(gaps_s) + 1e-9
    assert not math.isnan(max(fingers.stuck_s))
