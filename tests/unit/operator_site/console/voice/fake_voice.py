"""The voice's process with real Curve, which says what a test says."""

import time

from common.link.voice_end import Sound, VoiceEnd
from common.wire.voice_messages import VoiceState
from tests.conftest import Keys
from tests.unit.operator_site.console.fake_process import FakeProcess, until

__all__ = ["FakeVoice", "until"]

FRAME_S = 0.020


class FakeVoice(FakeProcess):
    """Binds the port of the stream `voice`, and serves one reader.

    Attributes:
        state, hears, consents: what it says of itself.
        sounds: what the reader has said.
        end: this end towards the reader; None before its first packet.
    """

    def __init__(self, base_port: int, keys: Keys) -> None:
        super().__init__("voice", base_port, keys)
        self.state, self.hears, self.consents = VoiceState.TALKS, True, False
        self.sounds: list[Sound] = []
        self.ages_s: list[float] = []
        """Age of each of these sounds when it arrived."""
        self.end: VoiceEnd | None = None

    def turn(self) -> None:
        """Read the waiting packets, and answer where that is due."""
        while self._socket.poll(0):
            who, packed = self._socket.recv_multipart()
            now_ns = time.monotonic_ns()
            if who != self._who or self.end is None:
                self._who, self.end = who, VoiceEnd(now_ns)
            if (sound := self.end.take(packed, now_ns)) is not None:
                self.sounds.append(sound)
                self.ages_s.append((now_ns - sound.captured_ns) * 1e-9)
        self._send(None)

    def say(self, content: bytes, old_s: float = FRAME_S) -> None:
        """Send a sound that began `old_s` ago."""
        self._send((time.monotonic_ns() - round(old_s * 1e9), content))

    def _send(self, sound: tuple[int, bytes] | None) -> None:
        if self.end is not None:
            now_ns = time.monotonic_ns()
            packed = self.end.pack(now_ns, self.state, sound, hears=self.hears, consents=self.consents)
            if packed is not None:
                self.send_raw(packed)
