"""Plays a recording for a page: play, pause, jump and the playback state."""

import time
from collections.abc import Callable
from contextlib import ExitStack, suppress
from dataclasses import asdict
from datetime import datetime, timedelta
from pathlib import Path
from typing import Any

from common.files.constants import within
from common.link.session_state import Refused
from common.timing.interval import Interval
from operator_site.console import texts
from operator_site.console.background_search import MapSearches
from operator_site.console.camera.camera_now import CameraNow, Seen
from operator_site.console.camera.picture_reader import KEY_S
from operator_site.console.examination.journal import Journal
from operator_site.console.live import STATE_S
from operator_site.console.model import Console
from operator_site.console.playback.checkpoints import Checkpoints
from operator_site.console.playback.playback import CAMERA, VOICE, Playback, Recording
from operator_site.console.playback.played_media import PlayedPictures, PlayedSounds
from operator_site.console.voice.voice_now import Heard, VoiceNow
from operator_site.console.web.answer import Act, Answer
from operator_site.console.web.camera_pages import CameraPages
from operator_site.console.web.clients import Client
from operator_site.console.web.commands import Commands
from operator_site.console.web.page_state import camera_state, page_state
from operator_site.console.web.pages import Pages
from operator_site.console.web.voice_pages import VoicePages
from operator_site.session.console_feed import BATCH_S

_LARGEST = 1e9
"""Largest speed and largest time of a request, s."""
AT_ONCE = 300
"""Messages that one step takes to complete a preview; about 0.05 s."""


class Player:
    """Plays a recording by the wall clock.

    Attributes:
        playback: the playback, with the console at the present moment of the recording.
    """

    def __init__(self, recording: Recording, ahead: Checkpoints, clock_s: Callable[[], float] = time.monotonic):
        """Begin at the start, paused.

        Args:
            recording: recording to play.
            ahead: checkpoints of the same recording.
            clock_s: this machine's monotonic clock, s.
        """
        self.playback = Playback(recording, lambda: Console(live=False))
        self._ahead, self._clock_s = ahead, clock_s
        self._target_s: float | None = None
        """Target of a pending jump, s from the beginning."""
        self._start = _start(recording)
        self._marks = [mark._asdict() for mark in self.playback.marks]
        self._jumps = self.playback.jumps

    def step(self, wall_s: float) -> bool:
        """Advance the playback; return whether its time has jumped since the last call."""
        playback = self.playback
        playback.checkpoints += self._ahead.made()
        if self._target_s is None:
            playback.step(wall_s)
            if playback.partial and playback.ready(playback.at_s):
                playback.complete(AT_ONCE)
        else:
            exact = playback.dense and playback.ready(self._target_s)
            (playback.seek if exact else playback.preview)(self._target_s, wall_s)
            self._target_s = None
        before, self._jumps = self._jumps, playback.jumps
        return self._jumps != before

    def play(self, speed: float) -> None:
        """Play at a multiple of the recorded speed within SPEEDS; at the end, restart from the beginning."""
        self.playback.play(self._clock_s(), speed)

    def pause(self) -> None:
        """Pause the playback."""
        self.playback.pause(self._clock_s())

    def seek(self, at_s: float) -> bool:
        """Jump to a time, s from the beginning, at the next step; return False if only a preview is ready.

        The newest request replaces earlier ones, such as those of a dragged slider.
        """
        self._target_s = at_s
        return self.playback.ready(at_s)

    @property
    def verbs(self) -> dict[str, Act]:
        """What carries out the requests of a page."""
        return {"play": self._asked_to_play, "pause": self._asked_to_pause, "seek": self._asked_to_seek}

    async def _asked_to_play(self, client: Client, details: dict[str, Any], now_s: float) -> Answer:
        speed = details.get("speed", 1.0)
        if not within(speed, -_LARGEST, _LARGEST):
            raise Refused(texts.SPEED_NEEDED)
        self.play(float(speed))
        return Answer(True, "")

    async def _asked_to_pause(self, client: Client, details: dict[str, Any], now_s: float) -> Answer:
        self.pause()
        return Answer(True, texts.PLAYBACK_PAUSED)

    async def _asked_to_seek(self, client: Client, details: dict[str, Any], now_s: float) -> Answer:
        at_s = details.get("at_s")
        if not within(at_s, -_LARGEST, _LARGEST):
            raise Refused(texts.TIME_NEEDED)
        return Answer(True, "" if self.seek(max(0.0, float(at_s))) else texts.READING_AHEAD)

    def state(self) -> dict[str, Any]:
        """Return the state for the page."""
        playback, start = self.playback, self._start
        state = page_state(playback.console, playback.now_s, lambda _: True, "", playback.now_s - playback.at_s)
        state["session"] |= {
            "title": playback.title if start is None else f"{start.day} {start:%b %Y %H:%M}",
            "playback": {
                "at_s": round(playback.at_s, 3),
                "length_s": round(playback.length_s, 3),
                "speed": playback.speed,
                "playing": playback.playing,
                "partial": playback.partial,
                "marks": self._marks,
            },
        }
        state["wall_clock"] = "" if start is None else f"{start + timedelta(seconds=playback.at_s):%H:%M:%S}"
        return state


class PlayedConsole:
    """Shows a recording."""

    def __init__(self, path: Path, opened: ExitStack):
        """Open the recording.

        Raises:
            ValueError, OSError: the recording cannot be read, or has nothing that a console shows.
        """
        recording = Recording(path)
        opened.callback(recording.close)
        self._player = Player(recording, Checkpoints(path, opened))
        self._recorded = PlayedPictures(recording) if recording.has(CAMERA) else None
        self._sounds = PlayedSounds(recording) if recording.has(VOICE) else None
        self._commands = Commands(self._player.playback.console, Journal(None, {}), playing=self._player.verbs)
        self.pages = Pages(self._commands, lambda: self._player.playback.now_s)
        self.camera_pages = CameraPages(self.pages.contain)
        self.voice_pages = VoicePages(self.pages.contain, lambda: None)
        self._picture, self._state, self._again = Interval(BATCH_S), Interval(STATE_S), Interval(KEY_S)
        self._searches = MapSearches(self.pages.contain)

    def step(self, now_s: float) -> None:
        """Advance the playback and show what is due."""
        if not self._picture(now_s):
            return
        jumped = self._player.step(now_s)
        console = self._player.playback.console
        if self._recorded is not None:
            with self.pages.contain.step("camera", latches=False):
                self._see(self._recorded, now_s, jumped=jumped)
        if self._sounds is not None:
            with self.pages.contain.step("voice", latches=False):
                self._listen(self._sounds, jumped=jumped)
        if jumped:
            # Another map for the pages, which drop the tiles that the map does not have yet.
            console.map_number = self._commands.console.map_number + 1
            self._commands.console = console
            self.pages.send_everything()
        self._searches.step(now_s, console)
        due = self._state(now_s)
        self.pages.show(self._shown() if due or jumped else None)

    def _shown(self) -> dict[str, Any]:
        state = self._player.state()
        if self._recorded is not None:
            state["camera"] = camera_state(CameraNow(Seen.LIVE, 0.0))
        if self._sounds is not None:
            state["voice"] = asdict(VoiceNow(Heard.LIVE, recorded=True))
        return state

    def _see(self, recorded: PlayedPictures, now_s: float, *, jumped: bool) -> None:
        """Relay the pictures up to the present moment; after a jump, from the last key picture before it."""
        now_ns = self._player.playback.now_ns
        self.camera_pages.step()
        if jumped:
            self.camera_pages.restart(recorded.jump(now_ns))
            return
        for picture in recorded.play(now_ns):
            self.camera_pages.show(picture)
        if self.camera_pages.wants_key and self._again(now_s):
            self.camera_pages.restart(recorded.jump(now_ns), waiting=True)

    def _listen(self, recorded: PlayedSounds, *, jumped: bool) -> None:
        """Relay the sounds up to the present moment; at another speed than the recorded one there are none."""
        now_ns = self._player.playback.now_ns
        if jumped:
            recorded.jump(now_ns)
        for sound in recorded.play(now_ns):
            if self._player.playback.speed == 1.0:
                self.voice_pages.show(sound)

    def figures(self) -> dict[str, object]:
        """Return the values for the status file."""
        return {"clients": len(self.pages.clients)}


def _start(recording: Recording) -> datetime | None:
    """Return the wall-clock time of a recording's start, from an examination in it; None if it has none."""
    for time_ns, entry in recording.examinations():
        if entry.get("wall_clock"):
            since_start = timedelta(microseconds=(time_ns - recording.start_ns) // 1000)
            with suppress(ValueError, OverflowError):  # not a valid wall-clock time
                return datetime.fromisoformat(entry["wall_clock"]) - since_start
    return None
