"""Reads the camera's pictures of a recording in order of time, and after a jump from the last key picture on."""

from collections.abc import Iterator
from contextlib import suppress

from operator_site.console.camera.camera_picture import Picture, follows
from operator_site.console.playback.playback import CAMERA, Recording

_BACK_S = (2.0, 10.0, 60.0, 600.0)
"""Parts of the recording before a moment in which a key picture is searched, s; the first with one is taken."""


class PlayedPictures:
    """Pictures of a recording. Times are ns of the recording's clock; its pictures appear when they had arrived."""

    def __init__(self, recording: Recording) -> None:
        """Begin at the start."""
        self._recording = recording
        self._sequence: int | None = None
        self._messages: Iterator[tuple[int, Picture]] = iter(())
        self._next: tuple[int, Picture] | None = None
        self._enter(recording.start_ns)

    def play(self, now_ns: int) -> list[Picture]:
        """Return the pictures since the last call that can be decoded, oldest first."""
        found = []
        while self._next is not None and self._next[0] <= now_ns:
            picture = self._next[1]
            self._next = next(self._messages, None)
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
        self._messages = _pictures(self._recording, from_ns)
        self._next = next(self._messages, None)


def _pictures(recording: Recording, from_ns: int) -> Iterator[tuple[int, Picture]]:
    """Yield time and picture of each readable record."""
    for _, time_ns, payload in recording.messages(from_ns, (CAMERA,)):
        with suppress(ValueError):
            yield time_ns, Picture.of_record(payload)
