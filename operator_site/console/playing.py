"""A recording under the hands of a page: play, pause, jump; what the page shows of it."""

import time
from datetime import datetime
from pathlib import Path
from typing import Any

from operator_site.console.console import Console
from operator_site.console.playback import Playback, Recording


class Player:
    """Plays by the wall clock."""

    def __init__(self, playback: Playback[Console], recording: Recording, path: Path):
        """At the start, paused."""
        self._playback, self._recording = playback, recording
        self._marks = [mark._asdict() for mark in recording.marks()]
        self._recorded = datetime.fromtimestamp(path.stat().st_mtime - recording.length_s)
        self._jumped = False

    @property
    def console(self) -> Console:
        """As it was at this moment of the recording."""
        return self._playback.console

    @property
    def now_s(self) -> float:
        """This moment, on the clock it was recorded by."""
        return self._playback.now_ns * 1e-9

    @property
    def title(self) -> str:
        """When it was made, as its file says."""
        return f"{self._recorded.day} {self._recorded:%b %Y %H:%M}"

    @property
    def wall_clock(self) -> str:
        """What a clock on the wall showed then."""
        return f"{datetime.fromtimestamp(self._recorded.timestamp() + self._playback.at_s):%H:%M:%S}"

    def step(self, wall_s: float) -> bool:
        """Play on; whether time has jumped since the last call."""
        self._playback.step(wall_s)
        if not self._playback.playing:
            self._playback.prepare()
        jumped, self._jumped = self._jumped, False
        return jumped

    def play(self, speed: float) -> None:
        """Go on, so many times as fast as it was; at the end, from the start."""
        before = self._playback.at_s
        self._playback.play(time.monotonic(), speed)
        self._jumped = self._jumped or self._playback.at_s < before

    def pause(self) -> None:
        """Stand still."""
        self._playback.pause(time.monotonic())

    def seek(self, at_s: float) -> None:
        """Go to a time of the recording, s from its beginning."""
        self._playback.seek(at_s, time.monotonic())
        self._jumped = True

    def shown(self) -> dict[str, Any]:
        """For the page."""
        playback = self._playback
        return {
            "at_s": round(playback.at_s, 3),
            "length_s": round(self._recording.length_s, 3),
            "speed": playback.speed,
            "playing": playback.playing,
            "prepared": round(playback.prepared, 3),
            "marks": self._marks,
        }
