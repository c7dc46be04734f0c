"""Carries out the requests of pages: checks permission, acts, answers, and records each request and its answer."""

import asyncio
import logging
import math
from collections import Counter
from collections.abc import Mapping
from concurrent.futures import Future
from contextlib import suppress
from dataclasses import replace
from typing import Any, Protocol

from common.files.constants import within
from common.limits import MOTION_SCALES
from common.link.rate_limiter import RateLimiters
from common.link.session_state import Refused
from common.recording.camera_marks import VERB, are_marks
from common.runtime.containment import Containment
from common.timing.interval import Interval
from common.wire.packets import LinkState
from operator_site.console import texts
from operator_site.console.alarms.alarm_rules import FAULT, REMOTE_FAULT
from operator_site.console.alarms.alarms import LONGEST_QUIET_S
from operator_site.console.examination.journal import Journal
from operator_site.console.examination.reporting import Reporting
from operator_site.console.local_control import PATIENCE_S, LocalControlSilent
from operator_site.console.model import Console
from operator_site.console.web.answer import Act, Answer
from operator_site.console.web.clients import Client
from operator_site.console.web.control import Control
from operator_site.console.web.examination_requests import ExaminationRequests
from operator_site.console.web.map_requests import propose_kind, values_at
from operator_site.console.web.page_state import refusal
from operator_site.console.web.request_record import LONGEST_KEPT, recorded, shown, whole

log = logging.getLogger(__name__)

PAUSE_AGAIN_S = 0.5
"""Interval between two requests of the console to pause, s."""
CLEARING_S = 2.0
"""Time after clearing a fault in which its alarm is cleared too, once both sites report the fault gone, s."""
_ONLY_LOOKS = frozenset(("place", "propose"))
"""Requests that read the map. They are neither refused to observers nor recorded."""
_WITHOUT_CONTROL = _ONLY_LOOKS | {"estop", "take_control"}
"""Requests that need no control; a page that may act may always stop."""
_REFUSALS_PER_S, _REFUSALS_AT_ONCE = 0.2, 10
"""Rate and burst of the refused requests of one visitor that are recorded and logged; others are only counted."""


class SiteControl(Protocol):
    """Sends requests to the operator site."""

    def ask(self, verb: str, details: dict[str, Any] | None = None) -> "Future[dict[str, Any]]":
        """Send a request; the future holds the site's answer, see `LocalControlClient.ask`."""


class Commands:
    """Carries out the requests of pages. Time is an argument, s of the operator site's clock."""

    def __init__(
        self,
        console: Console,
        journal: Journal,
        site: SiteControl | None = None,
        playing: Mapping[str, Act] | None = None,
        reporting: Reporting | None = None,
    ):
        """Act on a running site through its local control, or on a recording by `playing`, the verbs of its player."""
        self.console, self._journal, self._site = console, journal, site
        self.control = Control()
        self._clearing = (-math.inf, "")
        self._pausing = Interval(PAUSE_AGAIN_S)
        self._stopping: Future[dict[str, Any]] | None = None
        """The newest emergency stop; pages that stop at the same time share it."""
        self.contained = Containment()
        self.examining = ExaminationRequests(console, journal, self._ask_to_pause, self.contained, reporting)
        self._writing: set[asyncio.Task[None]] = set()
        self._refusals: RateLimiters[str] = RateLimiters(_REFUSALS_PER_S, _REFUSALS_AT_ONCE)
        self._unrecorded: Counter[str] = Counter()
        self._verbs: dict[str, Act] = {
            "engage": self._engage,
            "disengage": self._disengage,
            "clutch": self._clutch,
            "scale": self._scale,
            "estop": self._stop,
            "clear_fault": self._clear,
            "acknowledge": self._acknowledge,
            **self.examining.verbs,
            "propose": self._propose,
            "take_control": self._take_control,
            "sound": self._sound,
            "quiet": self._quiet,
            VERB: self._camera_marks,
            "place": self._place,
        }
        self.plays = playing is not None
        """Whether a recording is shown. A dragged slider then sends many requests, and none acts on a site."""
        if playing is not None:
            self._verbs = {"place": self._place, "propose": self._propose, **playing}

    async def ask(self, client: Client, verb: object, details: object, now_s: float) -> Answer:
        """Record one request of a page, carry it out, and record and return the answer.

        An invalid request gets an answer. A request that cannot be recorded is not carried out. An emergency stop is
        carried out first and recorded afterwards.
        """
        given: dict[str, Any] = {}
        if isinstance(details, dict):
            given = {str(whole(str(name))): whole(value) for name, value in details.items()}
        record = {
            "at_s": now_s,
            "who": client.name,
            "verb": shown(verb if isinstance(verb, str) else type(verb).__name__),
            "details": recorded(given),
        }
        try:
            act = self._act(client, verb)
        except Refused as refused:
            self._refuse(client, record, str(refused))
            return Answer(False, str(refused))
        if self.plays or verb in _ONLY_LOOKS:
            return await self._do(act, client, verb, given, now_s)
        # An emergency stop does not wait for its record.
        if verb != "estop" and not self._record({**record, "ok": None, "answer": ""}):
            return Answer(False, texts.REQUEST_NOT_RECORDED)
        answer = await self._do(act, client, verb, given, now_s)
        self._record({**record, "ok": answer.ok, "answer": answer.text})
        log.info("%s: %s, %s", client.name, record["verb"], shown(answer.text, LONGEST_KEPT))
        return answer

    def _act(self, client: Client, verb: object) -> Act:
        """Return the function that carries out a verb.

        Raises:
            Refused: the verb is unknown, or this page may not use it.
        """
        act = self._verbs.get(verb) if isinstance(verb, str) else None
        if act is None:
            raise Refused(texts.UNKNOWN_REQUEST)
        if self.plays:
            return act
        if not client.acts and verb not in _ONLY_LOOKS:
            raise Refused(texts.OBSERVER.format(who=self.control.name))
        if self.control.holder is not client and verb not in _WITHOUT_CONTROL:
            raise Refused(texts.CONTROL_ELSEWHERE.format(who=self.control.name))
        return act

    def _refuse(self, client: Client, record: dict[str, Any], why: str) -> None:
        """Record a refusal within the rate limit, with the number of unrecorded refusals before it."""
        who = client.visitor.name
        if self.plays:
            return
        if not self._refusals.allows(who, record["at_s"]):
            self._unrecorded[who] += 1
            return
        record["details"] = {**record["details"], "refused_before": self._unrecorded.pop(who, 0)}
        self._record({**record, "ok": False, "answer": why})
        log.info("%s: %s, %s", client.name, record["verb"], why)

    def _record(self, record: dict[str, Any]) -> bool:
        """Write one record of an act to the journal; return False on failure."""
        try:
            self._journal.write("console/act", record["at_s"], record)
        except Exception as error:  # a stop is answered even if its record fails
            self.contained.caught("record of acts", error, latches=False)
            return False
        return True

    async def _do(self, act: Act, client: Client, verb: object, details: dict[str, Any], now_s: float) -> Answer:
        try:
            return await act(client, details, now_s)
        except Refused as refused:
            return Answer(False, str(refused))
        except (LocalControlSilent, TimeoutError):
            return Answer(False, texts.STOP_NOT_SENT if verb == "estop" else texts.SITE_SILENT)
        except Exception as error:
            self.contained.caught(f"act {shown(verb)}", error, latches=False)
            return Answer(False, texts.FAILED_INSIDE)

    def _ask(self, verb: str, details: dict[str, Any] | None = None) -> "Future[dict[str, Any]]":
        if self._site is None:
            raise Refused(texts.NO_SITE)
        return self._site.ask(verb, details)

    async def _answered(self, asked: "Future[dict[str, Any]]", now_s: float) -> None:
        """Wait for the site's answer to a request and show it on the console.

        Raises:
            TimeoutError: no answer in time.
        """
        waiting = asyncio.wrap_future(asked)
        answer: dict[str, Any] = await asyncio.wait_for(asyncio.shield(waiting), PATIENCE_S + 0.05)
        self.console.take_answer(now_s, answer)

    async def _engage(self, client: Client, details: dict[str, Any], now_s: float) -> Answer:
        if why := refusal(self.console):
            raise Refused(why)
        if self.console.site.state is LinkState.ENGAGED:
            return Answer(True, "ENGAGED")
        await self._answered(self._ask("engage"), now_s)
        return Answer(True, "ENGAGING")

    async def _ask_to_pause(self, now_s: float) -> None:
        await self._answered(self._ask("disengage"), now_s)

    async def _disengage(self, client: Client, details: dict[str, Any], now_s: float) -> Answer:
        await self._ask_to_pause(now_s)
        return Answer(True, texts.PAUSED)

    def pause(self, now_s: float, why: str) -> None:
        """Pause an engaged session on the console's own account, with the request of a page's Pause."""
        site = self.console.site
        if not (site.wanted or site.state is LinkState.ENGAGED) or not self._pausing(now_s):
            return
        pausing = asyncio.create_task(self._pause(now_s, why))
        self._writing.add(pausing)
        pausing.add_done_callback(self._writing.discard)

    async def _pause(self, now_s: float, why: str) -> None:
        record = {"at_s": now_s, "who": "console", "verb": "disengage", "details": {"why": why}}
        answer = Answer(False, texts.SITE_SILENT)
        with suppress(Refused, LocalControlSilent, TimeoutError):
            await self._ask_to_pause(now_s)
            answer = Answer(True, texts.PAUSED)
        self._record({**record, "ok": answer.ok, "answer": answer.text})
        log.info("console: disengage, %s, %s", why, answer.text)

    async def _clutch(self, client: Client, details: dict[str, Any], now_s: float) -> Answer:
        wanted = details.get("open")
        if not isinstance(wanted, bool):
            raise Refused(texts.CLUTCH_NEEDED)
        await self._answered(self._ask("clutch", {"open": wanted}), now_s)
        return Answer(True, texts.CLUTCH_OPEN if wanted else texts.CLUTCH_CLOSED)

    async def _scale(self, client: Client, details: dict[str, Any], now_s: float) -> Answer:
        scale = details.get("scale")
        if type(scale) is not int or scale not in MOTION_SCALES:
            raise Refused(texts.SCALE_NEEDED.format(scales=", ".join(f"1:{n}" for n in MOTION_SCALES)))
        await self._answered(self._ask("scale", {"scale": scale}), now_s)
        return Answer(True, texts.SCALE.format(scale=f"1:{scale}"))

    async def _stop(self, client: Client, details: dict[str, Any], now_s: float) -> Answer:
        if self._stopping is None or self._stopping.done():  # a pending stop is repeated already
            self._stopping = self._ask("estop")
        await self._answered(self._stopping, now_s)
        return Answer(True, "STOPPING")

    async def _clear(self, client: Client, details: dict[str, Any], now_s: float) -> Answer:
        site, alarms = self.console.site, self.console.alarms
        if site.state is LinkState.FAULT or site.remote_fault:
            await self._answered(self._ask("clear_fault"), now_s)
        elif not any(alarm.waits for alarm in alarms.listed):
            raise Refused(texts.NOTHING_TO_CLEAR)
        alarms.clear(now_s, client.name)
        self._clearing = now_s, client.name
        return Answer(True, texts.CLEAR_ASKED if site.remote_fault else texts.CLEARED)

    async def _acknowledge(self, client: Client, details: dict[str, Any], now_s: float) -> Answer:
        if not self.console.alarms.clear(now_s, client.name):
            raise Refused(texts.NOTHING_TO_ACKNOWLEDGE)
        return Answer(True, texts.ACKNOWLEDGED)

    def step(self, now_s: float) -> None:
        """Clear the alarm of a fault that was cleared in the last CLEARING_S; a remote site needs a moment longer."""
        asked_s, who = self._clearing
        if 0.0 <= now_s - asked_s <= CLEARING_S:
            self.console.alarms.clear(now_s, who, (FAULT, REMOTE_FAULT))

    async def _take_control(self, client: Client, details: dict[str, Any], now_s: float) -> Answer:
        if self.control.holder is client:
            return Answer(True, texts.IN_CONTROL)
        if self.console.site.state is LinkState.ENGAGED:
            raise Refused(texts.NOT_WHILE_ENGAGED)
        self.control.holder = client
        return Answer(True, texts.TOOK_CONTROL.format(who=client.name))

    async def _sound(self, client: Client, details: dict[str, Any], now_s: float) -> Answer:
        sound = details.get("answer")
        if sound not in ("heard", "refused"):
            raise Refused(texts.SOUND_ANSWER)
        self.console.around = replace(self.console.around, sound=sound)
        return Answer(True, texts.SOUND_WORKS if sound == "heard" else texts.SOUND_OFF)

    async def _quiet(self, client: Client, details: dict[str, Any], now_s: float) -> Answer:
        ident, seconds = str(details.get("alarm", "")), details.get("seconds", LONGEST_QUIET_S)
        if not within(seconds, 0.0, 1e9) or not self.console.alarms.quiet(now_s, ident, seconds):
            raise Refused(texts.SOUND_STAYS)
        return Answer(True, texts.SOUND_PAUSED.format(seconds=round(min(seconds, LONGEST_QUIET_S))))

    async def _camera_marks(self, client: Client, details: dict[str, Any], now_s: float) -> Answer:
        if not are_marks(details):
            raise Refused(texts.MARKS_NEEDED)
        return Answer(True, texts.MARKS_KEPT)

    async def _place(self, client: Client, details: dict[str, Any], now_s: float) -> Answer:
        return values_at(self.console.tactile_map, client.quantities[0], details, now_s)

    async def _propose(self, client: Client, details: dict[str, Any], now_s: float) -> Answer:
        console = self.console
        return propose_kind(console.tactile_map, details, console.tenderness if console.pain_agreed else None)
