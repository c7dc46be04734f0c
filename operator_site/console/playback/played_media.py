"""Reads the camera's pictures and the sounds of a recording in order of time.

Times are ns of the recording's clock. Pictures appear when they had arrived, sounds when they were relayed.
"""

import math
from collections.abc import Callable, Iterator
from contextlib import suppress
from typing import Generic, TypeVar

from common.wire.voice_messages import FRAME_S
from operator_site.console.camera.camera_picture import Picture, follows
from operator_site.console.playback.playback import CAMERA, VOICE, Recording
from operator_site.console.voice.voice_sound import VoiceSound

_BACK_S = (2.0, 10.0, 60.0, 600.0)
"""Parts of the recording before a moment in which a key picture is searched, s; the first with one is taken."""
_TURN_S = 2.5 * FRAME_S
"""Time after a sound of a page in which the remote site's sounds are left out, s: a page plays one talker at a time."""
Medium = TypeVar("Medium")


class _Records(Generic[Medium]):
    """Readable records of one stream, from a moment on."""

    def __init__(self, recording: Recording, stream: str, read: Callable[[bytes], Medium], from_ns: int) -> None:
        self._messages = recording.messages(from_ns, (stream,))
        self._read = read
        self._next = self._following()

    def until(self, now_ns: int) -> Iterator[Medium]:
        """Yield what was recorded since the last call, oldest first."""
        while self._next is not None and self._next[0] <= now_ns:
            found, self._next = self._next[1], self._following()
            yield found

    def _following(self) -> tuple[int, Medium] | None:
        for _, time_ns, payload in self._messages:
            with suppress(ValueError):
                return time_ns, self._read(payload)
        return None


class PlayedPictures:
    """Pictures of a recording; after a jump they begin with the last key picture."""

    def __init__(self, recording: Recording) -> None:
        """Begin at the start."""
        self._recording = recording
        self._sequence: int | None = None
        self._enter(recording.start_ns)

    def play(self, now_ns: int) -> list[Picture]:
        """Return the pictures since the last call that can be decoded, oldest first."""
        found = []
        for picture in self._records.until(now_ns):
            can = follows(picture, self._sequence)
            self._sequence = picture.sequence if can else None
            if can:
                found.append(picture)
        return found

    def jump(self, now_ns: int) -> list[Picture]:
        """Return the last key picture up to a moment and all that follow it until then; none without one."""
        found: list[Picture] = []
        for back_s in _BACK_S:
            self._enter(max(self._recording.start_ns, now_ns - round(back_s * 1e9)))
            found = self.play(now_ns)
            if found:
                break
        last = max((at for at, picture in enumerate(found) if picture.is_key), default=0)
        return found[last:]

    def _enter(self, from_ns: int) -> None:
        self._sequence = None
        self._records = _Records(self._recording, CAMERA, Picture.of_record, from_ns)


class PlayedSounds:
    """Sounds of a recording."""

    def __init__(self, recording: Recording) -> None:
        """Begin at the start."""
        self._recording = recording
        self.jump(recording.start_ns)

    def jump(self, now_ns: int) -> None:
        """Read from a moment on."""
        self._said_s = -math.inf
        self._records = _Records(self._recording, VOICE, VoiceSound.of_record, now_ns)

    def play(self, now_ns: int) -> list[VoiceSound]:
        """Return the sounds since the last call, oldest first."""
        found = []
        for sound in self._records.until(now_ns):
            if sound.direction == "to_remote":
                self._said_s = sound.captured_s
            if sound.direction == "to_remote" or sound.captured_s - self._said_s > _TURN_S:
                found.append(sound)
        return found
