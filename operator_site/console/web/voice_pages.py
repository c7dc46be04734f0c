"""Relays the voice: the remote site's sounds to all pages, and those of the page in control to the remote site."""

import math
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import Any

from common.files.constants import within
from common.link.clock_offset import ClockOffset
from common.runtime.containment import Containment
from common.web.access import Visitor
from common.wire.voice_messages import VoiceState
from operator_site.console.voice.voice import Talk
from operator_site.console.voice.voice_sound import VoiceSound, clock_message, read_page_sound
from operator_site.console.web.clients import Client
from operator_site.console.web.stream_pages import StreamPages

READS_S = 2.5
"""Time since a page's newest answer after which it gets no sounds, s: it reads nothing, and sounds would wait."""
MOST_WAITING = 25
"""Maximum number of messages that wait to be sent to a page; further ones replace the oldest. 0.5 s of sound."""
TALKS_S = 0.3
"""Time since a page's newest sound within which it talks, s."""
_LARGEST_S = 1e9
"""Largest time of a clock, s."""


@dataclass(slots=True, eq=False)
class Listener:
    """One page that hears the voice, and talks while it is in control.

    Attributes:
        visitor: user of the page.
        name: name of its page of the session; empty before its first answer.
        microphone: whether it has the microphone.
        plays: whether it plays the sounds.
        answered_s: `sent_s` of the newest message that it has answered.
        said_s: time of its newest sound.
        clock: offset of the page's clock.
        queue: messages that are to be sent.
    """

    visitor: Visitor
    name: str = ""
    microphone: bool = False
    plays: bool = False
    answered_s: float = -math.inf
    said_s: float = -math.inf
    clock: ClockOffset = field(default_factory=ClockOffset)
    queue: deque[bytes] = field(default_factory=lambda: deque(maxlen=MOST_WAITING))


class VoicePages(StreamPages[Listener]):
    """Relays sounds."""

    def __init__(
        self,
        contain: Containment,
        holder: Callable[[], Client | None],
        say: Callable[[VoiceSound], None] = lambda sound: None,
        clock_s: Callable[[], float] = time.monotonic,
    ):
        """Begin without pages.

        Args:
            contain: contains errors of one page.
            holder: returns the page of the session that is in control.
            say: sends a sound of that page to the remote site; its times are of this machine's clock.
            clock_s: this machine's monotonic clock, s.
        """
        super().__init__(contain, clock_s)
        self._holder, self._say = holder, say

    def show(self, sound: VoiceSound) -> None:
        """Send a sound to all pages that read."""
        now_s = self._clock_s()
        for page, ready in self._pages.items():
            if now_s - page.answered_s <= READS_S:
                page.queue.append(sound.encode(now_s))
                ready.set()

    @property
    def talk(self) -> Talk:
        """What the pages do now."""
        now_s = self._clock_s()
        hears = any(page.plays and now_s - page.answered_s <= READS_S for page in self._pages)
        page = next((page for page in reversed(self._pages) if self._may_talk(page)), None)
        if page is None or not page.microphone or now_s - page.answered_s > READS_S:
            return Talk(VoiceState.ABSENT, hears=hears)
        if now_s - page.said_s > TALKS_S:
            return Talk(VoiceState.MUTED, hears=hears)
        return Talk(VoiceState.TALKS, page.name, hears)

    def _may_talk(self, page: Listener) -> bool:
        """Return whether a page belongs to the page in control."""
        holder = self._holder()
        return holder is not None and (page.name, page.visitor) == (holder.name, holder.visitor)

    def _new(self, visitor: Visitor) -> Listener:
        return Listener(visitor)

    def _take(self, page: Listener, message: dict[str, Any]) -> None:
        """Take an answer of a page: its name, what it does, and its clock; answer with a time of this clock."""
        now_s = self._clock_s()
        page.name = str(message["page"])
        page.microphone, page.plays = message["microphone"] is True, message["plays"] is True
        times_s = [message[name] for name in ("sent_s", "heard_s", "answered_s")]
        if not all(within(time_s, -_LARGEST_S, _LARGEST_S) for time_s in times_s) or times_s[0] > now_s:
            raise ValueError(f"times {times_s}")
        if times_s[0] > 0.0:
            sent_ns, heard_ns, answered_ns = (round(time_s * 1e9) for time_s in times_s)
            page.clock.add(sent_ns, heard_ns, answered_ns, round(now_s * 1e9))
            page.answered_s = max(page.answered_s, times_s[0])
        page.queue.append(clock_message(now_s))
        self._pages[page].set()

    def _take_bytes(self, page: Listener, packed: bytes) -> None:
        """Send a sound of the page in control to the remote site; another page's is dropped."""
        sound = read_page_sound(packed)
        uncertainty_ns = page.clock.uncertainty_ns
        if not self._may_talk(page) or uncertainty_ns is None:
            return
        page.said_s = self._clock_s()
        captured_s = sound.captured_s - page.clock.offset_ns * 1e-9
        self._say(replace(sound, captured_s=captured_s, uncertainty_s=uncertainty_ns * 1e-9))
