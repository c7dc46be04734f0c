"""Broken CAN frames into the decoder of every frame of the description."""

import binascii

import pytest
from cantools.database.can import Message

from common.buses.can_frames import BadFrame, FrameReceiver
from tests.robustness.hardening.broken import Breaker
from tests.robustness.hardening.harmless import HarmlessValues
from tests.robustness.hardening.specimens import CAN_FRAMES, good_can_frames, has_crc
from tests.robustness.hardening.survival import FRAMES, check, survive


@pytest.mark.parametrize("frames", FRAMES)
@pytest.mark.parametrize("message", CAN_FRAMES, ids=lambda message: message.name)
def test_any_frame_is_refused_by_the_one_error_or_harmless(message: Message, frames: int) -> None:
    def with_good_crc(broken: bytes) -> bytes:
        if len(broken) < message.length:
            return broken
        head = broken[: message.length - 1]
        return head + bytes((binascii.crc_hqx(message.frame_id.to_bytes(2, "big") + head, 0xFFFF) & 0xFF,))

    receiver, good = FrameReceiver(message.name), good_can_frames(message)
    breaker = Breaker(good, longest=64, mend=with_good_crc if has_crc(message) else None)
    survival = survive(receiver.decode, (BadFrame,), HarmlessValues(message), good, breaker.frames(frames), frames)
    check(survival)
    assert receiver.refused >= survival.frames - survival.accepted, "a refused frame was not counted"
