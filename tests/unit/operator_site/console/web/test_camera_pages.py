"""Pages that watch the camera: each at its own pace, within the places of their role."""

import asyncio
import json
from collections.abc import Coroutine
from concurrent.futures import Future
from dataclasses import replace
from typing import Any

import pytest

from common.runtime.containment import Containment
from operator_site.console.camera.camera_picture import Picture
from operator_site.console.camera.stills import STILL_S, Stills
from operator_site.console.web.camera_pages import CameraPages
from operator_site.console.web.clients import AWAKE_S
from operator_site.console.web.pages import FULL, MESSAGES_AT_ONCE, NOT_UNDERSTOOD, TOO_MUCH
from operator_site.console.web.places import OBSERVING_PLACES
from operator_site.console.web.viewer import CREDIT
from tests.unit.operator_site.console.page_room import OR_1, STUDENT, Socket, settled
from tests.unit.operator_site.console.web.test_viewer import picture


class Watching:
    """Pages that watch, and a camera that the test drives."""

    def __init__(self) -> None:
        self.now_s = 100.0
        self.pages = CameraPages(Containment(), lambda: self.now_s)
        self._serving: list[asyncio.Task[None]] = []

    async def enter(self, socket: Socket | None = None) -> Socket:
        """A page that comes and stays."""
        page = Socket() if socket is None else socket
        self._serving.append(asyncio.create_task(self.pages.serve(page, STUDENT)))
        await asyncio.sleep(0.0)
        return page

    async def end(self) -> None:
        for serving in self._serving:
            serving.cancel()
        await asyncio.gather(*self._serving, return_exceptions=True)


def run(doing: Coroutine[Any, Any, None]) -> None:
    asyncio.run(doing)


class Stuck(Socket):
    """A page that takes no message."""

    async def send_bytes(self, packed: bytes) -> None:
        await asyncio.Event().wait()


def test_a_slow_page_and_a_stuck_one_slow_no_other() -> None:
    async def watch() -> None:
        room = Watching()
        quick, slow, stuck = await room.enter(), await room.enter(), await room.enter(Stuck())
        for number in range(1, 31):
            room.pages.show(picture(number, is_key=number == 1))
            await settled(lambda number=number: quick.pictures == number)
            quick.said.put_nowait(json.dumps({"kind": "drawn", "sequence": number}))
            await settled(quick.said.empty)
        assert (slow.pictures, stuck.pictures) == (CREDIT, 0)
        assert not room.pages.wants_key  # neither page has room for one
        slow.said.put_nowait(json.dumps({"kind": "drawn", "sequence": CREDIT}))
        await settled(lambda: room.pages.wants_key)
        room.pages.show(picture(31, is_key=True))
        await settled(lambda: slow.pictures == CREDIT + 1)
        await room.end()

    run(watch())


def test_a_page_that_cannot_decode_gets_the_next_key_picture() -> None:
    async def watch() -> None:
        room = Watching()
        page = await room.enter()
        room.pages.show(picture(1, is_key=True))
        await settled(lambda: page.pictures == 1)
        page.said.put_nowait(json.dumps({"kind": "lost"}))
        await settled(lambda: room.pages.wants_key)
        room.pages.restart([picture(1, is_key=True), picture(2)], waiting=True)
        await settled(lambda: page.pictures == 3)
        room.pages.restart([picture(3, is_key=True)], waiting=True)
        assert not room.pages.wants_key
        await room.end()

    run(watch())


class Making:
    """Makes still pictures at once."""

    def __init__(self) -> None:
        self.made: list[int] = []

    def __call__(self, given: list[Picture]) -> "Future[Picture]":
        self.made.append(given[-1].sequence)
        running: Future[Picture] = Future()
        running.set_result(replace(given[-1], is_key=True))
        return running


def test_a_page_that_decodes_nothing_gets_still_pictures_and_the_others_all() -> None:
    async def watch() -> None:
        room, making = Watching(), Making()
        room.pages._stills = Stills(making)
        quick, still = await room.enter(), await room.enter()
        room.pages.show(picture(1, is_key=True))
        await settled(lambda: still.pictures == 1)
        still.said.put_nowait(json.dumps({"kind": "still"}))
        await settled(lambda: room.pages.wants_key)
        assert making.made == []
        room.pages.show(picture(2, is_key=True))
        assert not room.pages.wants_key
        for _ in range(2):
            room.pages.step()
        await settled(lambda: still.pictures == 2)
        room.now_s += STILL_S
        room.pages.show(picture(3))
        room.pages.step()
        assert making.made == [2]  # the page has not drawn the last one
        still.said.put_nowait(json.dumps({"kind": "drawn", "sequence": 2}))
        await settled(still.said.empty)
        for _ in range(2):
            room.pages.step()
        await settled(lambda: still.pictures == 3)
        await settled(lambda: quick.pictures == 3)
        late = await room.enter()
        late.said.put_nowait(json.dumps({"kind": "still"}))
        await settled(lambda: late.pictures == 1)  # the newest one, as in a paused recording
        late.said.put_nowait(json.dumps({"kind": "drawn", "sequence": 3}))
        await settled(late.said.empty)
        await asyncio.sleep(0.0)
        room.pages.restart([picture(90, is_key=True), picture(91)])
        room.now_s += STILL_S
        for _ in range(2):
            room.pages.step()
        await settled(lambda: making.made == [2, 3, 91])
        await settled(lambda: quick.pictures == 5)
        await room.end()
        assert room.pages._stills.wants_key  # nobody needs one any more

    run(watch())


@pytest.mark.parametrize("text", [b"binary", "no json", "[]", "7", "[" * 20_000])
def test_a_page_that_is_not_understood_leaves_and_its_place_is_free(text: str | bytes) -> None:
    room, page = Watching(), Socket(text)
    asyncio.run(room.pages.serve(page, OR_1))
    assert page.closed == NOT_UNDERSTOOD
    assert not room.pages.wants_key


def test_a_page_that_says_too_much_leaves() -> None:
    room = Watching()
    page = Socket(*[json.dumps({"kind": "drawn", "sequence": []})] * (MESSAGES_AT_ONCE + 1))
    asyncio.run(room.pages.serve(page, OR_1))
    assert page.closed == TOO_MUCH


def test_a_page_that_was_silent_longest_leaves_its_place_to_a_new_one() -> None:
    async def watch() -> None:
        room = Watching()
        pages = [await room.enter() for _ in range(OBSERVING_PLACES)]
        room.now_s += AWAKE_S + 1.0
        for page in (*pages[:3], *pages[4:]):
            page.said.put_nowait(json.dumps({"kind": "drawn"}))
            await settled(page.said.empty)
        new = await room.enter()
        room.pages.show(picture(1, is_key=True))
        await settled(lambda: new.pictures == 1)
        assert [page.pictures for page in pages] == [1] * 3 + [0] + [1] * (OBSERVING_PLACES - 4)
        last = await room.enter()
        await settled(lambda: last.closed == FULL)
        await room.end()

    run(watch())


def test_observers_leave_places_for_those_who_act() -> None:
    async def watch() -> None:
        room = Watching()
        pages = [await room.enter() for _ in range(OBSERVING_PLACES + 1)]
        await settled(lambda: pages[-1].closed == FULL)
        assert [page.closed for page in pages[:-1]] == [None] * OBSERVING_PLACES
        acting = Socket(json.dumps({"kind": "drawn"}), leaves=True)
        await room.pages.serve(acting, OR_1)
        assert acting.closed is None
        await room.end()

    run(watch())
