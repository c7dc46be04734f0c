"""Connects a running site with the pages: reads its feed, sends requests, and records what users do."""

import asyncio
import contextlib
import logging
import math
import shutil
import time
from collections.abc import Callable
from concurrent.futures import Future
from dataclasses import replace
from datetime import datetime
from pathlib import Path
from typing import Any

from common.config.page_models import ConsoleConfig
from common.timing.interval import Interval
from operator_site.console import texts
from operator_site.console.background_search import MapSearches
from operator_site.console.camera.camera import Camera
from operator_site.console.examination.journal import Journal
from operator_site.console.examination.reporting import Reporting
from operator_site.console.examination.resume import Unfinished
from operator_site.console.map.finger_samples import samples_of
from operator_site.console.model import Console
from operator_site.console.state.site_now import SILENT_S
from operator_site.console.state.site_time import SiteTime, WallClock
from operator_site.console.voice.voice import Voice
from operator_site.console.voice.voice_sound import VoiceSound
from operator_site.console.web.camera_pages import CameraPages
from operator_site.console.web.commands import Commands, SiteControl
from operator_site.console.web.page_state import page_state
from operator_site.console.web.pages import Pages
from operator_site.console.web.voice_pages import VoicePages
from operator_site.session.console_feed import BATCH_S, FeedSource

log = logging.getLogger(__name__)

STATE_S = 0.1
"""Interval between two states for the pages, s."""
_ATTEND_S = 0.1
"""Interval between two presence messages to the site's local control, which answers with its status, s."""
_STOPPING_S = 0.05
"""The same interval while the site stops, s."""
_KEEP_S = 0.2
"""Interval between two steps of the journal, s."""
_SLOW_PER_S = 10
"""Most skipped pictures in a second; a page that skips more is slow."""


class LiveConsole:
    """Shows a running site."""

    def __init__(
        self,
        config: ConsoleConfig,
        feed: FeedSource,
        site: SiteControl,
        journal: Journal,
        clock_s: Callable[[], float] = time.monotonic,
        camera: Camera | None = None,
        voice: Voice | None = None,
    ):
        """Show the site that feeds `feed`.

        Args:
            config: configuration of the console.
            feed: source of the site's messages.
            site: the site's local control.
            journal: records actions and findings; an unfinished examination in it is continued.
            clock_s: this machine's monotonic clock, s.
            camera: the remote site's camera; None without one.
            voice: the voice of the remote site; None without one.
        """
        self._feed, self._site, self._journal, self._clock_s = feed, site, journal, clock_s
        self.console = Console()
        if config.consent is not None:
            self.console.noted = tuple(name for name, agreed in config.consent if agreed)
        self._time = SiteTime()
        self._wall = WallClock()
        reporting = Reporting(config.report_command, config.reports)
        self._commands = Commands(self.console, journal, site, reporting=reporting)
        self.pages = Pages(self._commands, self._site_s, clock_s)
        self.camera_pages = CameraPages(self.pages.contain, clock_s)
        self._camera, self._seen_s = camera, -math.inf
        self._voice = voice
        self.voice_pages = VoicePages(self.pages.contain, lambda: self.pages.control.holder, self._say, clock_s)
        self._records_pictures = config.camera is not None and config.camera.record
        self._resume(self._journal.unfinished)
        self._operator = "operator.toml" if config.operator is None else str(config.operator)
        self._folder = config.record.parent if config.record is not None else Path.cwd()
        self._picture, self._state, self._attend = Interval(BATCH_S), Interval(STATE_S), Interval(_ATTEND_S)
        self._keep, self._second = Interval(_KEEP_S), Interval(1.0)
        self._searches = MapSearches(self.pages.contain)
        self._skipped = 0
        self._answering = False

    def step(self, here_s: float) -> None:
        """Take the received messages and show what is due; `here_s` is the time on the machine's clock, s."""
        fed = list(self._feed.receive())
        for stream, time_ns, payload in fed:
            self._time.heard(here_s, time_ns * 1e-9)
            self.console.take(stream, time_ns, payload)
        now_s = self._time.now_s(here_s)
        if self._camera is not None:
            with self.pages.contain.step("camera", latches=False):
                self._see(self._camera, now_s)
        if self._voice is not None:
            with self.pages.contain.step("voice", latches=False):
                self._listen(self._voice)
        stopping = self.console.site.stop_asked_s is not None and None in self.console.site.stop_after_s.values()
        if not self._answering and self._attend(here_s, _STOPPING_S if stopping else None):
            self._report_presence()
        if self._second(here_s):
            self._look_around()
            self._keep_samples(now_s)
            self._searches.step(here_s, self.console)
        if self._keep(here_s):
            self._journal.step(now_s)
            for alarm in self.console.alarms.take_changes():
                record = {"id": alarm.ident, "priority": alarm.cause.priority.name.lower(), "text": alarm.text}
                times = {"since_s": alarm.since_s, "ended_s": alarm.ended_s, "cleared_by": alarm.cleared_by}
                self._journal.write("console/alarm", now_s, {**record, **times, "active": alarm.ended_s is None})
        if self._picture(here_s, 0.5 * BATCH_S if fed else 1.5 * BATCH_S):
            self.console.step(now_s)
            self._commands.step(now_s)
            self.pages.show(self._shown(now_s) if self._state(here_s) else None)

    def _see(self, camera: Camera, now_s: float) -> None:
        """Relay and record the arrived pictures; pause the session where a required picture is not live."""
        site = self.console.site
        touch_age_s = max(site.link.largest_age_s(self._seen_s), site.gap_s or 0.0)
        self._seen_s = now_s
        camera.clock.site = self._site_clock
        for taken in camera.step(site.session, touch_age_s, wants_key=self.camera_pages.wants_key):
            picture = replace(taken, captured_s=taken.captured_s + self._time.ahead_s)
            self.camera_pages.show(picture)
            if self._records_pictures and self.console.consent.allows("picture"):
                self._journal.write_media("console/camera", now_s, picture.record())
        self.camera_pages.step()
        now = camera.now
        self.console.around = replace(self.console.around, camera=now)
        if now.holds:
            self._commands.pause(now_s, texts.camera(now.seen, now.age_s, pauses=True))

    def _listen(self, voice: Voice) -> None:
        """Relay and record the arrived sounds, and show what is heard at both ends."""
        voice.clock.site = self._site_clock
        for sound in voice.step(self.console.site.session, self.voice_pages.talk):
            self._relay(voice, sound)
        self.console.around = replace(self.console.around, voice=voice.now)

    def _say(self, sound: VoiceSound) -> None:
        """Send a sound of the page in control to the remote site, and record it."""
        if self._voice is not None and self._voice.say(sound):
            self._relay(self._voice, sound)

    def _relay(self, voice: Voice, taken: VoiceSound) -> None:
        """Give a sound of the remote site to the pages, and record one of either side where both sides agree."""
        sound = replace(taken, captured_s=taken.captured_s + self._time.ahead_s)
        if sound.direction == "from_remote":
            self.voice_pages.show(sound)
        if voice.now.recorded:
            self._journal.write_media("console/voice", self._site_s(), sound.record())

    @property
    def _site_clock(self) -> tuple[int, int] | None:
        """Offset of the remote site's clock from this machine's and its uncertainty, ns; None while it is unknown."""
        if self.console.site.link.clock is None:
            return None
        offset_ns, uncertainty_ns = self.console.site.link.clock
        return offset_ns + round(self._time.ahead_s * 1e9), uncertainty_ns

    def _resume(self, before: Unfinished) -> None:
        """Continue the unfinished examination of an earlier run, or show that this is not possible."""
        self._resumed_s: float | None = None
        if before.cut_off:
            text = texts.cut_off(before.cut_off, len(before.findings), [path.name for path in before.files])
            self._commands.examining.saved = {"text": text, "report": None}
            return
        for stream, record in before.records:
            try:
                if stream == "console/felt":
                    for sample in samples_of(record):
                        self.console.tactile_map.restore(sample)
                else:
                    self.console.examination.take(stream, record)
            except (KeyError, TypeError, ValueError, IndexError) as error:
                log.warning("%s of an earlier run: %r", stream, error)
        self._resumed_s = self.console.examination.began_s

    def _keep_samples(self, now_s: float) -> None:
        """Record the new samples of an examination, so that a later run of the console can show them."""
        if self.console.examination.pseudonym is None or not self._journal.enabled:
            return
        if self.console.consent.forbids("touch"):
            return
        if samples := self.console.tactile_map.unkept():
            self._journal.write("console/felt", now_s, {"samples": [tuple(sample) for sample in samples]})

    def _site_s(self) -> float:
        """Return the time on the site's clock, s."""
        return self._time.now_s(self._clock_s())

    def figures(self) -> dict[str, object]:
        """Return the values for the status file."""
        silent_s = self.console.site.silent_s(self._site_s())
        since = f"for {silent_s:.1f} s" if math.isfinite(silent_s) else "yet"
        return {
            "stale": f"no message from the operator site {since}" if silent_s > SILENT_S else "",
            "clients": len(self.pages.clients),
            "pictures_skipped": sum(client.skipped for client in self.pages.clients),
            "damaged": self.console.damaged,
            "unsaved": self._journal.unsaved,
            **({} if self._camera is None else self._camera.figures()),
            **({} if self._voice is None else self._voice.figures()),
        }

    def _shown(self, now_s: float) -> dict[str, Any]:
        here = datetime.now()
        self._wall.take(now_s, here)
        state = page_state(self.console, now_s, self._journal.is_saved, self._operator, wall_clock=self._wall.at)
        state["session"]["saved"] = self._commands.examining.saved
        return {**state, "wall_clock": f"{here:%H:%M:%S}"}

    def _report_presence(self) -> None:
        """Report to the site whether a user can see the page in control; the answer holds the site's status.

        There is one request at a time.
        """
        self._answering = True
        loop = asyncio.get_running_loop()
        asked = self._site.ask("attend", {"seen": self.pages.seen})

        def done(answer: "Future[dict[str, Any]]") -> None:
            with contextlib.suppress(RuntimeError):  # the loop has ended meanwhile
                loop.call_soon_threadsafe(self._take_answer, answer)

        asked.add_done_callback(done)

    def _take_answer(self, answer: "Future[dict[str, Any]]") -> None:
        self._answering = False
        if not answer.cancelled() and answer.exception() is None:
            self.console.take_answer(self._site_s(), answer.result())

    def _look_around(self) -> None:
        holder = self.pages.control.holder
        skipped = 0 if holder is None else holder.skipped
        slow, self._skipped = skipped - self._skipped > _SLOW_PER_S, skipped
        try:
            disk = shutil.disk_usage(self._folder)
            used = disk.used / max(1, disk.used + disk.free)
        except OSError:
            used = 0.0
        failed = self._journal.enabled and self._journal.failed
        examination = self.console.examination
        resumed = examination.pseudonym is not None and examination.began_s == self._resumed_s
        self.console.around = replace(
            self.console.around, disk_used=used, recording_failed=failed, page_slow=slow, resumed=resumed
        )
