"""Packets of the `voice` stream: both ends send the same packet, with a sound or without one.

A sound is one frame of Opus (RFC 6716). Each end stamps times of its own clock, so that the other end knows the age of
each sound (`common.link.stream_clock`). A packet also acknowledges the newest packet that its sender has read.
"""

from enum import IntEnum
from typing import Annotated

from msgspec import Meta

from common.wire.packets import Integer, Packet

CODEC = "opus"
"""Codec of the sounds, as browsers name it (RFC 6716)."""
RATE_HZ = 48_000
"""Samples a second, of one channel."""
FRAME_S = 0.020
"""Length of a sound, s."""
SAMPLES = 960
"""Number of samples of a sound."""
BIT_S = 24_000
"""Bit rate while somebody talks, bit/s. It is constant, because sizes that vary give away what is said (RFC 6562)."""
MAX_SOUND = 120
"""Largest sound, bytes: twice that of BIT_S."""
ALIVE_S = 0.1
"""Longest time between two packets of an end, s."""


class VoiceState(IntEnum):
    """What one end does."""

    TALKS = 0
    MUTED = 1
    ABSENT = 2
    """There is no microphone, or nobody to talk."""


class VoicePacket(Packet, frozen=True):
    """One packet of an end; `time_ns` is when its sound begins, or when it was sent if it has none.

    Attributes:
        sequence: number of the sound, from 1; a packet without a sound repeats the number of the newest one.
        sent_ns: when it was sent, ns of the sender's clock.
        asked_ns: `sent_ns` of the newest packet that the sender has read; 0 before the first.
        heard_ns: when that packet was read, ns of the sender's clock.
        state: what the sender does.
        hears: whether the sender plays sounds to somebody.
        consents: whether the sender agrees that the sound of both is recorded.
        sound: one frame of the codec; empty without a sound.
    """

    sent_ns: Integer
    asked_ns: Integer
    heard_ns: Integer
    state: VoiceState
    hears: bool
    consents: bool
    sound: Annotated[bytes, Meta(max_length=MAX_SOUND)]
