"""A recording under the hands of a page: play, pause, jump; what the page shows of it."""

import time
from contextlib import ExitStack, suppress
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any

from operator_site.console.examination.journal import Journal
from operator_site.console.interval import Interval
from operator_site.console.live import STATE_S
from operator_site.console.model import Console
from operator_site.console.playback.checkpoints import Checkpoints
from operator_site.console.playback.playback import Playback, Recording
from operator_site.console.web.commands import Commands
from operator_site.console.web.control import Control
from operator_site.console.web.page_state import shown_state
from operator_site.console.web.pages import Pages
from operator_site.session.console_feed import BATCH_S


class Player:
    """Plays by the wall clock."""

    def __init__(self, recording: Recording, ahead: Checkpoints):
        """At the start, paused.

        Args:
            recording: what is played.
            ahead: reads the same.
        """
        self._playback = Playback(recording, lambda: Console(live=False))
        self._ahead = ahead
        self._target_s: float | None = None
        """Where to jump, as soon as that is read."""
        self._start = _start(recording)
        self._marks = [mark._asdict() for mark in self._playback.marks]
        self._jumps = self._playback.jumps

    @property
    def console(self) -> Console:
        """As it was at this moment of the recording."""
        return self._playback.console

    @property
    def now_s(self) -> float:
        """This moment, on the clock it was recorded by."""
        return self._playback.time_s

    @property
    def start_s(self) -> float:
        """Its beginning, on the same clock."""
        return self._playback.time_s - self._playback.at_s

    @property
    def title(self) -> str:
        """When it was made, as far as that is recorded; else the name of its file."""
        start = self._start
        return self._playback.title if start is None else f"{start.day} {start:%b %Y %H:%M}"

    @property
    def wall_clock(self) -> str:
        """What a clock on the wall showed then; empty where that is not known."""
        return "" if self._start is None else f"{self._start + timedelta(seconds=self._playback.at_s):%H:%M:%S}"

    def step(self, wall_s: float) -> bool:
        """Play on; whether time has jumped since the last call."""
        self._playback.checkpoints += self._ahead.made()
        if self._target_s is None:
            self._playback.step(wall_s)
        elif self._playback.ready(self._target_s):
            self._playback.seek(self._target_s, wall_s)
            self._target_s = None
        jumped = self._playback.jumps != self._jumps
        self._jumps = self._playback.jumps
        return jumped

    def play(self, speed: float) -> None:
        """Go on, so many times as fast as it was; at the end, from the start."""
        self._playback.play(time.monotonic(), speed)

    def pause(self) -> None:
        """Stand still."""
        self._playback.pause(time.monotonic())

    def seek(self, at_s: float) -> bool:
        """Go to a time of the recording, s from its beginning, with the next step; False where it must be read first.

        A slider that is dragged asks for many: the newest counts.
        """
        self._target_s = at_s
        return self._playback.ready(at_s)

    def shown(self) -> dict[str, Any]:
        """For the page."""
        playback = self._playback
        return {
            "at_s": round(playback.at_s, 3),
            "length_s": round(playback.length_s, 3),
            "speed": playback.speed,
            "playing": playback.playing,
            "marks": self._marks,
        }


class PlayedConsole:
    """Shows a recording."""

    def __init__(self, path: Path, opened: ExitStack):
        """Open it.

        Raises:
            ValueError, OSError: it cannot be read, or has nothing that a console shows.
        """
        recording = Recording(path)
        opened.callback(recording.close)
        self._player = Player(recording, Checkpoints(path, opened))
        control = Control()
        keeping = Journal(None, {})
        acts = Commands(self._player.console, None, keeping, control, self._player)
        self.pages = Pages(lambda: self._player.console, acts, control, lambda: self._player.now_s)
        self._acts = acts
        self._picture, self._state = Interval(BATCH_S), Interval(STATE_S)

    def step(self, now_s: float) -> None:
        """Play on, show what is due."""
        if not self._picture(now_s):
            return
        if self._player.step(now_s):
            self._acts.show(self._player.console)
            self.pages.begin_anew()
        console = self._player.console
        state = None
        if self._state(now_s):
            state = shown_state(console, self._player.now_s, lambda _: True, "", self._player.start_s)
        if state is not None:
            state["session"] |= {"playback": self._player.shown(), "title": self._player.title}
            state["wall_clock"] = self._player.wall_clock
        self.pages.show(state)

    def figures(self) -> dict[str, object]:
        """What the status file tells."""
        return {"clients": len(self.pages.clients)}


def _start(recording: Recording) -> datetime | None:
    """When it began, by the clock on the wall of an examination in it; None where there is none."""
    for time_ns, entry in recording.examinations():
        if entry.get("wall_clock"):
            since_start = timedelta(microseconds=(time_ns - recording.start_ns) // 1000)
            with suppress(ValueError, OverflowError):  # it is no time of a clock on the wall
                return datetime.fromisoformat(entry["wall_clock"]) - since_start
    return None
