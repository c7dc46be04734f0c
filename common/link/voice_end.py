"""One end of the voice: dates what arrives, drops what is old, and packs what is sent."""

from collections import Counter
from typing import NamedTuple

from common.limits import VOICE_AGE_S
from common.link.stream_clock import StreamClock
from common.wire.voice_messages import ALIVE_S, VoicePacket, VoiceState

FORGET_S = 1.0
"""Silence after which sounds may begin again with an earlier time, s: the far end's host has started again."""
IN_FLIGHT_S = 0.25
"""Largest time beyond the shortest round trip for which the far end may acknowledge nothing, s. After it no sound is
sent, because it would wait in the network behind others."""


class Sound(NamedTuple):
    """One sound that has arrived.

    Attributes:
        sequence: its number.
        captured_ns: when it begins, ns of this machine's clock.
        uncertainty_ns: bound of the error of `captured_ns` from the comparison of the clocks, ns.
        content: one frame of the codec.
    """

    sequence: int
    captured_ns: int
    uncertainty_ns: int
    content: bytes


class VoiceEnd:
    """This end towards one far end. Pure: time is an argument, ns of this machine's monotonic clock.

    Attributes:
        far: newest packet of the far end; None before the first.
        heard_ns: when it was read.
        clock: comparison with the far end's clock.
        counts: numbers of damaged packets, sounds dropped as old, sent, and not sent for want of an acknowledgement.
    """

    def __init__(self, now_ns: int) -> None:
        self.far: VoicePacket | None = None
        self.heard_ns = now_ns
        self.clock = StreamClock()
        self.counts: Counter[str] = Counter()
        self._newest_ns = -1
        """Time of the newest sound, on the far clock."""
        self._sequence = 0
        self._sent_ns = 0
        self._acknowledged_ns = now_ns

    def take(self, packed: bytes, now_ns: int) -> Sound | None:
        """Take one packet; return its sound unless it is a repeated one, too old, or its time is not known yet."""
        try:
            packet = VoicePacket.decode(packed)
            # A time to come is of this host's run before; the far end has heard nothing of this one.
            asked_ns = packet.asked_ns if packet.asked_ns <= now_ns else 0
            self.clock.compare(asked_ns, packet.heard_ns, packet.sent_ns, now_ns, now_ns)
        except ValueError:  # BadPacket, and times that cannot be
            self.counts["damaged"] += 1
            return None
        if (now_ns - self.heard_ns) * 1e-9 > FORGET_S:
            self._newest_ns = -1
        self.far, self.heard_ns = packet, now_ns
        self._acknowledged_ns = max(self._acknowledged_ns, asked_ns)
        if not packet.sound or packet.time_ns <= self._newest_ns or (dating := self.clock.dating) is None:
            return None
        self._newest_ns = packet.time_ns
        offset_ns, uncertainty_ns = dating
        sound = Sound(packet.sequence, packet.time_ns - offset_ns, uncertainty_ns, packet.sound)
        if is_old(sound.captured_ns, now_ns):
            self.counts["old"] += 1
            return None
        return sound

    def silent_s(self, now_ns: int) -> float:
        """Return the time since the newest packet, s; before the first, since the start."""
        return (now_ns - self.heard_ns) * 1e-9

    def pack(
        self,
        now_ns: int,
        state: VoiceState,
        sound: tuple[int, bytes] | None = None,
        *,
        session: int = 0,
        hears: bool,
        consents: bool,
    ) -> bytes | None:
        """Return the packet to send now, or None; one without a sound is due after ALIVE_S.

        Args:
            now_ns: time, ns.
            state: what this end does.
            sound: when it begins, ns of this machine's clock, and a frame of the codec; None for none.
            session: number of the operator's session; 0 without one.
            hears: whether this end plays sounds to somebody.
            consents: whether this end agrees that the sound is recorded.
        """
        captured_ns, content = (now_ns, b"") if sound is None else sound
        if content and (is_old(captured_ns, now_ns) or not self._has_credit(now_ns)):
            self.counts["held"] += 1
            captured_ns, content = now_ns, b""
        if not content and self._sent_ns and now_ns - self._sent_ns < ALIVE_S * 1e9:
            return None
        if content:
            self._sequence += 1
            self.counts["sent"] += 1
        self._sent_ns = now_ns
        heard_ns, asked_ns = (0, 0) if self.far is None else (self.heard_ns, self.far.sent_ns)
        return VoicePacket(
            session, self._sequence, captured_ns, now_ns, asked_ns, heard_ns, state, hears, consents, content
        ).encode()

    def _has_credit(self, now_ns: int) -> bool:
        usual_ns = 2 * (self.clock.own.uncertainty_ns or 0)  # the shortest round trip
        return now_ns - self._acknowledged_ns < usual_ns + (ALIVE_S + IN_FLIGHT_S) * 1e9


def is_old(captured_ns: int, now_ns: int) -> bool:
    """Return whether a sound is too old to be played."""
    return (now_ns - captured_ns) * 1e-9 > VOICE_AGE_S
