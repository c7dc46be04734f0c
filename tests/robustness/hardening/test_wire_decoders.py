"""Broken packets into every decoder of the network link."""

from typing import Any

import pytest

from common.wire.packets import BadPacket
from tests.robustness.hardening.broken import Breaker, swap_values_of
from tests.robustness.hardening.harmless import harmless_packet
from tests.robustness.hardening.specimens import PACKETS, good_packets
from tests.robustness.hardening.survival import FRAMES, check, survive


@pytest.mark.parametrize("frames", FRAMES)
@pytest.mark.parametrize("kind", PACKETS, ids=lambda kind: kind.__name__)
def test_any_packet_is_refused_by_the_one_error_or_harmless(kind: Any, frames: int, golden: dict[str, bytes]) -> None:
    good = good_packets(kind, golden)
    # Most mutations of bytes are no MessagePack any more; these are, and get to the checks of the fields.
    breaker = Breaker(good, longest=600, mutations=[swap_values_of(good)] * 8)
    check(survive(kind.decode, (BadPacket,), harmless_packet, good, breaker.frames(frames), frames))
