"""One impossible reading is not acted on; many, or one that stays, are named; what a finger can do never is."""

import math

from hypothesis import given
from hypothesis import strategies as st

from common.encoder_jumps import FINGER_M_S, FRAME_S, GLITCHES, RETURN_S, UNSEEN_S, WINDOW_S, EncoderJumps, Encoders

COUNT_M = 5e-6
JUMP_M = 2.0 * FINGER_M_S * FRAME_S
some_jump_m = st.floats(JUMP_M, 0.02) | st.floats(-0.02, -JUMP_M)


def steady(place_m: float = 0.0) -> EncoderJumps:
    encoder = EncoderJumps(FINGER_M_S)
    for _ in range(5):
        encoder.step(FRAME_S, place_m)
    return encoder


@given(some_jump_m, st.integers(1, 2))
def test_a_glitch_is_not_acted_on_and_is_no_fault(jump_m: float, frames: int) -> None:
    encoder = steady()
    for _ in range(frames):
        assert encoder.step(FRAME_S, jump_m) == 0.0
        assert encoder.fault == ""
    assert encoder.step(FRAME_S, COUNT_M) == COUNT_M
    assert (encoder.fault, encoder.refused) == ("", frames)


@given(some_jump_m)
def test_a_jump_that_stays_is_a_fault_before_it_is_acted_on(jump_m: float) -> None:
    encoder = steady()
    given_m = [encoder.step(FRAME_S, jump_m) for _ in range(round(RETURN_S / FRAME_S) - 1)]
    assert set(given_m) == {0.0}
    assert encoder.step(FRAME_S, jump_m) == jump_m
    assert encoder.fault == f"encoder jumped by {abs(jump_m) * 1e3:.1f} mm"
    encoder.step(FRAME_S, jump_m)
    assert encoder.fault == ""  # it begins anew from there: the gate has latched it


@given(some_jump_m, st.integers(2, 100))
def test_glitches_again_and_again_are_a_fault_as_long_as_they_go_on(jump_m: float, apart: int) -> None:
    encoder, found = steady(), []
    for n in range(apart * (GLITCHES + 2)):
        given_m = encoder.step(FRAME_S, jump_m if n % apart == 0 else 0.0)
        assert given_m == 0.0
        found.append(encoder.fault)
    fits = GLITCHES * apart * FRAME_S <= WINDOW_S
    assert any(found) is fits
    if fits:
        assert found.index(f"encoder jumps: {GLITCHES + 1} times in {WINDOW_S:g} s") == GLITCHES * apart
        for _ in range(round(WINDOW_S / FRAME_S) + 1):
            encoder.step(FRAME_S, 0.0)
        assert encoder.fault == ""


@given(st.lists(st.tuples(st.floats(-1.0, 1.0), st.integers(1, 40)), max_size=100))
def test_whatever_a_finger_can_do_is_believed_whichever_frames_come(moves: list[tuple[float, int]]) -> None:
    encoder, place_m = EncoderJumps(FINGER_M_S), 0.0
    for share, frames in moves:
        place_m += share * FINGER_M_S * FRAME_S * frames * (1.0 - 1e-9)
        assert encoder.step(FRAME_S * frames, place_m) == place_m
        assert encoder.fault == ""


@given(st.sampled_from([0.0, -1.0, math.nan, math.inf, UNSEEN_S * 1.01]), some_jump_m)
def test_after_a_gap_or_a_clock_set_back_a_finger_may_be_anywhere(dt_s: float, jump_m: float) -> None:
    encoder = steady()
    assert encoder.step(dt_s, jump_m) == jump_m
    assert (encoder.fault, encoder.refused) == ("", 0)


def test_encoders_are_timed_by_the_bus_and_fail_one_by_one() -> None:
    encoders = Encoders(("index", "middle"), FINGER_M_S)
    assert math.isnan(encoders.step(5.0, (0.001, 0.0))[0])
    assert encoders.step(5.010, (0.015, 0.0)) == (5.010 - 5.0, [0.015, 0.0])  # 14 mm, but in 10 ms
    assert encoders.step(5.012, (0.015, 0.008))[1] == [0.015, 0.0]
    encoders.step(5.014, (0.015, 0.008))
    encoders.step(5.016, (0.015, 0.008))
    assert encoders.faults == ["middle: encoder jumped by 8.0 mm"]
    encoders.step(1.0, (0.0, 0.0))  # another gateway, with another clock
    assert encoders.faults == []
