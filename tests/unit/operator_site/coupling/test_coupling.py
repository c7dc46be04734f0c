"""Clutch, re-basing and motion scale: the command never steps, and refusals leave everything as it was."""

from contextlib import suppress

import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.fingers import FINGERS
from common.limits import COUPLING_STEP_M, MOTION_SCALES, REMOTE_LOW_M, REMOTE_PLANE_M
from common.link.session_state import Refused
from common.wire.messages import MOTION_BLOCK, pack_hand
from operator_site.coupling.coupling import DIRECT, EDGE_HEIGHT_M, Coupling, Places, edges
from operator_site.coupling.motion_coupling import MotionCoupling

STEP_M = 1e-3
"""Largest motion of the hand in a tick, m: 0.5 m/s at 500 Hz."""

moves = st.tuples(*[st.floats(-STEP_M, STEP_M)] * 7)
changes = st.sampled_from(["open", "closed", "1", "2", "5", "pressing", "lifted", "pause", "engage", "", "", ""])


class Hand:
    """A hand in a session; it collects the notes of its coupling."""

    def __init__(self, x_m: float = 0.0, y_m: float = 0.0, z_m: float = 0.0) -> None:
        self.notes: list[tuple[str, str]] = []
        self.coupling = MotionCoupling(lambda what, text: self.notes.append((what, text)))
        self.place = Places(x_m, y_m, (z_m,) * len(FINGERS))
        self.engaged, self.session = True, 7
        self.step()

    def step(self) -> None:
        self.coupling.step(self.engaged, self.session, self.place)

    def move(self, by: tuple[float, ...]) -> None:
        """Move within the hand's own range."""
        x_m, y_m, *z_m = [value + change for value, change in zip(axes(self.place), by, strict=True)]
        within = [min(0.0103, max(-0.0103, height_m)) for height_m in z_m]
        self.place = Places(min(0.66, max(-0.66, x_m)), min(0.66, max(-0.66, y_m)), tuple(within))
        self.step()

    def to(self, x_m: float, y_m: float, z_m: float) -> None:
        self.place = Places(x_m, y_m, (z_m,) * len(FINGERS))
        self.step()

    def change(self, change: str) -> None:
        match change:
            case "open" | "closed":
                self.coupling.ask("clutch", {"open": change == "open"})
            case "pressing" | "lifted":
                self.coupling.pressed_n = 1.0 if change == "pressing" else 0.0
            case "pause" | "engage":
                self.engaged = change == "engage"
                self.step()
            case "1" | "2" | "5":
                self.coupling.ask("scale", {"scale": int(change)})

    @property
    def command(self) -> Places:
        return self.coupling.now.command(self.place)


def axes(place: Places) -> tuple[float, ...]:
    return place.x_m, place.y_m, *place.z_m


@given(
    st.tuples(st.floats(-0.66, 0.66), st.floats(-0.66, 0.66), st.floats(-0.0103, 0.0103)),
    st.lists(st.tuples(changes, moves)),
)
def test_the_command_never_steps(start: tuple[float, float, float], acts: list[tuple[str, tuple[float, ...]]]) -> None:
    hand = Hand(*start)
    for change, move in acts:
        before = axes(hand.command)
        with suppress(Refused):
            hand.change(change)
        assert axes(hand.command) == pytest.approx(before, abs=1e-9), "a change alone moves nothing"
        moved = axes(hand.place)
        hand.move(move)
        n = 1 if hand.coupling.now.direct else hand.coupling.now.scale
        for now_m, before_m, hand_m, was_m in zip(axes(hand.command), before, axes(hand.place), moved, strict=True):
            assert abs(now_m - before_m) <= abs(hand_m - was_m) / n + 1e-9 < STEP_M + COUPLING_STEP_M
        command = hand.command
        MOTION_BLOCK.check(pack_hand(*command))


def test_a_new_session_is_direct_to_the_last_bit() -> None:
    hand = Hand(0.1, -0.2, -0.0)
    assert hand.coupling.now is DIRECT
    assert str(hand.command) == str(hand.place), "also the sign of a zero"
    hand.change("2")
    hand.session = 8
    hand.step()
    assert hand.coupling.now is DIRECT


@pytest.mark.parametrize("scale", [2, 5])
def test_the_command_moves_a_share_of_the_hand(scale: int) -> None:
    hand = Hand(0.1, 0.0, 0.002)
    hand.change(str(scale))
    hand.to(0.13, -0.02, -0.003)
    assert hand.command.x_m == pytest.approx(0.1 + 0.03 / scale)
    assert hand.command.y_m == pytest.approx(-0.02 / scale)
    assert hand.command.z_m == pytest.approx([0.002 - 0.005 / scale] * 5)
    assert hand.coupling.now.hand_height_m(1, hand.command.z_m[1]) == pytest.approx(-0.003)


def test_an_open_clutch_holds_the_command_and_closes_at_any_place() -> None:
    hand = Hand(0.1, 0.1, 0.0)
    hand.change("open")
    hand.to(-0.2, 0.0, 0.008)
    assert axes(hand.command) == (0.1, 0.1, *[0.0] * 5)
    hand.change("closed")
    hand.to(-0.19, 0.0, 0.007)
    assert axes(hand.command) == pytest.approx((0.11, 0.1, *[-0.001] * 5))
    assert hand.notes == [("clutch", "open"), ("clutch", "closed")]


def test_a_pause_keeps_the_coupling_and_engaging_closes_the_clutch_at_the_hand() -> None:
    hand = Hand()
    hand.change("5")
    hand.change("open")
    hand.change("pause")
    hand.to(0.2, 0.0, 0.0)
    assert hand.coupling.now.open
    hand.change("engage")
    assert (hand.coupling.now.open, hand.coupling.now.scale) == (False, 5)
    assert hand.command.x_m == 0.0
    hand.to(0.25, 0.0, 0.0)
    assert hand.command.x_m == pytest.approx(0.01)


def test_a_command_beyond_the_range_waits_there_and_follows_again_after_the_clutch() -> None:
    hand = Hand(0.0, 0.0, -0.005)
    hand.change("open")
    hand.to(0.0, 0.0, 0.004)
    hand.change("closed")
    hand.to(0.0, 0.0, -0.008)
    assert hand.command.z_m == (-0.0103,) * 5
    hand.change("open")
    hand.change("closed")
    hand.to(0.0, 0.0, -0.007)
    assert hand.command.z_m == pytest.approx([-0.0093] * 5), "no way back through what lay beyond"


@pytest.mark.parametrize(
    ("verb", "details", "why"),
    [
        ("clutch", {}, "clutch needs open: true or false"),
        ("clutch", {"open": 1}, "clutch needs open: true or false"),
        ("scale", {}, "the motion scale is one of 1:1, 1:2, 1:5"),
        ("scale", {"scale": 3}, "the motion scale is one of 1:1, 1:2, 1:5"),
        ("scale", {"scale": 2.0}, "the motion scale is one of 1:1, 1:2, 1:5"),
        ("scale", {"scale": True}, "the motion scale is one of 1:1, 1:2, 1:5"),
    ],
)
def test_a_request_with_wrong_details_is_refused(verb: str, details: dict[str, object], why: str) -> None:
    hand = Hand()
    with pytest.raises(Refused, match=f"^{why}$"):
        hand.coupling.ask(verb, details)
    assert hand.coupling.now is DIRECT
    assert hand.notes == []


def test_the_clutch_opens_only_while_engaged_and_closes_at_any_time() -> None:
    hand = Hand()
    hand.change("pause")
    with pytest.raises(Refused, match="the clutch opens only while engaged"):
        hand.change("open")
    hand.change("closed")
    assert hand.notes == []


def test_the_scale_stays_while_a_finger_presses() -> None:
    hand = Hand()
    hand.change("pressing")
    with pytest.raises(Refused, match="a finger presses: lift it, or open the clutch, then change the scale"):
        hand.change("2")
    hand.change("1")  # no change: nothing to refuse
    assert hand.coupling.now is DIRECT


@pytest.mark.parametrize("scale", MOTION_SCALES)
def test_a_recorded_coupling_is_read_to_the_last_bit(scale: int) -> None:
    coupling = Coupling(True, scale, 0.1, -0.2, (0.1 / 3,) * 5, 0.3, 0.0, (-0.001,) * 5)
    assert Coupling.unpack(coupling.pack()) == coupling
    assert Coupling.unpack(DIRECT.pack()) is DIRECT
    with pytest.raises(ValueError, match="scale"):
        Coupling.unpack(Coupling(False, 0, 0.0, 0.0, (0.0,) * 5, 0.0, 0.0, (0.0,) * 5).pack())


def test_edges_are_named_by_the_place_of_the_command() -> None:
    middle, low_m = (0.0,) * 5, REMOTE_LOW_M + 0.5 * EDGE_HEIGHT_M
    assert edges(Places(0.0, 0.0, middle)) == []
    assert edges(Places(REMOTE_PLANE_M, -REMOTE_PLANE_M, middle)) == ["x+", "y-"]
    assert edges(Places(-REMOTE_PLANE_M, REMOTE_PLANE_M, (0.0, 0.0, low_m, 0.0, 0.0))) == ["x-", "y+", "low"]
