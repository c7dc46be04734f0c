"""One page: within its rate everything counts, above it a stop and no more."""

import json
from typing import Any

import pytest

from common.web.access import Visitor
from operator_site.console.web import clients
from operator_site.console.web.answer import Answer
from operator_site.console.web.clients import Client
from operator_site.console.web.pages import (
    FULL,
    MESSAGES_AT_ONCE,
    NOT_UNDERSTOOD,
    OPENINGS_AT_ONCE,
    REQUESTS_AT_ONCE,
    TOO_MUCH,
)
from tests.conftest import Contained
from tests.unit.operator_site.console.page_room import OR_1, STUDENT, Room, ask

ALIVE = json.dumps({"kind": "alive", "visible": True})


@pytest.fixture
def room() -> Room:
    return Room()


def test_a_page_that_says_too_much_is_sent_away_and_another_one_is_served(room: Room) -> None:
    socket = room.serve(STUDENT, *[ALIVE] * (MESSAGES_AT_ONCE + 50))
    assert socket.closed == TOO_MUCH
    assert socket.said.qsize() >= 40
    assert room.serve(OR_1, ALIVE, ask(1, "estop")).closed is None
    assert room.site.asked == ["estop"]


def test_requests_are_limited_for_all_pages_of_one_visitor(room: Room) -> None:
    asked = [ask(number, "estop") for number in range(REQUESTS_AT_ONCE - 10)]
    first = room.serve(STUDENT, *asked)
    second = room.serve(STUDENT, *asked)
    assert (first.closed, second.closed) == (None, TOO_MUCH)
    assert room.serve(Visitor("nurse", "observe"), ask(1, "place")).closed is None
    assert room.site.asked == []


def test_a_stop_of_who_may_act_counts_at_any_rate(room: Room) -> None:
    said = [ask(number, "disengage") for number in range(REQUESTS_AT_ONCE)]
    socket = room.serve(OR_1, *said, ask(900, "estop"))
    assert socket.closed is None
    assert "estop" in room.site.asked


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
    assert room.site.asked == ["estop"]


@pytest.mark.parametrize("message", ['{"kind": "zoom"}', '{"kind": null}', '{"kind": ["ask"], "verb": "estop"}'])
def test_a_message_of_another_kind_is_ignored(room: Room, message: str) -> None:
    socket = room.serve(OR_1, message, ask(1, "estop"))
    assert (socket.closed, len(socket.answers), room.site.asked) == (None, 1, ["estop"])


def test_a_page_that_leaves_too_many_answers_is_sent_away(room: Room, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(clients, "MOST_ANSWERS", 0)
    assert room.serve(OR_1, ask(1, "estop")).closed == TOO_MUCH


@pytest.mark.parametrize("details", ['{"half \\ud83d": 1}', '{"a": {"b": "\\ud83d"}}', "[1, 2]", "null", '"\\ud800"'])
def test_a_request_with_strange_details_is_answered(room: Room, details: str) -> None:
    said = f'{{"kind": "ask", "id": 5, "verb": "disengage", "details": {details}}}'
    assert [(answer["id"], answer["ok"]) for answer in room.serve(OR_1, said).answers] == [(5, True)]


def test_a_request_that_fails_in_the_console_is_answered(
    room: Room, monkeypatch: pytest.MonkeyPatch, contained: Contained
) -> None:
    async def fail(*given: object) -> None:
        raise KeyError("detail")

    monkeypatch.setattr(room.commands, "ask", fail)
    (answer,) = room.serve(OR_1, ask(1, "engage")).answers
    assert not answer["ok"]
    assert "KeyError" in contained.take()[0]


def test_above_its_rate_only_a_stop_itself_counts(room: Room) -> None:
    said = json.dumps({"kind": "alive", "visible": True, "verb": "estop"})
    assert room.serve(OR_1, *[said] * (MESSAGES_AT_ONCE + 50)).closed == TOO_MUCH


def test_an_observer_who_comes_again_and_again_is_sent_away(room: Room) -> None:
    codes = [room.serve(STUDENT, ALIVE).closed for _ in range(OPENINGS_AT_ONCE + 5)]
    assert codes == [None] * OPENINGS_AT_ONCE + [FULL] * 5
    assert [room.serve(OR_1, ALIVE).closed for _ in range(OPENINGS_AT_ONCE + 5)] == [None] * (OPENINGS_AT_ONCE + 5)


def test_a_slider_of_a_recording_may_be_dragged_without_end() -> None:
    sought_s: list[float] = []

    async def seek(client: Client, details: dict[str, Any], now_s: float) -> Answer:
        sought_s.append(details["at_s"])
        return Answer(True, "")

    said = [ask(number, "seek", at_s=0.1 * number) for number in range(3 * REQUESTS_AT_ONCE)]
    assert Room({"seek": seek}).serve(OR_1, *said).closed is None
    assert len(sought_s) == 3 * REQUESTS_AT_ONCE
