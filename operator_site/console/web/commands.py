"""Carries out the requests of a page: checks permission, acts, answers, and records the request and its answer."""

import asyncio
import logging
import math
from collections import Counter
from collections.abc import Awaitable, Callable
from concurrent.futures import Future
from dataclasses import dataclass, replace
from datetime import datetime
from typing import Any, Protocol

from common.files.printable import one_line
from common.link.rate_limiter import RateLimiters
from common.link.session_state import Refused
from common.runtime.containment import Containment
from common.wire.packets import LinkState
from operator_site.console import texts
from operator_site.console.examination.examination import Finding
from operator_site.console.examination.findings import UNIT, value_text
from operator_site.console.examination.journal import Journal
from operator_site.console.examination.reporting import Reporting
from operator_site.console.local_control import PATIENCE_S, LocalControlSilent
from operator_site.console.model import Console
from operator_site.console.web.clients import Client
from operator_site.console.web.control import Control
from operator_site.console.web.page_state import refusal

log = logging.getLogger(__name__)

CLEARING_S = 2.0
"""Time after clearing a fault in which its alarm is cleared too, once both sites report the fault gone, s."""
WRITING_REPORT = "The report is being written."
SETTLE_S = 0.15
"""Longest wait of a request for the disk, s: half of the time for an answer."""
_LOOK_S = 0.005
"""Interval between two checks of the disk during that wait, s."""
STOP_NOT_SENT = "STOP NOT SENT. Use the hardware switch."
FAILED_INSIDE = "That failed inside the console; its log says why."
NOT_RECORDED = "That cannot be recorded. It was not done."
_OBSERVERS_MAY = frozenset(("place",))
_WITHOUT_CONTROL = frozenset(("place", "estop", "take_control"))
"""Requests that need no control; a page that may act may always stop."""
_REFUSALS_PER_S, _REFUSALS_AT_ONCE = 0.2, 10
"""Rate and burst of the refused requests of one visitor that are recorded and logged; others are only counted."""
_LONGEST_KEPT = 200
"""Maximum length of a detail in the record of acts, characters; the finding holds the full note."""


class SiteControl(Protocol):
    """Sends requests to the operator site."""

    def ask(self, verb: str, details: dict[str, Any] | None = None) -> "Future[dict[str, Any]]":
        """Send a request; the future holds the site's answer, see `LocalControlClient.ask`."""


class Playing(Protocol):
    """Playback of a recording."""

    def play(self, speed: float) -> None:
        """Play at a multiple of the recorded speed."""

    def pause(self) -> None:
        """Pause the playback."""

    def seek(self, at_s: float) -> bool:
        """Jump to a time, s from the beginning; return False if that part must be read first."""


@dataclass(frozen=True, slots=True)
class Answer:
    """Answer to a request of a page."""

    ok: bool
    text: str
    details: dict[str, Any] | None = None


Act = Callable[[Client, dict[str, Any], float], Awaitable[Answer]]
"""Carries out one verb for a page with its details at a time, s."""


class Commands:
    """Carries out the requests of pages. Time is an argument, s of the operator site's clock."""

    def __init__(
        self, console: Console, desk: SiteControl | None, journal: Journal, control: Control, player: Playing | None
    ):
        """Act on a running site through its desk, or on a recording through its player."""
        self._console, self._desk, self._journal = console, desk, journal
        self._control, self._player = control, player
        self.saved: dict[str, Any] | None = None
        """Summary of the last examination and the address of its report."""
        self._clearing = (-math.inf, "")
        self._stopping: Future[dict[str, Any]] | None = None
        """The newest emergency stop; pages that stop at the same time share it."""
        self.contained = Containment()
        self.reporting = Reporting((), None)
        self._writing: set[asyncio.Task[None]] = set()
        self._refusals: RateLimiters[str] = RateLimiters(_REFUSALS_PER_S, _REFUSALS_AT_ONCE)
        self._unrecorded: Counter[str] = Counter()
        self._verbs: dict[str, Act] = {
            "engage": self._engage,
            "disengage": self._disengage,
            "estop": self._stop,
            "clear_fault": self._clear,
            "begin": self._begin,
            "end": self._end,
            "finding": self._find,
            "note": self._note,
            "take_control": self._take_control,
            "sound": self._sound,
            "quiet": self._quiet,
            "place": self._place,
        }
        if player is not None:
            self._verbs = {"place": self._place, "play": self._play, "pause": self._pause, "seek": self._seek}

    @property
    def plays(self) -> bool:
        """Whether a recording is shown, where a dragged slider sends many requests and nothing acts on a site."""
        return self._player is not None

    def show(self, console: Console) -> None:
        """Act on another console from now on, after a jump in a recording."""
        self._console = console

    async def ask(self, client: Client, verb: object, details: object, now_s: float) -> Answer:
        """Record one request of a page, carry it out, and record and return the answer.

        An invalid request gets an answer. A request that cannot be recorded is not carried out. An emergency stop is
        carried out first and recorded afterwards.
        """
        given: dict[str, Any] = {}
        if isinstance(details, dict):
            given = {str(_whole(str(name))): _whole(value) for name, value in details.items()}
        record = {
            "at_s": now_s,
            "who": client.name,
            "verb": _shown(verb if isinstance(verb, str) else type(verb).__name__),
            "details": _recorded(given),
        }
        try:
            act = self._act(client, verb)
        except Refused as refused:
            self._refuse(client, record, str(refused))
            return Answer(False, str(refused))
        if self._player is not None or verb == "place":
            return await self._do(act, client, verb, given, now_s)
        # An emergency stop does not wait for its record.
        if verb != "estop" and not self._record({**record, "ok": None, "answer": ""}):
            return Answer(False, NOT_RECORDED)
        answer = await self._do(act, client, verb, given, now_s)
        self._record({**record, "ok": answer.ok, "answer": answer.text})
        log.info("%s: %s, %s", client.name, record["verb"], _shown(answer.text, _LONGEST_KEPT))
        return answer

    def _act(self, client: Client, verb: object) -> Act:
        """Return the function that carries out a verb.

        Raises:
            Refused: the verb is unknown, or this page may not use it.
        """
        act = self._verbs.get(verb) if isinstance(verb, str) else None
        if act is None:
            raise Refused("That cannot be asked for here.")
        if self._player is not None:
            return act
        if not client.acts and verb not in _OBSERVERS_MAY:
            raise Refused(texts.OBSERVER.format(who=self._control.name))
        if self._control.holder is not client and verb not in _WITHOUT_CONTROL:
            raise Refused(f"Control is at {self._control.name}. Take control first.")
        return act

    def _refuse(self, client: Client, record: dict[str, Any], why: str) -> None:
        """Record a refusal within the rate limit, with the number of unrecorded refusals before it."""
        who = client.visitor.name
        if self._player is not None:
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
            return Answer(False, STOP_NOT_SENT if verb == "estop" else "The operator site does not answer.")
        except Exception as error:
            self.contained.caught(f"act {_shown(verb)}", error, latches=False)
            return Answer(False, FAILED_INSIDE)

    async def _ask_desk(self, verb: str, now_s: float, details: dict[str, Any] | None = None) -> dict[str, Any]:
        if self._desk is None:
            raise Refused("There is no operator site.")
        return await self._heard(self._desk.ask(verb, details), now_s)

    async def _heard(self, asked: "Future[dict[str, Any]]", now_s: float) -> dict[str, Any]:
        """Wait for the desk's answer to a request and show it on the console.

        Raises:
            TimeoutError: no answer in time.
        """
        waiting = asyncio.wrap_future(asked)
        answer: dict[str, Any] = await asyncio.wait_for(asyncio.shield(waiting), PATIENCE_S + 0.05)
        self._console.desk(now_s, answer)
        return answer

    async def _engage(self, client: Client, details: dict[str, Any], now_s: float) -> Answer:
        if why := refusal(self._console):
            raise Refused(why)
        if self._console.site.state is LinkState.ENGAGED:
            return Answer(True, "ENGAGED")
        await self._ask_desk("engage", now_s)
        return Answer(True, "ENGAGING")

    async def _disengage(self, client: Client, details: dict[str, Any], now_s: float) -> Answer:
        await self._ask_desk("disengage", now_s)
        return Answer(True, "PAUSED. Outputs neutral.")

    async def _stop(self, client: Client, details: dict[str, Any], now_s: float) -> Answer:
        if self._desk is None:
            raise Refused("There is no operator site.")
        if self._stopping is None or self._stopping.done():  # a pending stop is repeated already
            self._stopping = self._desk.ask("estop")
        await self._heard(self._stopping, now_s)
        return Answer(True, "STOPPING")

    async def _clear(self, client: Client, details: dict[str, Any], now_s: float) -> Answer:
        site, alarms = self._console.site, self._console.alarms
        if site.state is LinkState.FAULT or site.remote_fault:
            answer = await self._ask_desk("clear_fault", now_s)
            if answer.get("refusal"):
                raise Refused(f"Not cleared: {answer['refusal']}.")
        elif not any(alarm.waits for alarm in alarms.listed):
            raise Refused("There is nothing to clear.")
        self._clearing = now_s, client.name
        self.step(now_s)
        return Answer(True, "Cleared. Nothing moves. Engage again.")

    def step(self, now_s: float) -> None:
        """Clear the alarms of a fault that was cleared in the last CLEARING_S; a remote site needs a moment longer."""
        asked_s, who = self._clearing
        if 0.0 <= now_s - asked_s <= CLEARING_S:
            self._console.alarms.clear(now_s, who)

    async def _begin(self, client: Client, details: dict[str, Any], now_s: float) -> Answer:
        examination = self._console.examination
        examination.begin(now_s, details.get("pseudonym"), details.get("sides"))
        self._console.begin_anew()
        self._journal.forget()
        self.saved = None
        self._write_session("begin", client, str(examination.pseudonym), now_s)
        return Answer(True, f"Session {examination.pseudonym}.")

    async def _end(self, client: Client, details: dict[str, Any], now_s: float) -> Answer:
        examination, site = self._console.examination, self._console.site
        if site.state is LinkState.ENGAGED:
            await self._ask_desk("disengage", now_s)
        await self._settle(now_s)
        began_s, pseudonym = examination.began_s or now_s, examination.end(now_s)
        self._write_session("end", client, pseudonym, now_s)
        unsaved = [finding for finding in examination.findings if not self._journal.is_saved(finding)]
        lost = int(site.figures.get("recording_lost", 0))
        text = texts.saved(now_s - began_s, len(examination.findings), lost)
        if unsaved:
            text = f"{texts.count(len(unsaved), 'finding')} not yet on disk."
        elif not self._console.recording:
            text = (
                f"Not recorded: {texts.duration(now_s - began_s)}, {texts.count(len(examination.findings), 'finding')}."
            )
        placeless = sum(finding.x_m is None for finding in examination.findings.values())
        if placeless:
            text += f" Report has {texts.count(placeless, 'finding')} without a place."
        self.saved = {"text": f"{text} {WRITING_REPORT}", "report": None}
        writing = asyncio.create_task(self._write_report(self.saved, text, pseudonym))
        self._writing.add(writing)
        writing.add_done_callback(self._writing.discard)
        return Answer(True, text)

    async def _write_report(self, saved: dict[str, Any], text: str, pseudonym: str) -> None:
        """Write the report and put its address, or the failure, into the summary of the examination."""
        try:
            saved.update(report=await self.reporting.write(pseudonym, self._journal.files), text=text)
        except OSError as error:
            log.warning("report of %s: %s", pseudonym, _shown(error, _LONGEST_KEPT))
            saved["text"] = f"{text} No report: {_shown(error, _LONGEST_KEPT)}."
        except Exception as error:
            saved["text"] = f"{text} No report: {self.contained.caught('report', error, latches=False)}."

    async def _find(self, client: Client, details: dict[str, Any], now_s: float) -> Answer:
        finding = self._console.examination.find(self._console.tactile_map, details, now_s)
        await self._keep(finding, now_s)
        saved = self._journal.is_saved(finding.ident)
        kept = f"saved: {finding.text}." if saved else "kept here, not yet on disk."
        return Answer(True, f"Finding {finding.ident} {kept}", {"id": finding.ident, "saved": saved})

    async def _note(self, client: Client, details: dict[str, Any], now_s: float) -> Answer:
        finding = self._console.examination.note(details.get("finding"), details.get("text"))
        await self._keep(finding, now_s)
        saved = self._journal.is_saved(finding.ident)
        kept = "saved." if saved else "kept here, not yet on disk."
        return Answer(True, f"Note to finding {finding.ident} {kept}", {"id": finding.ident, "saved": saved})

    async def _keep(self, finding: Finding, now_s: float) -> None:
        """Write a finding and wait for the disk."""
        self._journal.write("console/finding", now_s, finding.record())
        await self._settle(now_s)

    async def _settle(self, now_s: float) -> None:
        """Wait until the disk has all records, at most SETTLE_S; the state shows records that are saved later."""
        clock = asyncio.get_running_loop().time
        until_s = clock() + SETTLE_S
        while self._journal.unsaved and not self._journal.failed and clock() < until_s:
            await asyncio.sleep(_LOOK_S)
            self._journal.step(now_s)

    async def _take_control(self, client: Client, details: dict[str, Any], now_s: float) -> Answer:
        if self._control.holder is client:
            return Answer(True, "You are in control.")
        if self._console.site.state is LinkState.ENGAGED:
            raise Refused("Not while engaged. Pause first.")
        self._control.holder = client
        return Answer(True, f"{client.name} took control.")

    async def _sound(self, client: Client, details: dict[str, Any], now_s: float) -> Answer:
        said = details.get("answer")
        if said not in ("heard", "refused"):
            raise Refused("Sound is heard or refused.")
        self._console.around = replace(self._console.around, sound=said)
        return Answer(True, "Sound works." if said == "heard" else "Sound is off. Watch the alarm line.")

    async def _quiet(self, client: Client, details: dict[str, Any], now_s: float) -> Answer:
        seconds = details.get("seconds", 60.0)
        if not isinstance(seconds, (int, float)) or not self._console.alarms.quiet(
            now_s, str(details.get("alarm", "")), float(seconds)
        ):
            raise Refused("This alarm's sound cannot be paused.")
        return Answer(True, f"Sound paused {min(60, round(float(seconds)))} s.")

    async def _place(self, client: Client, details: dict[str, Any], now_s: float) -> Answer:
        x_mm, y_mm = details.get("x_mm"), details.get("y_mm")
        if not isinstance(x_mm, (int, float)) or not isinstance(y_mm, (int, float)):
            raise Refused("A place has x_mm and y_mm.")
        here = self._console.tactile_map.at(x_mm / 1000.0, y_mm / 1000.0)
        measured = {name: found for name in UNIT if (found := getattr(here, name)) is not None}
        shown_texts: dict[str, Any] = {name: value_text(name, found) for name, found in measured.items()}
        if here.material is not None:
            shown_texts["material"] = f"{texts.named(here.material[0])} {texts.percent(here.material[1])}"
        shown = measured.get(client.quantity) or next(iter(measured.values()), None)
        if shown is None:
            return Answer(True, texts.NOTHING_HERE, {"text": texts.NOTHING_HERE, **shown_texts})
        name = next(name for name, found in measured.items() if found is shown)
        touches = texts.count(shown.touches, "touch") if shown.touches == 1 else f"{shown.touches} touches"
        text = f"{shown_texts[name]}, {touches}, {max(0.0, now_s - shown.last_s):.0f} s ago"
        return Answer(True, text, {"text": text, **shown_texts})

    async def _play(self, client: Client, details: dict[str, Any], now_s: float) -> Answer:
        speed = details.get("speed", 1.0)
        if not isinstance(speed, (int, float)) or not abs(speed) < 1e9:
            raise Refused("play has a speed.")
        self._played.play(min(max(float(speed), 0.5), 8.0))
        return Answer(True, "")

    async def _pause(self, client: Client, details: dict[str, Any], now_s: float) -> Answer:
        self._played.pause()
        return Answer(True, "Paused.")

    async def _seek(self, client: Client, details: dict[str, Any], now_s: float) -> Answer:
        at_s = details.get("at_s")
        if not isinstance(at_s, (int, float)) or not abs(at_s) < 1e9:
            raise Refused("seek has a time in s.")
        return Answer(True, "" if self._played.seek(max(0.0, float(at_s))) else "Reading ahead.")

    @property
    def _played(self) -> Playing:
        assert self._player is not None
        return self._player

    def _write_session(self, what: str, client: Client, pseudonym: str, now_s: float) -> None:
        record = {
            "what": what,
            "at_s": now_s,
            "pseudonym": pseudonym,
            "wall_clock": datetime.now().astimezone().isoformat(timespec="seconds"),
            "who": client.name,
            "sides": self._console.examination.sides,
        }
        self._journal.write("console/session", now_s, record)


def _whole(value: object) -> object:
    """Replace unpaired surrogates in a text, which no file and no socket accepts; return other values unchanged."""
    return value.encode("utf-16", "surrogatepass").decode("utf-16", "replace") if isinstance(value, str) else value


def _shown(text: object, longest: int = 40) -> str:
    """Return a text for record and log: one line of printable characters."""
    return one_line(str(text), longest)


def _recorded(details: dict[Any, Any]) -> dict[str, object]:
    """Return details for the record: at most 20, each short."""
    return {str(name)[:40]: _plain(value) for name, value in list(details.items())[:20]}


def _plain(value: object) -> object:
    """Return a detail for the record."""
    if value is None or isinstance(value, (bool, float)) or (isinstance(value, int) and abs(value) < 2**63):
        return value
    if isinstance(value, str):
        return value[:_LONGEST_KEPT]
    try:
        return str(_whole(str(value)[:_LONGEST_KEPT]))
    except (RecursionError, ValueError):  # nested too deeply, or an integer with too many digits
        return f"a {type(value).__name__}"
