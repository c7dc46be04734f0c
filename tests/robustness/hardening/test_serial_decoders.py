"""Broken bytes into the reader of a serial line, and broken payloads into every decoder behind it."""

from typing import Any

import pytest

from common.buses.serial_messages import MAX_FRAME, BadPayload, Frame, FrameReader, encode_frame
from tests.robustness.hardening.broken import Breaker
from tests.robustness.hardening.harmless import harmless_frames, harmless_payload
from tests.robustness.hardening.specimens import PAYLOADS, good_payloads, serial_frames
from tests.robustness.hardening.survival import FRAMES, check, survive

NEXT = encode_frame(0x55, 9, b"next")
NEXT_FRAME = Frame(0x55, 9, b"next")


class NothingRead(Exception):
    """A broken line held no frame."""


class Line:
    """A serial line on which each broken piece is followed by a good frame."""

    def __init__(self) -> None:
        self._reader = FrameReader()

    def read(self, broken: bytes) -> list[Frame]:
        """The frames that the broken piece held; raises NothingRead."""
        damaged = self._reader.damaged
        *frames, last = self._reader.feed(broken) + self._reader.feed(b"\0" + NEXT)
        assert last == NEXT_FRAME, "the next good frame was not read"
        pieces = sum(1 for piece in broken.split(b"\0") if piece)
        assert len(frames) + self._reader.damaged - damaged >= pieces, "something damaged was not counted"
        if not frames:
            raise NothingRead
        return frames


def with_good_crc(broken: bytes) -> bytes:
    """A good frame of broken content."""
    return encode_frame(broken[0], broken[1], broken[2 : MAX_FRAME - 2]) if len(broken) > 1 else broken


@pytest.mark.parametrize("frames", FRAMES)
@pytest.mark.parametrize("kind", PAYLOADS, ids=lambda kind: kind.__name__)
def test_any_payload_is_refused_by_the_one_error_or_harmless(kind: Any, frames: int, golden: dict[str, bytes]) -> None:
    good = good_payloads(kind, golden)
    breaker = Breaker(good, longest=MAX_FRAME)
    check(survive(kind.decode, (BadPayload,), harmless_payload, good, breaker.frames(frames), frames))


@pytest.mark.parametrize("frames", FRAMES)
def test_any_bytes_on_a_line_raise_nothing_are_counted_and_the_next_good_frame_is_read(
    frames: int, golden: dict[str, bytes]
) -> None:
    good = [line for line, _ in serial_frames(golden)]
    breaker = Breaker(good, longest=3 * MAX_FRAME, mend=with_good_crc)
    check(survive(Line().read, (NothingRead,), harmless_frames, good, breaker.frames(frames), frames))
