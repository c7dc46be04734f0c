"""Duties of the telemanipulator alone: following, stopping, and never lowering a finger while released."""

from itertools import pairwise

import can

from common.fingers import FINGERS
from common.limits import APPROACH_DOWN_M_S, MODULE_TIMEOUT_S
from teletaction.conformance.checklist import HALF_A_REPORT_S, Checklist, How, NotApplicable, Outcome, acting_s, phases
from teletaction.conformance.node_on_trial import TelemanipulatorOnTrial
from teletaction.conformance.node_talk import REPEAT_S, Values, settled

TELEMANIPULATOR: Checklist[TelemanipulatorOnTrial] = Checklist("Telemanipulator; nothing is under its fingers")

STEP_MM, NEAR_MM, STILL_MM = 1.0, 0.3, 0.15
HIGHEST_MM, LOWERED_MM = 9.0, 8.5
"""Height above which a finger has no room to rise, mm, and height to which it is then lowered, mm."""
FOLLOWS_S = 1.0
NEXT_MM = 1e3 * APPROACH_DOWN_M_S * REPEAT_S
TWICE_AT_MOST, MOVING = 0.25, 8
"""Largest share of heights that may be sent twice during motion, and smallest number of heights for a verdict. Encoder
and bus have separate clocks."""
_HEIGHTS, _POSE = "FingerHeightsMeasured", "HandPoseMeasured"


def _command(
    node: TelemanipulatorOnTrial, seconds: float, heights: Values | None, pose: Values | None
) -> list[can.Message]:
    """Command heights, pose or both for `seconds`; return the frames of that time.

    Set-points approach the wanted values no faster than the patient-side gate lets a finger go down.
    """
    place = {**node.talk.now_at(_HEIGHTS), **node.talk.now_at(_POSE)}
    wanted = {**place, **(heights or {}), **(pose or {})}

    def send() -> None:
        for each, at in place.items():
            place[each] = at + max(-NEXT_MM, min(NEXT_MM, wanted[each] - at))
        if heights is not None:
            node.talk.say("HeightSetpoint", {each: place.get(each, value) for each, value in heights.items()})
        if pose is not None:
            node.talk.say("HandSetpoint", {each: place[each] for each in pose})

    return node.talk.repeat(send, seconds)


def _stands(node: TelemanipulatorOnTrial) -> tuple[Values, Values]:
    """Return the present heights and pose, after making room above the fingers."""
    heights = node.talk.now_at(_HEIGHTS)
    if not node.lowered and max(heights.values()) > HIGHEST_MM:
        lower = {finger: min(heights[finger], LOWERED_MM) for finger in FINGERS}
        _command(node, FOLLOWS_S, {"released": 0.0, **lower}, None)
        node.settle()
    node.lowered = True
    heights = dict(node.talk.now_at(_HEIGHTS))
    if not _free(heights):
        raise NotApplicable(f"every finger stays above {HIGHEST_MM:g} mm: there is no room above it")
    return heights, dict(node.talk.now_at(_POSE))


def _free(heights: Values) -> list[str]:
    """Return the fingers with room above them; a finger that is not fitted may be parked at the top."""
    return [finger for finger in FINGERS if heights[finger] <= HIGHEST_MM]


def _raised(heights: Values, by_mm: float) -> Values:
    return {**heights, **{finger: heights[finger] + by_mm for finger in _free(heights)}}


def _moved(before: Values, after: Values) -> float:
    """Return the largest difference, mm."""
    return max(abs(after[each] - before[each]) for each in before)


@TELEMANIPULATOR.duty("M1", "Without set-points hand and fingers stay where they are, within 0.15 mm")
def _still(node: TelemanipulatorOnTrial) -> Outcome:
    furthest_mm = 0.0
    for name in (_HEIGHTS, _POSE):
        places = [values for _, values in node.talk.values(node.talk.at_rest, name)]
        if not places:
            raise NotApplicable(f"no {name}")
        furthest_mm = max([furthest_mm, *(_moved(places[0], place) for place in places)])
    return Outcome(furthest_mm <= STILL_MM, f"moved by {furthest_mm:.3f} mm at most")


@TELEMANIPULATOR.duty(
    "M2",
    "Follows set-points of hand and fingers within 0.3 mm in 1 s: 1 mm along x and 1 mm up, and back",
    How.EXERCISE,
)
def _follows(node: TelemanipulatorOnTrial) -> Outcome:
    heights, pose = _stands(node)
    for by_mm in (STEP_MM, 0.0):
        wanted = {**pose, "x": pose["x"] + by_mm}
        _command(node, FOLLOWS_S, {"released": 0.0, **_raised(heights, by_mm)}, wanted)
        up = _raised(heights, by_mm)
        off_mm = max(_moved(up, node.talk.now_at(_HEIGHTS)), _moved(wanted, node.talk.now_at(_POSE)))
        if off_mm > NEAR_MM:
            return Outcome(False, f"{off_mm:.2f} mm off, {by_mm:g} mm from where it stood")
    return Outcome(True, "there and back")


@TELEMANIPULATOR.duty("M3", "Released, the hand stays, independent of HandSetpoint", How.EXERCISE)
def _hand_stays(node: TelemanipulatorOnTrial) -> Outcome:
    heights, pose = _stands(node)
    _command(node, 0.4, {"released": 1.0, **heights}, {**pose, "x": pose["x"] + STEP_MM})
    moved_mm = _moved(pose, node.talk.now_at(_POSE))
    return Outcome(moved_mm <= STILL_MM, f"moved by {moved_mm:.3f} mm")


@TELEMANIPULATOR.duty("M4", "Released, no finger goes down to a set-point below it", How.EXERCISE)
def _no_lower(node: TelemanipulatorOnTrial) -> Outcome:
    heights, _ = _stands(node)
    _command(node, 0.4, {"released": 1.0, **_raised(heights, -STEP_MM)}, None)
    sunk_mm = -min(node.talk.now_at(_HEIGHTS)[finger] - heights[finger] for finger in FINGERS)
    return Outcome(sunk_mm <= STILL_MM, f"down by {max(0.0, sunk_mm):.3f} mm")


@TELEMANIPULATOR.duty("M5", "Released, every finger rises to a set-point above it", How.EXERCISE)
def _rises(node: TelemanipulatorOnTrial) -> Outcome:
    heights, _ = _stands(node)
    _command(node, FOLLOWS_S, {"released": 1.0, **_raised(heights, STEP_MM)}, None)
    risen_mm = min(node.talk.now_at(_HEIGHTS)[finger] - heights[finger] for finger in _free(heights))
    _command(node, FOLLOWS_S, {"released": 0.0, **heights}, None)
    return Outcome(risen_mm >= STEP_MM - NEAR_MM, f"risen by {risen_mm:.2f} of {STEP_MM:g} mm")


@TELEMANIPULATOR.duty(
    "M6",
    "Released is 0 when it follows, and 1 within 100 ms of the last HeightSetpoint, although HandSetpoint continues",
    How.EXERCISE,
)
def _released(node: TelemanipulatorOnTrial) -> Outcome:
    longest_s = 0.0
    for _ in phases(node):
        heights, pose = _stands(node)
        node.talk.say("HeightSetpoint", {"released": 0.0, **heights})
        states = node.talk.states(_command(node, 3.0 * MODULE_TIMEOUT_S, None, pose))
        following = [(at_s, values["released"] == 0.0) for at_s, values in states]
        follows = [each for _, each in following]
        if not any(follows) or follows[-1]:
            return Outcome(False, "released is 0 in " + ("every state frame" if any(follows) else "no state frame"))
        longest_s = max(longest_s, acting_s(following))
    return Outcome(
        longest_s <= MODULE_TIMEOUT_S + HALF_A_REPORT_S,
        f"one frame seen to be followed for {1e3 * longest_s:.0f} ms at most",
    )


@TELEMANIPULATOR.duty(
    "M7", "When the HandSetpoint frames end the hand stops and stays, although HeightSetpoint continues", How.EXERCISE
)
def _hand_stops(node: TelemanipulatorOnTrial) -> Outcome:
    heights, pose = _stands(node)
    _command(node, 0.2, {"released": 0.0, **heights}, pose)
    _command(node, 0.15, {"released": 0.0, **heights}, None)
    stopped = dict(node.talk.now_at(_POSE))
    _command(node, 0.4, {"released": 0.0, **heights}, None)
    moved_mm = _moved(stopped, node.talk.now_at(_POSE))
    return Outcome(moved_mm <= STILL_MM, f"moved by {moved_mm:.3f} mm in 0.4 s after its time-out")


@TELEMANIPULATOR.duty(
    "M8", "Its heights are read 500 times a second: while it moves each frame has new ones", How.EXERCISE
)
def _new_heights(node: TelemanipulatorOnTrial) -> Outcome:
    heights, _ = _stands(node)
    finger = _free(heights)[0]
    rising = _command(node, FOLLOWS_S, {"released": 0.0, **_raised(heights, STEP_MM)}, None)
    _command(node, FOLLOWS_S, {"released": 0.0, **heights}, None)
    way = [values[finger] for _, values in node.talk.values(rising, _HEIGHTS)]
    moving = [height for height in way if 0.1 * STEP_MM < height - heights[finger] < 0.9 * STEP_MM]
    twice = sum(after == before for before, after in pairwise(moving))
    if len(moving) < MOVING:
        raise NotApplicable(f"only {len(moving)} frames while it moves")
    return Outcome(
        twice <= TWICE_AT_MOST * len(moving), f"{twice} of {len(moving)} heights are those of the frame before"
    )


@TELEMANIPULATOR.duty(
    "M9", "Reports released as it was commanded last, 100 ms after a change at the latest", How.EXERCISE
)
def _reports_release(node: TelemanipulatorOnTrial) -> Outcome:
    heights, pose = _stands(node)
    for released in (0.0, 1.0, 0.0):
        states = node.talk.states(_command(node, 3.0 * MODULE_TIMEOUT_S, {"released": released, **heights}, pose))
        if settled(states, MODULE_TIMEOUT_S + HALF_A_REPORT_S)[0]["released"] != released:
            return Outcome(False, f"commanded {released:g}, reported {1.0 - released:g}")
    return Outcome(True, "released and not")
