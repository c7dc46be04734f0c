"""Pages that hear the voice: only the page in control talks, and a page that does not read gets no queue."""

import asyncio
import json
from collections.abc import Callable
from typing import Any

import pytest

from common.runtime.containment import Containment
from common.web.access import Visitor
from common.wire.voice_messages import VoiceState
from operator_site.console.voice.voice_sound import HEADER, MAGIC, PAGE_HEADER, VERSION, VoiceSound
from operator_site.console.web.clients import Client
from operator_site.console.web.pages import MESSAGES_AT_ONCE, NOT_UNDERSTOOD, TOO_MUCH
from operator_site.console.web.voice_pages import MOST_WAITING, READS_S, TALKS_S, VoicePages
from tests.unit.operator_site.console.page_room import OR_1, STUDENT, Socket, settled

CONTENT = b"opus"
AHEAD_S = 50.0
"""The page's clock is so far ahead of the console's."""


class Page(Socket):
    """A page with a name, which answers as voice.js does, on a clock of its own."""

    def __init__(self, room: "Room", name: str) -> None:
        super().__init__()
        self.room, self.name = room, name
        self.got: list[tuple[int, float, float, bytes]] = []
        """Sequence, begin and sending of each message, and its sound."""

    async def send_bytes(self, packed: bytes) -> None:
        _, _, sequence, captured_s, sent_s, _ = HEADER.unpack_from(packed)
        self.got.append((sequence, captured_s, sent_s, packed[HEADER.size :]))

    @property
    def sounds(self) -> list[int]:
        """Numbers of the sounds."""
        return [sequence for sequence, _, _, content in self.got if content]

    async def answer(self, **changed: object) -> None:
        """Answer the newest message, and receive the console's next time."""
        sent_s, heard_s = (self.got[-1][2], self.room.now_s + AHEAD_S) if self.got else (0.0, 0.0)
        message = {"page": self.name, "microphone": True, "plays": True, "sent_s": sent_s, "heard_s": heard_s}
        got = len(self.got)
        self.room.now_s += 0.004
        self.said.put_nowait(json.dumps(message | {"answered_s": self.room.now_s + AHEAD_S - 0.002} | changed))
        await settled(lambda: len(self.got) > got or self.closed is not None)

    async def say(self, sequence: int, old_s: float = 0.02) -> None:
        captured_s = self.room.now_s + AHEAD_S - old_s
        self.said.put_nowait(PAGE_HEADER.pack(MAGIC, VERSION, sequence, captured_s) + CONTENT)
        await settled(self.said.empty)
        await asyncio.sleep(0.0)


class Room:
    """Pages of the voice, of which one is in control."""

    def __init__(self) -> None:
        self.now_s = 100.0
        self.holder: Client | None = Client(OR_1, "OR-1 1", 0.0)
        self.said: list[VoiceSound] = []
        self.pages = VoicePages(Containment(), lambda: self.holder, self.said.append, lambda: self.now_s)
        self.serving: dict[Page, asyncio.Task[None]] = {}

    async def enter(self, visitor: Visitor, name: str, kind: type[Page] = Page) -> Page:
        page = kind(self, name)
        self.serving[page] = asyncio.create_task(self.pages.serve(page, visitor))
        await asyncio.sleep(0.0)
        return page

    async def end(self) -> None:
        for serving in self.serving.values():
            serving.cancel()
        await asyncio.gather(*self.serving.values(), return_exceptions=True)


def run(watch: Callable[[Room], Any]) -> None:
    async def running() -> None:
        room = Room()
        await watch(room)
        await room.end()

    asyncio.run(running())


def heard(sequence: int, room: Room) -> VoiceSound:
    return VoiceSound("from_remote", sequence, room.now_s - 0.05, 0.001, CONTENT)


def test_control_talks_an_observer_hears_and_another_page_does_neither_harm() -> None:
    async def watch(room: Room) -> None:
        control, second = await room.enter(OR_1, "OR-1 1"), await room.enter(OR_1, "OR-1 2")
        observer, liar = await room.enter(STUDENT, "student 3"), await room.enter(STUDENT, "OR-1 1")
        for page in (control, second, observer, liar):
            await page.answer()
            await page.answer()
        for page in (second, observer, liar):
            await page.say(1)
        assert room.said == []
        assert room.pages.talk.state is VoiceState.MUTED
        await control.say(1)
        assert [sound.sequence for sound in room.said] == [1]
        assert (room.pages.talk.state, room.pages.talk.talker) == (VoiceState.TALKS, "OR-1 1")
        room.pages.show(heard(9, room))
        await settled(lambda: all(page.sounds == [9] for page in (control, second, observer, liar)))
        room.now_s += TALKS_S + 0.1
        assert room.pages.talk.state is VoiceState.MUTED

    run(watch)


def test_a_pages_sound_has_its_time_on_this_side() -> None:
    async def watch(room: Room) -> None:
        page = await room.enter(OR_1, "OR-1 1")
        await page.answer()
        await page.say(1)
        assert room.said == [], "the clocks were not compared yet"
        await page.answer()
        await page.say(2, old_s=0.1)
        sound = room.said[0]
        assert abs(sound.captured_s - (room.now_s - 0.1)) <= sound.uncertainty_s < 0.003
        assert (sound.direction, sound.content) == ("to_remote", CONTENT)

    run(watch)


@pytest.mark.parametrize("leaves", ["voice", "control", "microphone", "answers"])
def test_talking_ends_when_the_page_goes(leaves: str) -> None:
    async def watch(room: Room) -> None:
        page = await room.enter(OR_1, "OR-1 1")
        await page.answer()
        await page.answer()
        await page.say(1)
        assert room.pages.talk.state is VoiceState.TALKS
        if leaves == "voice":
            await page.close()
            await settled(room.serving[page].done)
        elif leaves == "control":
            room.holder = Client(STUDENT, "OR-1 1", 0.0)
        elif leaves == "microphone":
            await page.answer(microphone=False)
        else:
            room.now_s += READS_S + 1.0
        assert room.pages.talk.state is VoiceState.ABSENT
        assert room.pages.talk.hears == (leaves in ("control", "microphone"))
        if leaves == "control":
            await page.say(2)
            assert len(room.said) == 1

    run(watch)


class Stuck(Page):
    """A page that takes no message after the first two."""

    async def send_bytes(self, packed: bytes) -> None:
        if len(self.got) >= 2:
            await asyncio.Event().wait()
        await super().send_bytes(packed)


def test_a_page_that_does_not_read_gets_no_queue_and_slows_no_other() -> None:
    async def watch(room: Room) -> None:
        page, stuck = await room.enter(OR_1, "OR-1 1"), await room.enter(STUDENT, "student 2", Stuck)
        for one in (page, stuck):
            await one.answer()
            await one.answer()
        for number in range(1, 101):
            room.now_s += 0.02
            room.pages.show(heard(number, room))
            await settled(lambda number=number: page.sounds == list(range(1, number + 1)))
        listener = next(one for one in room.pages._pages if one.name == "student 2")
        assert len(listener.queue) == MOST_WAITING
        room.now_s += READS_S
        listener.queue.clear()
        room.pages.show(heard(101, room))
        assert not listener.queue

    run(watch)


def test_a_page_that_never_answered_gets_nothing() -> None:
    async def watch(room: Room) -> None:
        page = await room.enter(STUDENT, "student 1")
        room.pages.show(heard(1, room))
        await page.answer()
        room.pages.show(heard(2, room))
        await page.answer()
        room.pages.show(heard(3, room))
        await settled(lambda: page.sounds == [3])

    run(watch)


@pytest.mark.parametrize(
    "changed",
    [
        {"sent_s": 1e300},
        {"sent_s": 10**400},
        {"sent_s": "x"},
        {"answered_s": None},
        {"heard_s": [1]},
        {"sent_s": 5000.0},
        {"heard_s": 0.0, "answered_s": 1000.0, "sent_s": 99.9},
    ],
)
def test_times_that_cannot_be_end_the_page(changed: dict[str, object]) -> None:
    async def watch(room: Room) -> None:
        page = await room.enter(OR_1, "OR-1 1")
        await page.answer(**changed)
        await settled(lambda: page.closed == NOT_UNDERSTOOD)

    run(watch)


@pytest.mark.parametrize("said", [b"binary", b"", "no json", "[]", "7", '{"page": "x"}'])
def test_a_page_that_is_not_understood_leaves(said: str | bytes) -> None:
    room, socket = Room(), Socket(said)
    asyncio.run(room.pages.serve(socket, OR_1))
    assert socket.closed == NOT_UNDERSTOOD


def test_a_page_that_says_too_much_leaves() -> None:
    room = Room()
    sound = PAGE_HEADER.pack(MAGIC, VERSION, 1, 1.0) + CONTENT
    socket = Socket(*[sound] * (MESSAGES_AT_ONCE + 1))
    asyncio.run(room.pages.serve(socket, OR_1))
    assert socket.closed == TOO_MUCH
