"""Reads the sounds of a recording in order of time."""

import math
from collections.abc import Iterator
from contextlib import suppress

from common.wire.voice_messages import FRAME_S
from operator_site.console.playback.playback import VOICE, Recording
from operator_site.console.voice.voice_sound import VoiceSound

_TURN_S = 2.5 * FRAME_S
"""Time after a sound of a page in which the remote site's sounds are left out, s: a page plays one talker at a time."""


class PlayedSounds:
    """Sounds of a recording. Times are ns of the recording's clock; its sounds appear when they were relayed."""

    def __init__(self, recording: Recording) -> None:
        """Begin at the start."""
        self._recording = recording
        self._messages: Iterator[tuple[int, VoiceSound]] = iter(())
        self._next: tuple[int, VoiceSound] | None = None
        self.jump(recording.start_ns)

    def jump(self, now_ns: int) -> None:
        """Read from a moment on."""
        self._said_s = -math.inf
        self._messages = _sounds(self._recording, now_ns)
        self._next = next(self._messages, None)

    def play(self, now_ns: int) -> list[VoiceSound]:
        """Return the sounds since the last call, oldest first."""
        found = []
        while self._next is not None and self._next[0] <= now_ns:
            sound = self._next[1]
            self._next = next(self._messages, None)
            if sound.direction == "to_remote":
                self._said_s = sound.captured_s
            if sound.direction == "to_remote" or sound.captured_s - self._said_s > _TURN_S:
                found.append(sound)
        return found


def _sounds(recording: Recording, from_ns: int) -> Iterator[tuple[int, VoiceSound]]:
    """Yield time and sound of each readable record."""
    for _, time_ns, payload in recording.messages(from_ns, (VOICE,)):
        with suppress(ValueError):
            yield time_ns, VoiceSound.of_record(payload)
