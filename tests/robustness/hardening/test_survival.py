"""The harness itself finds every kind of failure."""

import pytest

from tests.robustness.hardening.broken import Breaker, swap_values_of, value_spans
from tests.robustness.hardening.survival import NotSurvived, check, survive

FEW = 5_000
GOOD = [b"\x93\x01\xa2ab\x81\xa1k\x02"]


def nothing_to_judge(_: bytes, __: object) -> None:
    return None


def test_an_undeclared_error_is_reported_with_the_frame() -> None:
    with pytest.raises(NotSurvived, match=r"frame 0 6f6e65: IndexError"):
        survive(
            lambda frame: frame[5] if frame != b"good" else 0, (ValueError,), nothing_to_judge, [b"good"], [b"one"], 1
        )


def test_an_accepted_harmful_value_is_reported_with_the_frame() -> None:
    def judge(_: bytes, value: int) -> None:
        assert value < 3

    with pytest.raises(NotSurvived, match=r"frame 1 66697665 gave 4"):
        survive(len, (), judge, [b"good"], [b"on", b"five"], 2)


def test_memory_that_grows_with_the_frames_is_noticed() -> None:
    kept: list[bytes] = []

    def leak(frame: bytes) -> None:
        kept.append(frame + b"x")
        if frame.endswith(b"1"):
            raise ValueError("refused")

    frames = (b"frame %d" % number for number in range(FEW))
    with pytest.raises(AssertionError, match=r"memory \+\d+ blocks"):
        check(survive(leak, (ValueError,), nothing_to_judge, GOOD, frames, FEW))


def test_a_decoder_that_takes_all_or_nothing_is_noticed() -> None:
    with pytest.raises(AssertionError, match="never reached"):
        check(survive(len, (), nothing_to_judge, GOOD, GOOD * FEW, FEW))


def test_every_value_of_a_packet_is_found_at_every_depth() -> None:
    (packet,) = GOOD
    assert [packet[start:end] for start, end in value_spans(packet)] == [
        b"\x01",
        b"\xa2ab",
        b"\xa1k",
        b"\x02",
        b"\x81\xa1k\x02",
        packet,
    ]


def test_broken_frames_are_the_same_in_every_run_and_hardly_ever_good(golden: dict[str, bytes]) -> None:
    good = [golden["motion"]]
    breaker = Breaker(good, longest=600, mutations=[swap_values_of(good)])
    frames = list(breaker.frames(1000))
    assert frames == list(breaker.frames(1000))
    assert len(set(frames)) > 900
    assert frames.count(good[0]) < 10
