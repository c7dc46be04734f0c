"""Carries out the requests of pages about an examination: begin and end it, and keep its findings."""

import asyncio
import logging
from collections.abc import Awaitable, Callable
from dataclasses import replace
from datetime import datetime
from typing import Any

from common.link.session_state import Refused
from common.runtime.containment import Containment
from common.wire.packets import LinkState
from operator_site.console import texts
from operator_site.console.examination.examination import Finding
from operator_site.console.examination.findings import TENDER
from operator_site.console.examination.journal import Journal
from operator_site.console.examination.reporting import Reporting
from operator_site.console.local_control import LocalControlSilent
from operator_site.console.model import Console
from operator_site.console.web.answer import Act, Answer
from operator_site.console.web.clients import Client
from operator_site.console.web.request_record import LONGEST_KEPT, shown

log = logging.getLogger(__name__)

SETTLE_S = 0.15
"""Longest wait of a request for the disk, s: half of the time for an answer."""
_LOOK_S = 0.005
"""Interval between two checks of the disk during that wait, s."""


class ExaminationRequests:
    """Requests of pages about an examination. Time is an argument, s of the operator site's clock.

    Attributes:
        verbs: what carries each request out.
        saved: summary of the last examination and the address of its report; None before its end.
        reporting: writes the report.
    """

    def __init__(
        self,
        console: Console,
        journal: Journal,
        disengage: Callable[[float], Awaitable[object]],
        contained: Containment,
        reporting: Reporting | None = None,
    ):
        """Keep the examination of a console in a journal; `disengage` pauses the session before it ends."""
        self.console, self._journal, self._disengage, self._contained = console, journal, disengage, contained
        self.reporting = Reporting((), None) if reporting is None else reporting
        self.saved: dict[str, Any] | None = None
        self._lost_before = 0
        """Number of messages that the site's recording had lost when the examination began."""
        self._writing: set[asyncio.Task[None]] = set()
        self.verbs: dict[str, Act] = {
            "begin": self._begin,
            "end": self._end,
            "finding": self._find,
            "note": self._note,
            "edit": self._edit,
            "withdraw": self._withdraw,
            "undo": self._undo,
        }

    async def _begin(self, client: Client, details: dict[str, Any], now_s: float) -> Answer:
        examination = self.console.examination
        consent = self.console.consent
        if self.console.recording and consent.forbids("touch"):
            raise Refused(texts.TOUCH_NOT_AGREED)
        if consent.agreed and details.get("consent") is not True:
            raise Refused(texts.ASK_CONSENT)
        examination.begin(now_s, details.get("pseudonym"), details.get("sides"), details.get("body"))
        self.console.begin_map()
        self._journal.forget()
        self.saved, self._lost_before = None, self._lost
        self._write_session("begin", client, str(examination.pseudonym), now_s)
        return Answer(True, texts.SESSION.format(pseudonym=examination.pseudonym))

    async def _end(self, client: Client, details: dict[str, Any], now_s: float) -> Answer:
        examination, site, warning = self.console.examination, self.console.site, ""
        if site.state is LinkState.ENGAGED:
            try:
                await self._disengage(now_s)
            except (LocalControlSilent, TimeoutError):  # a lost site must not hold back the report
                warning = f"{texts.MAY_BE_ENGAGED} "
        await self._settle(now_s)
        began_s, pseudonym = examination.began_s or now_s, examination.end(now_s)
        self._write_session("end", client, pseudonym, now_s)
        findings = examination.findings.values()
        text = texts.ended(
            now_s - began_s,
            len(findings),
            max(0, self._lost - self._lost_before),
            recorded=self.console.recording,
            unsaved=sum(not self._journal.is_saved(finding) for finding in examination.findings),
            placeless=sum(finding.x_m is None and not finding.withdrawn for finding in findings),
            withdrawn=sum(bool(finding.withdrawn) for finding in findings),
        )
        self.saved = {"text": f"{text} {texts.WRITING_REPORT}", "report": None}
        writing = asyncio.create_task(self._write_report(self.saved, text, pseudonym))
        self._writing.add(writing)
        writing.add_done_callback(self._writing.discard)
        return Answer(True, f"{warning}{text}")

    @property
    def _lost(self) -> int:
        """Number of messages that the site's recording has lost since the site's start."""
        return int(self.console.site.figures.get("recording_lost", 0))

    async def _write_report(self, saved: dict[str, Any], text: str, pseudonym: str) -> None:
        """Write the report and put its address, or the failure, into the summary of the examination."""
        try:
            saved.update(report=await self.reporting.write(pseudonym, self._journal.files), text=text)
        except OSError as error:
            log.warning("report of %s: %s", pseudonym, shown(error, LONGEST_KEPT))
            saved["text"] = f"{text} {texts.NO_REPORT.format(why=shown(error, LONGEST_KEPT))}"
        except Exception as error:
            why = self._contained.caught("report", error, latches=False)
            saved["text"] = f"{text} {texts.NO_REPORT.format(why=why)}"

    async def _find(self, client: Client, details: dict[str, Any], now_s: float) -> Answer:
        self._check_consent(details)
        console = self.console
        if (marked := console.examination.marked(details)) is not None:
            chosen = {name: value for name, value in details.items() if name != "kind" or value is not None}
            return await self._change({**chosen, "finding": marked.ident}, now_s, texts.FINDING)
        finding = console.examination.find(console.tactile_map, details, now_s, console.tenderness)
        return await self._keep(finding, now_s, texts.FINDING, f"saved: {finding.text}.")

    def _check_consent(self, details: dict[str, Any]) -> None:
        """Refuse a finding of pain without the patient's consent to record it.

        Raises:
            Refused: it is one, and a site has noted no consent.
        """
        if details.get("kind") == TENDER and not self.console.pain_agreed:
            raise Refused(texts.PAIN_NOT_AGREED)

    async def _note(self, client: Client, details: dict[str, Any], now_s: float) -> Answer:
        finding, text = self.console.examination.standing(details.get("finding")), details.get("text")
        if text == finding.note:  # sent twice, by a double click or after a lost answer
            kept = await self._kept(finding, now_s, texts.NOTE, "saved.")
        else:
            kept = await self._keep(self.console.examination.note(finding.ident, text), now_s, texts.NOTE, "saved.")
        ended = self.console.examination.pseudonym is None
        return replace(kept, text=f"{kept.text} {texts.NOTE_AFTER_END}") if ended else kept

    async def _edit(self, client: Client, details: dict[str, Any], now_s: float) -> Answer:
        self._check_consent(details)
        return await self._change(details, now_s, texts.EDITED)

    async def _change(self, details: dict[str, Any], now_s: float, unchanged: str) -> Answer:
        """Edit a finding; answer with the text `unchanged` where the details are as before, such as if sent twice."""
        before = self.console.examination.standing(details.get("finding"))
        finding = self.console.examination.edit(self.console.tactile_map, details, self.console.tenderness)
        if finding is before:
            return await self._kept(finding, now_s, unchanged, f"saved: {finding.text}.")
        return await self._keep(finding, now_s, texts.EDITED, f"saved: {finding.text}.")

    async def _withdraw(self, client: Client, details: dict[str, Any], now_s: float) -> Answer:
        finding = self.console.examination.withdraw(details.get("finding"), details.get("reason"))
        return await self._keep(finding, now_s, texts.WITHDRAWN, "saved.")

    async def _undo(self, client: Client, details: dict[str, Any], now_s: float) -> Answer:
        examination = self.console.examination
        if (undone := examination.undone(details)) is not None:
            return await self._kept(undone, now_s, texts.UNDONE, f"saved: {undone.text}.")
        finding = examination.undo(details)
        return await self._keep(finding, now_s, texts.UNDONE, f"saved: {finding.text}.")

    async def _keep(self, finding: Finding, now_s: float, text: str, on_disk: str) -> Answer:
        """Write a finding, and answer whether the disk has it."""
        self._journal.write("console/finding", now_s, finding.record())
        return await self._kept(finding, now_s, text, on_disk)

    async def _kept(self, finding: Finding, now_s: float, text: str, on_disk: str) -> Answer:
        """Wait for the disk, and answer whether it has a finding."""
        await self._settle(now_s)
        saved = self._journal.is_saved(finding.ident)
        answer = text.format(number=finding.ident, kept=on_disk if saved else texts.NOT_ON_DISK)
        return Answer(True, answer, {"id": finding.ident, "saved": saved})

    async def _settle(self, now_s: float) -> None:
        """Wait until the disk has all records, at most SETTLE_S; the state shows records that are saved later."""
        clock = asyncio.get_running_loop().time
        until_s = clock() + SETTLE_S
        while self._journal.unsaved and not self._journal.failed and clock() < until_s:
            await asyncio.sleep(_LOOK_S)
            self._journal.step(now_s)

    def _write_session(self, what: str, client: Client, pseudonym: str, now_s: float) -> None:
        examination = self.console.examination
        record = {
            "what": what,
            "at_s": now_s,
            "pseudonym": pseudonym,
            "wall_clock": datetime.now().astimezone().isoformat(timespec="seconds"),
            "who": client.name,
            "sides": examination.sides,
            "body": None if examination.body is None else examination.body.record(),
            "consented": self.console.consent.agreed or (),
        }
        self._journal.write("console/session", now_s, record)
