"""Pages of the patient: one is in use, a press on any of them counts, and a strange one is sent away."""

import asyncio
import json
from collections.abc import Coroutine
from typing import Any

import pytest

from common.limits import SWITCH_LOST_S
from common.runtime.containment import Containment
from common.web.access import Visitor
from common.web.guarded_page import REFUSED
from remote_site.patient_page.patient_tablets import AWAY_S, FULL, MOST_PAGES, NOT_UNDERSTOOD, PatientTablets
from remote_site.patient_page.tablet_switch import TabletSwitch

PATIENT = Visitor("patient", "act")


class Tablet:
    """A page that the test drives."""

    def __init__(self) -> None:
        self.said: asyncio.Queue[dict[str, Any]] = asyncio.Queue()
        self.asked: list[dict[str, Any]] = []
        self.closed: int | None = None

    def answer(self, *, pressed: bool = False, pain: int = 0) -> None:
        self.say(json.dumps({"at_s": self.asked[-1]["at_s"], "pressed": pressed, "pain": pain}))

    def say(self, said: str | bytes) -> None:
        self.said.put_nowait({"type": "websocket.receive", "text" if isinstance(said, str) else "bytes": said})

    def leave(self) -> None:
        self.said.put_nowait({"type": "websocket.disconnect"})

    async def receive(self) -> dict[str, Any]:
        return await self.said.get()

    async def send_text(self, text: str) -> None:
        self.asked.append(json.loads(text))

    async def close(self, code: int = 1000) -> None:
        self.closed = code


class Ward:
    """The pages' server at a time that the test sets."""

    def __init__(self) -> None:
        self.now_s = 100.0
        self.switch = TabletSwitch(slider=True)
        self.tablets = PatientTablets(self.switch, lambda: True, Containment(), lambda: self.now_s)
        self._serving: list[asyncio.Task[None]] = []

    async def enter(self, visitor: Visitor = PATIENT) -> Tablet:
        tablet = Tablet()
        self._serving.append(asyncio.create_task(self.tablets.serve(tablet, visitor)))  # type: ignore[arg-type]
        await settle()
        return tablet

    async def leave(self) -> None:
        for each in self._serving:
            each.cancel()
        await asyncio.gather(*self._serving, return_exceptions=True)


async def settle() -> None:
    for _ in range(5):
        await asyncio.sleep(0)


def carry_out(story: Coroutine[Any, Any, None]) -> None:
    asyncio.run(story)


def test_a_page_is_asked_and_its_answer_reaches_the_switch() -> None:
    async def story() -> None:
        ward = Ward()
        tablet = await ward.enter()
        assert tablet.asked[-1] == {"at_s": 100.0, "site": True, "in_use": True, "stopped": False, "pain": 0}
        tablet.answer(pain=4)
        await settle()
        assert ward.switch.fresh(100.05)
        assert ward.switch.pain == 4
        tablet.answer(pressed=True)
        await settle()
        assert ward.switch.pressed(100.05)
        assert ward.tablets.counts == {"answers": 2, "presses": 1}
        await ward.leave()

    carry_out(story())


def test_a_second_page_stops_and_does_nothing_else_until_the_first_is_away() -> None:
    async def story() -> None:
        ward = Ward()
        first, second = await ward.enter(), await ward.enter()
        first.answer(pain=2)
        await settle()
        second.answer(pain=9)
        await settle()
        assert ward.switch.pain == 2
        second.answer(pressed=True)
        await settle()
        assert ward.switch.pressed(ward.now_s)
        ward.now_s += AWAY_S + 0.1
        second.answer(pain=9)
        second.asked[-1]["at_s"] = ward.now_s
        second.answer(pain=9)
        await settle()
        assert ward.switch.pain == 9
        await ward.leave()

    carry_out(story())


def test_a_page_that_leaves_gives_way_at_once() -> None:
    async def story() -> None:
        ward = Ward()
        first, second = await ward.enter(), await ward.enter()
        first.answer(pain=2)
        await settle()
        first.leave()
        await settle()
        second.answer(pain=5)
        await settle()
        assert ward.switch.pain == 5
        assert ward.tablets.present == 1
        await ward.leave()

    carry_out(story())


@pytest.mark.parametrize("said", ["no json", b"bytes", '{"at_s": 1, "pressed": false, "pain": 99}'])
def test_a_page_that_is_not_understood_is_sent_away(said: str | bytes) -> None:
    async def story() -> None:
        ward = Ward()
        tablet = await ward.enter()
        tablet.say(said)
        await settle()
        assert tablet.closed == NOT_UNDERSTOOD
        assert ward.tablets.present == 0
        assert not ward.switch.fresh(ward.now_s)
        await ward.leave()

    carry_out(story())


def test_observers_and_too_many_pages_are_sent_away() -> None:
    async def story() -> None:
        ward = Ward()
        assert (await ward.enter(Visitor("relative", "observe"))).closed == REFUSED
        pages = [await ward.enter() for _ in range(MOST_PAGES + 1)]
        assert [page.closed for page in pages] == [None] * MOST_PAGES + [FULL]
        await ward.leave()

    carry_out(story())


def test_a_page_that_is_loaded_again_begins_with_the_pain_of_before() -> None:
    async def story() -> None:
        ward = Ward()
        first = await ward.enter()
        first.answer(pain=7)
        await settle()
        first.leave()
        await settle()
        ward.now_s += SWITCH_LOST_S
        again = await ward.enter()
        assert again.asked[-1]["pain"] == ward.switch.pain == 7
        again.leave()
        await settle()
        ward.now_s += 0.01
        later = await ward.enter()
        assert later.asked[-1]["pain"] == ward.switch.pain == 0, "after a fault, it is another patient's perhaps"
        await ward.leave()

    carry_out(story())
