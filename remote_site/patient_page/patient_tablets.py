"""Serves the websockets of the patient's page: asks each page for an answer, and takes it."""

import asyncio
import json
import time
from collections import Counter
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass

from starlette.websockets import WebSocket, WebSocketDisconnect

from common.runtime.containment import Containment
from common.web.access import Visitor
from common.web.guarded_page import REFUSED
from remote_site.patient_page.tablet_switch import BadAnswer, PageAnswer, TabletSwitch

ASK_S = 0.020
"""Time between two questions to a page, s."""
AWAY_S = 2.0
"""Silence after which another page takes the place of the page in use, s."""
MOST_PAGES = 4
"""Maximum number of pages at a time."""
NOT_UNDERSTOOD, FULL = 4400, 4408
"""Close codes: an answer that cannot be used, and too many pages."""


@dataclass(slots=True, eq=False)
class _Tablet:
    """One page; `heard_s` is the time of its newest answer."""

    heard_s: float


class PatientTablets:
    """The pages of the patient. One of them is in use, and a press on any of them stops.

    Attributes:
        switch: the switch that they are.
        counts: numbers of answers, presses, and refused pages and answers.
    """

    def __init__(
        self,
        switch: TabletSwitch,
        site_reads: Callable[[], bool],
        contain: Containment,
        now_s: Callable[[], float] = time.monotonic,
    ) -> None:
        """Serve pages; `site_reads` returns whether the remote site has the switch open."""
        self.switch, self.contain = switch, contain
        self.counts: Counter[str] = Counter()
        self._site_reads, self._now_s = site_reads, now_s
        self._tablets: list[_Tablet] = []
        self._in_use: _Tablet | None = None

    @property
    def present(self) -> int:
        """Number of pages."""
        return len(self._tablets)

    async def serve(self, socket: WebSocket, visitor: Visitor) -> None:
        """Serve one page until it leaves."""
        if visitor.role != "act" or len(self._tablets) >= MOST_PAGES:
            self.counts["pages refused"] += 1
            await socket.close(REFUSED if visitor.role != "act" else FULL)
            return
        tablet = _Tablet(self._now_s())
        if not self._tablets:
            self.switch.begin(tablet.heard_s)
        self._tablets.append(tablet)
        asking = asyncio.create_task(self._ask(socket, tablet))
        try:
            while (message := await socket.receive())["type"] == "websocket.receive":
                self._take(tablet, message.get("text") or "")
        except BadAnswer:
            self.counts["bad answers"] += 1
            with suppress(OSError, RuntimeError, WebSocketDisconnect):
                await socket.close(NOT_UNDERSTOOD)
        finally:
            asking.cancel()
            self._tablets.remove(tablet)
            if self._in_use is tablet:
                self._in_use = None

    def _take(self, tablet: _Tablet, text: str) -> None:
        answer, now_s = PageAnswer.decode(text), self._now_s()
        self.counts["answers"] += 1
        self.counts["presses"] += answer.pressed and not self.switch.pressed(now_s)
        tablet.heard_s = now_s
        if self._in_use is None or now_s - self._in_use.heard_s > AWAY_S:
            self._in_use = tablet
        if tablet is self._in_use:
            self.switch.take(answer, now_s)
        elif answer.pressed:
            self.switch.press(now_s)

    async def _ask(self, socket: WebSocket, tablet: _Tablet) -> None:
        """Send the time and the state to a page again and again."""
        with suppress(OSError, RuntimeError, WebSocketDisconnect):
            while True:
                now_s = self._now_s()
                asked = {
                    "at_s": now_s,
                    "site": self._site_reads(),
                    "in_use": self._in_use is None or tablet is self._in_use,
                    "stopped": self.switch.pressed(now_s),
                    "pain": self.switch.pain if self.switch.slider else None,
                }
                await socket.send_text(json.dumps(asked))
                await asyncio.sleep(ASK_S)
