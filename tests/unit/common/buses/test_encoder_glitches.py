"""One impossible reading is ignored; many, or a lasting one, are a fault; a possible motion never is."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from common.buses.encoder_glitches import FINGER_M_S, GLITCHES, RETURN_S, UNSEEN_S, WINDOW_S, EncoderGlitches
from common.faults.fault import Fault, FaultCode
from common.faults.texts import fault_text
from common.timing.timeouts import FRAME_S

COUNT_M = 5e-6
JUMP_M = 2.0 * FINGER_M_S * FRAME_S
some_jump_m = st.floats(JUMP_M, 0.02) | st.floats(-0.02, -JUMP_M)


class Index:
    """One encoder, frame by frame."""

    def __init__(self) -> None:
        self.encoders = EncoderGlitches(("index",), FINGER_M_S)
        self.sent_s = 5.0
        self.read(0.0)

    def read(self, place_m: float, after_s: float = FRAME_S) -> float:
        """The place to act on for a reading."""
        self.sent_s += after_s
        self.encoders.begin()
        (believed_m,) = self.encoders.step(self.sent_s, (place_m,))[1]
        return believed_m

    @property
    def faults(self) -> list[str]:
        return self.encoders.faults


@given(some_jump_m, st.integers(1, 2))
def test_a_glitch_is_ignored_and_is_no_fault(jump_m: float, frames: int) -> None:
    index = Index()
    for _ in range(frames):
        assert index.read(jump_m) == 0.0
        assert index.faults == []
    assert index.read(COUNT_M) == COUNT_M
    assert (index.faults, index.encoders.refused) == ([], frames)


@given(some_jump_m)
def test_a_lasting_jump_is_a_fault_before_it_is_used(jump_m: float) -> None:
    index = Index()
    assert {index.read(jump_m) for _ in range(int(RETURN_S / FRAME_S))} == {0.0}
    assert index.read(jump_m) == jump_m
    assert list(map(fault_text, index.faults)) == [f"index: encoder jumped by {abs(jump_m) * 1e3:.1f} mm"]
    assert index.read(jump_m) == jump_m
    assert index.faults == []  # it restarts from there: the gate has latched the fault


@given(some_jump_m, st.integers(2, 100))
def test_repeated_glitches_are_a_fault_until_they_end(jump_m: float, apart: int) -> None:
    index, found = Index(), []
    for n in range(apart * (GLITCHES + 2)):
        assert index.read(jump_m if n % apart == 0 else 0.0) == 0.0
        found.append(index.faults)
    fits = GLITCHES * apart * FRAME_S <= WINDOW_S - FRAME_S
    if fits:
        assert (
            found.index([Fault(FaultCode.ENCODER_JUMPS, "index", value=GLITCHES + 1, limit=GLITCHES)])
            == GLITCHES * apart
        )
        for _ in range(round(WINDOW_S / FRAME_S) + 1):
            index.read(0.0)
        assert index.faults == []
    elif GLITCHES * apart * FRAME_S > WINDOW_S + FRAME_S:
        assert not any(found)


@given(st.lists(st.tuples(st.floats(-1.0, 1.0), st.integers(1, 40)), max_size=100))
def test_every_possible_motion_is_accepted_from_any_frames(moves: list[tuple[float, int]]) -> None:
    index, place_m = Index(), 0.0
    for share, frames in moves:
        place_m += share * FINGER_M_S * FRAME_S * frames * (1.0 - 1e-9)
        assert index.read(place_m, FRAME_S * frames) == place_m
        assert index.faults == []


def test_a_fault_counts_until_the_next_tick_whatever_frames_follow_in_this_one() -> None:
    """A site that reads two frames in each tick would otherwise miss half of all faults."""
    index = Index()
    for _ in range(int(RETURN_S / FRAME_S) + 1):
        index.read(JUMP_M)
    index.encoders.step(index.sent_s + FRAME_S, (JUMP_M,))
    assert [fault.code for fault in index.faults] == [FaultCode.ENCODER_JUMPED]


@pytest.mark.parametrize("after_s", [0.0, -1.0, math.nan, math.inf, UNSEEN_S * 1.01])
def test_after_a_gap_or_from_another_gateway_a_finger_may_be_anywhere(after_s: float) -> None:
    index = Index()
    assert index.read(0.01, after_s) == 0.01
    assert (index.faults, index.encoders.refused) == ([], 0)


def test_encoders_are_timed_by_the_bus_and_fail_one_by_one() -> None:
    encoders = EncoderGlitches(("index", "middle"), FINGER_M_S)
    assert math.isnan(encoders.step(5.0, (0.001, 0.0))[0])
    assert encoders.step(5.010, (0.015, 0.0)) == (5.010 - 5.0, (0.015, 0.0))  # 14 mm, but in 10 ms
    assert encoders.step(5.012, (0.015, 0.008))[1] == (0.015, 0.0)
    encoders.step(5.014, (0.0151, 0.008))
    assert encoders.step(5.017, (0.0152, 0.008))[1] == (0.0152, 0.008)
    assert list(map(fault_text, encoders.faults)) == ["middle: encoder jumped by 8.0 mm"]
    encoders.begin()
    encoders.step(1.0, (0.0, 0.0))
    assert encoders.faults == []
