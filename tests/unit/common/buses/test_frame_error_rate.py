"""A few damaged frames are no fault; too many of a kind, or no good one, are a named fault."""

from hypothesis import given
from hypothesis import strategies as st

from common.buses.frame_error_rate import MOST, WINDOW, FrameErrorRate
from common.faults.fault import Fault, FaultCode
from common.faults.texts import fault_text
from common.limits import GAP_S

FRAME_S = 0.002


@given(st.lists(st.booleans(), max_size=300))
def test_a_fault_is_there_while_more_than_the_share_of_the_window_is_damaged(frames: list[bool]) -> None:
    watched = FrameErrorRate("HandPose")
    for n, damaged in enumerate(frames):
        watched.step(n * FRAME_S, damaged)
        recent = frames[max(0, n + 1 - WINDOW) : n + 1]
        seen = str(len(recent))
        expected = Fault(FaultCode.FRAMES_DAMAGED, "HandPose", value=sum(recent), limit=MOST, detail=seen)
        assert watched.fault == (expected if sum(recent) > MOST else None)


def test_a_few_damaged_frames_without_a_good_one_for_the_gap_are_a_fault_of_a_slow_sender() -> None:
    watched, period_s = FrameErrorRate("ExoskeletonState"), 0.030
    for n in range(10):
        watched.step(n * period_s, damaged=False)
    assert watched.fault is None
    away = FrameErrorRate("ExoskeletonState")
    for back_s in (0.0, 100.0):
        away.step(back_s, damaged=False)
    assert away.fault is None, "a bus that was away for long and comes back sound is sound"
    found = []
    for n in range(10, 15):
        watched.step(n * period_s, damaged=True)
        found.append(watched.fault)
    late = next(n for n, fault in enumerate(found) if fault)
    assert (late + 1) * period_s > GAP_S >= late * period_s
    assert fault_text(found[late]) == "ExoskeletonState: no good frame for 120 ms, at most 100 ms: only damaged ones"
    watched.step(15 * period_s, damaged=False)
    assert watched.fault is None


def test_a_node_that_was_silent_is_not_accused_for_its_first_frame() -> None:
    """A node that was switched off counts from 0 again; this may be the last counter that was read."""
    watched = FrameErrorRate("ExoskeletonState")
    for n in range(100):
        watched.step(n * FRAME_S, damaged=n == 70)
    for back_s in (10.0, 10.03, 10.06, 10.09):
        watched.step(back_s, damaged=True)
        assert watched.fault is None, "a silence is no time in which damaged frames arrive"
    watched.step(10.12, damaged=True)
    assert watched.fault is not None


def test_all_damaged_is_found_within_25_ms_and_30_percent_within_the_gap() -> None:
    for every, within_s in ((1, 0.025), (3, GAP_S)):
        watched, n = FrameErrorRate("FingerHeights"), 0
        while not watched.fault:
            n += 1
            watched.step(n * FRAME_S, damaged=n % every == 0)
        assert n * FRAME_S <= within_s
