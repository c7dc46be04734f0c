"""Pages that idle or fail leave the others alone: places are kept, what one page raises ends no other."""

import asyncio
from collections.abc import Callable
from typing import Any

import pytest

from common.web.access import Visitor
from operator_site.console.model import Console
from operator_site.console.web.clients import AWAKE_S
from operator_site.console.web.pages import FAILED, FULL, REPLACED
from tests.conftest import Contained
from tests.unit.operator_site.console.page_room import OR_1, STUDENT, Room, settled


def in_room(course: Callable[[Room], Any]) -> None:
    async def run() -> None:
        room = Room()
        try:
            await course(room)
        finally:
            await room.empty()

    asyncio.run(run())


@pytest.mark.parametrize("visitor", [STUDENT, OR_1])
def test_idle_pages_do_not_keep_the_operator_out(visitor: Visitor) -> None:
    async def course(room: Room) -> None:
        idle = [await room.enter(visitor) for _ in range(40)]
        room.now_s += AWAKE_S + 1.0
        page = await room.enter(OR_1)
        await room.stop(page)
        assert page.closed is None
        assert len(room.pages.clients) <= 20
        sent_away = {socket.closed for socket in idle} - {None}
        assert sent_away <= {REPLACED, FULL}

    in_room(course)


def test_a_page_that_is_replaced_is_sent_away_and_control_stays() -> None:
    async def course(room: Room) -> None:
        pages = [await room.enter(OR_1) for _ in range(7)]
        await settled(lambda: pages[1].closed is not None)
        assert [page.closed for page in pages] == [None, REPLACED, None, None, None, None, None]
        assert room.pages.control.name == "OR-1 1"

    in_room(course)


def test_a_page_whose_socket_fails_is_sent_away_and_the_others_stay(contained: Contained) -> None:
    async def course(room: Room) -> None:
        first, other = await room.enter(OR_1), await room.enter(OR_1)
        first.said.put_nowait(KeyError("text"))
        await settled(lambda: first.closed is not None)
        assert first.closed == FAILED
        assert room.pages.control.name == "OR-1 2"
        await room.stop(other)
        assert other.closed is None

    in_room(course)
    (name,) = contained.take()
    assert "KeyError" in name


def test_a_picture_that_cannot_be_drawn_leaves_stop_and_state(
    contained: Contained, monkeypatch: pytest.MonkeyPatch
) -> None:
    def broken(*_: object) -> bytes:
        raise ValueError("no picture")

    async def course(room: Room) -> None:
        page = await room.enter(OR_1)
        monkeypatch.setattr(Console, "picture", broken)
        for _ in range(3):
            room.pages.show(None)
            await asyncio.sleep(0.0)
        await room.stop(page)
        assert page.pictures == 0
        monkeypatch.undo()
        room.pages.show(None)
        await settled(lambda: page.pictures == 1)

    in_room(course)
    (name,) = contained.take()
    assert "no picture" in name
