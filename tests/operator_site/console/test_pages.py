"""What one page may say: within its rate everything, above it a stop and no more."""

import asyncio
import json
from typing import Any, cast

import pytest
from starlette.websockets import WebSocket, WebSocketDisconnect

from operator_site.console.access import Visitor
from operator_site.console.acts import Acts
from operator_site.console.clients import Client
from operator_site.console.console import Console
from operator_site.console.control import Control
from operator_site.console.pages import (
    FULL,
    MESSAGES_AT_ONCE,
    NOT_UNDERSTOOD,
    OPENINGS_AT_ONCE,
    REQUESTS_AT_ONCE,
    TOO_MUCH,
    Pages,
)
from tests.conftest import Contained
from tests.operator_site.console.test_acts import Desk, Keeper

ALIVE = json.dumps({"kind": "alive", "visible": True})
OR_1, STUDENT = Visitor("OR-1", "act"), Visitor("student", "observe")


class Socket:
    """A page that says what the test lets it, and then goes."""

    def __init__(self, *said: str | bytes) -> None:
        self.said = list(said)
        self.closed: int | None = None
        self.sent: list[dict[str, Any]] = []

    async def receive_text(self) -> str | bytes:
        await asyncio.sleep(0)
        if not self.said:
            for _ in range(20):  # what was asked for last is answered meanwhile
                await asyncio.sleep(0.001)
            raise WebSocketDisconnect
        return self.said.pop(0)

    async def receive(self) -> dict[str, Any]:
        said = await self.receive_text()
        return {"type": "websocket.receive", "text" if isinstance(said, str) else "bytes": said}

    async def send_text(self, text: str) -> None:
        self.sent.append(json.loads(text))

    async def send_bytes(self, packed: bytes) -> None:
        pass

    async def close(self, code: int, reason: str | None = None) -> None:
        self.closed = code


class Room:
    """Pages in front of a desk."""

    def __init__(self) -> None:
        self.desk, console, control = Desk(), Console(), Control()
        self.acts = Acts(console, self.desk, Keeper(), control, None)
        self.pages = Pages(lambda: console, self.acts, control)

    def serve(self, visitor: Visitor, *said: str | bytes) -> Socket:
        socket = Socket(*said)
        serving = self.pages.serve(
            cast(WebSocket, socket), lambda number: Client(visitor, f"{visitor.name} {number}", 0.0)
        )
        asyncio.run(serving)
        return socket


def ask(ident: int, verb: str) -> str:
    return json.dumps({"kind": "ask", "id": ident, "verb": verb, "details": {}})


@pytest.fixture
def room() -> Room:
    return Room()


def test_a_page_that_says_too_much_is_sent_away_and_another_one_is_served(room: Room) -> None:
    socket = room.serve(STUDENT, *[ALIVE] * (MESSAGES_AT_ONCE + 50))
    assert socket.closed == TOO_MUCH
    assert len(socket.said) >= 40
    assert room.serve(OR_1, ALIVE, ask(1, "estop")).closed is None
    assert room.desk.asked == ["estop"]


def test_requests_are_limited_for_all_pages_of_one_visitor(room: Room) -> None:
    asked = [ask(number, "estop") for number in range(REQUESTS_AT_ONCE - 10)]
    first = room.serve(STUDENT, *asked)
    second = room.serve(STUDENT, *asked)
    assert (first.closed, second.closed) == (None, TOO_MUCH)
    assert room.serve(Visitor("nurse", "observe"), ask(1, "place")).closed is None
    assert room.desk.asked == []


def test_a_stop_of_who_may_act_counts_at_any_rate(room: Room) -> None:
    said = [ask(number, "disengage") for number in range(REQUESTS_AT_ONCE)]
    socket = room.serve(OR_1, *said, ask(900, "estop"))
    assert socket.closed is None
    assert "estop" in room.desk.asked


@pytest.mark.parametrize(
    "text",
    [
        b"binary",
        "no json",
        "[]",
        '{"kind": "ask", "id": ' + "9" * 5000 + "}",
        "[" * 20_000,
        '{"kind": "ask", "id": "\\ud800',
    ],
)
def test_what_is_no_message_ends_this_page_only(room: Room, text: str | bytes) -> None:
    assert room.serve(STUDENT, text).closed == NOT_UNDERSTOOD
    assert room.serve(OR_1, ask(1, "estop")).sent
    assert room.desk.asked == ["estop"]


@pytest.mark.parametrize("details", ['{"half \\ud83d": 1}', '{"a": {"b": "\\ud83d"}}', "[1, 2]", "null", '"\\ud800"'])
def test_a_request_with_strange_details_is_answered(room: Room, details: str) -> None:
    said = f'{{"kind": "ask", "id": 5, "verb": "disengage", "details": {details}}}'
    answers = [told for told in room.serve(OR_1, said).sent if told["kind"] == "answer"]
    assert [(told["id"], told["ok"]) for told in answers] == [(5, True)]


def test_a_request_that_fails_in_the_console_is_answered(
    room: Room, monkeypatch: pytest.MonkeyPatch, contained: Contained
) -> None:
    async def fail(*given: object) -> None:
        raise KeyError("detail")

    monkeypatch.setattr(room.acts, "ask", fail)
    (answer,) = [told for told in room.serve(OR_1, ask(1, "engage")).sent if told["kind"] == "answer"]
    assert not answer["ok"]
    assert "KeyError" in contained.take()[0]


def test_above_its_rate_only_a_stop_itself_counts(room: Room) -> None:
    said = json.dumps({"kind": "alive", "visible": True, "verb": "estop"})
    assert room.serve(OR_1, *[said] * (MESSAGES_AT_ONCE + 50)).closed == TOO_MUCH


def test_an_observer_who_comes_again_and_again_is_sent_away(room: Room, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(room.pages, "_now_s", lambda: 100.0)
    codes = [room.serve(STUDENT, ALIVE).closed for _ in range(OPENINGS_AT_ONCE + 5)]
    assert codes == [None] * OPENINGS_AT_ONCE + [FULL] * 5
    assert [room.serve(OR_1, ALIVE).closed for _ in range(OPENINGS_AT_ONCE + 5)] == [None] * (OPENINGS_AT_ONCE + 5)


class Played:
    """A recording in which every moment is read already."""

    def __init__(self) -> None:
        self.sought_s: list[float] = []

    def play(self, speed: float) -> None:
        pass

    def pause(self) -> None:
        pass

    def seek(self, at_s: float) -> bool:
        self.sought_s.append(at_s)
        return True


def test_a_slider_of_a_recording_may_be_dragged_without_end() -> None:
    console, control, played = Console(), Control(), Played()
    pages = Pages(lambda: console, Acts(console, None, Keeper(), control, played), control)
    said = [
        json.dumps({"kind": "ask", "id": number, "verb": "seek", "details": {"at_s": 0.1 * number}})
        for number in range(3 * REQUESTS_AT_ONCE)
    ]
    socket = Socket(*said)
    asyncio.run(pages.serve(cast(WebSocket, socket), lambda number: Client(OR_1, f"OR-1 {number}", 0.0)))
    assert socket.closed is None
    assert len(played.sought_s) == 3 * REQUESTS_AT_ONCE
