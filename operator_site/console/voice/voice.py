"""Follows the remote site's voice: one step reads what has arrived and keeps the connection alive."""

import time
from collections.abc import Callable
from dataclasses import dataclass

from common.link.voice_end import VoiceEnd
from common.wire.voice_messages import VoiceState
from operator_site.console.stream_socket import Reconnection, StreamSocket
from operator_site.console.voice.voice_now import Heard, VoiceNow
from operator_site.console.voice.voice_sound import VoiceSound

SILENT_S = 1.0
"""Longest silence of a voice's process that answers, s."""
_AT_ONCE = 64
"""Maximum number of packets of one step."""
_HEARD = {
    VoiceState.TALKS: Heard.LIVE,
    VoiceState.MUTED: Heard.MUTED,
    VoiceState.ABSENT: Heard.NO_MICROPHONE,
}


@dataclass(frozen=True, slots=True)
class Talk:
    """What the pages do now.

    Attributes:
        state: what the page in control does.
        talker: its name while it talks; else empty.
        hears: whether a page plays the remote site's sound.
    """

    state: VoiceState = VoiceState.ABSENT
    talker: str = ""
    hears: bool = False


class Voice:
    """The voice of the remote site as the console has it."""

    def __init__(
        self, line: StreamSocket, *, record: bool = False, clock_ns: Callable[[], int] = time.monotonic_ns
    ) -> None:
        """Read and write `line`.

        Args:
            record: whether this side records the sound where the remote site has the patient's consent.
        """
        self._line, self._clock_ns, self._record = line, clock_ns, record
        self._end = VoiceEnd(clock_ns())
        self._reconnection = Reconnection(line, clock_ns())
        self._session, self._talk = 0, Talk()
        self.clock = self._end.clock
        """Comparison with the clock of the voice's process."""

    def step(self, session: int, talk: Talk) -> list[VoiceSound]:
        """Return the arrived sounds, oldest first, and send the due packet."""
        self._session, self._talk = session, talk
        found = []
        for _ in range(_AT_ONCE):
            if not (parts := self._line.receive()):
                break
            if (sound := self._end.take(b"".join(parts), self._clock_ns())) is not None:
                captured_s, uncertainty_s = sound.captured_ns * 1e-9, sound.uncertainty_ns * 1e-9
                found.append(VoiceSound("from_remote", sound.sequence, captured_s, uncertainty_s, sound.content))
        now_ns = self._clock_ns()
        self._reconnection.step(now_ns, self._end.silent_s(now_ns))
        self._send(talk.state, None)
        return found

    def say(self, sound: VoiceSound) -> bool:
        """Send a sound of the page in control at once; return whether it was sent.

        A sound that is old, or for which the network has no room, is dropped.
        """
        held = self._end.counts["held"]
        self._send(VoiceState.TALKS, (round(sound.captured_s * 1e9), sound.content))
        return self._end.counts["held"] == held

    def _send(self, state: VoiceState, sound: tuple[int, bytes] | None) -> None:
        now_ns, hears = self._clock_ns(), self._talk.hears
        packed = self._end.pack(now_ns, state, sound, session=self._session, hears=hears, consents=self._record)
        if packed is not None:
            self._line.send(packed)

    @property
    def now(self) -> VoiceNow:
        """What is heard now."""
        far = self._end.far
        if self._line.refused:
            return VoiceNow(Heard.REFUSED)
        if far is None or self._end.silent_s(self._clock_ns()) > SILENT_S:
            return VoiceNow(Heard.SILENT)
        return VoiceNow(_HEARD[far.state], far.hears, self._record and far.consents, self._talk.talker)

    def figures(self) -> dict[str, object]:
        """Return the values for the status file."""
        uncertainty_ns = self.clock.own.uncertainty_ns
        return {
            "voice": str(self.now.heard),
            "voice_counts": dict(self._end.counts),
            "voice_clock_uncertainty_us": None if uncertainty_ns is None else uncertainty_ns // 1000,
        }

    def close(self) -> None:
        """Disconnect."""
        self._line.close()
