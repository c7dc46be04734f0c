"""Requests at the console: each is answered and recorded, and carried out only for a page that may act."""

import asyncio
import math
import re
from collections.abc import Sequence
from concurrent.futures import Future
from itertools import product
from pathlib import Path
from typing import Any

import pytest

from common.faults.fault import Fault, FaultCode
from common.faults.texts import fault_figures
from common.link.session_state import Refused
from common.web.access import Visitor
from operator_site.console import texts
from operator_site.console.alarms.alarms import Cause
from operator_site.console.examination.examination import LONGEST_NOTE
from operator_site.console.examination.reporting import Reporting
from operator_site.console.local_control import LocalControlSilent
from operator_site.console.model import Console
from operator_site.console.state.frame import Priority
from operator_site.console.texts import NOTE_AFTER_END
from operator_site.console.web.answer import Answer
from operator_site.console.web.clients import Client
from operator_site.console.web.commands import Commands
from operator_site.console.web.page_state import checks
from teletaction.report.pictures.covered_picture import marked_places
from tests.conftest import PROTOCOLS, Contained
from tests.unit.operator_site.console.fed import S, fed, figures, happen
from tests.unit.operator_site.console.page_room import BRIEF, AnsweringSite, MemoryJournal
from tests.unit.operator_site.console.touch_rows import sample


class Workplace:
    """A console with two pages that may act and one that may not."""

    def __init__(self) -> None:
        self.console, self.site, self.journal = Console(), AnsweringSite(), MemoryJournal()
        self.commands = Commands(self.console, self.journal, self.site)
        self.control = self.commands.control
        self.first, self.second = (Client(Visitor("OR-1", "act"), f"OR-1 {n}", 0.0) for n in (1, 2))
        self.observer = Client(Visitor("student", "observe"), "student 3", 0.0)
        for client in (self.observer, self.first, self.second):
            self.control.offer(client)
        happen(self.console, 98.0, "connected")
        fed(self.console, 98.0, 101.0)
        self.console.take_answer(101.0, BRIEF)
        happen(self.console, 101.0, "disengaged")

    def ask(self, verb: object, client: Client | None = None, **details: Any) -> Answer:
        return asyncio.run(self.commands.ask(client or self.first, verb, details, 101.0))

    @property
    def kept_acts(self) -> list[dict[str, Any]]:
        return self.journal.of("console/act")

    @property
    def kept(self) -> list[tuple[str, bool | None]]:
        """Verb and success of the acts that were kept; one before it is done has no success."""
        return [(act["verb"], act["ok"]) for act in self.kept_acts]


@pytest.fixture
def workplace() -> Workplace:
    return Workplace()


def test_the_first_page_that_may_act_is_in_control(workplace: Workplace) -> None:
    assert workplace.control.holder is workplace.first
    workplace.control.left(workplace.first, [workplace.observer, workplace.second])
    assert workplace.control.holder is workplace.second
    workplace.control.left(workplace.second, [workplace.observer])
    assert workplace.control.holder is None


ACTS = ("engage", "disengage", "clear_fault", "begin", "end", "finding", "note", "edit", "withdraw", "undo")
ACTS += ("clutch", "scale", "camera_marks")


@pytest.mark.parametrize("verb", ACTS)
def test_a_page_that_is_not_in_control_is_refused(workplace: Workplace, verb: str) -> None:
    assert workplace.ask(verb, workplace.second) == Answer(False, "Control is at OR-1 1. Take control first.")
    assert workplace.site.asked == []


@pytest.mark.parametrize("verb", [*ACTS, "estop"])
def test_an_observer_is_refused_and_nothing_is_asked_of_the_site(workplace: Workplace, verb: str) -> None:
    answer = workplace.ask(verb, workplace.observer)
    assert (answer.ok, answer.text) == (False, "OBSERVER. Control is at OR-1 1.")
    assert workplace.site.asked == []
    assert [act["who"] for act in workplace.kept_acts] == ["student 3"]


def test_a_finding_of_pain_needs_the_patients_consent(workplace: Workplace) -> None:
    assert workplace.ask("begin", pseudonym="P-0417").ok
    place = {"finger": "index", "x_mm": 10.0, "y_mm": 20.0}
    for agreed in (None, False):
        if agreed is not None:
            workplace.console.take_answer(101.0, BRIEF | {"pain": 0.0, "pain_agreed": agreed})
        refused = workplace.ask("finding", kind="tender", **place)
        assert (refused.ok, refused.text) == (False, "The patient has not agreed to have pain recorded.")
    workplace.console.take_answer(101.0, BRIEF | {"pain": 0.0, "pain_agreed": True})
    proposed = workplace.ask("propose", x_mm=10.0, y_mm=20.0)
    assert proposed.details is not None
    assert "tender" in proposed.details["kinds"]
    assert workplace.ask("finding", kind="tender", **place).ok
    (kept,) = workplace.journal.of("console/finding")
    assert (kept["text"], kept["compare"]) == ("tender", "most tender not known yet; pain from not known yet")
    workplace.console.take_answer(101.0, BRIEF | {"pain": 0.0, "pain_agreed": False})
    assert workplace.ask("edit", finding=1, kind="tender").text == "The patient has not agreed to have pain recorded."
    workplace.console.take_answer(101.0, BRIEF | {"pain": 0.0, "pain_agreed": True})
    workplace.console.noted = ("touch",)
    assert not workplace.ask("edit", finding=1, kind="tender").ok, "the answer noted at this site counts as well"


def test_a_finding_is_proposed_edited_withdrawn_and_brought_back(workplace: Workplace) -> None:
    body = {"region": "palm", "side": "left", "landmark": "", "landmark_mm": None}
    assert workplace.ask("begin", pseudonym="P-0417", body=body).ok
    (begun,) = workplace.journal.of("console/session")
    assert begun["body"] == body
    proposed = workplace.ask("propose", workplace.observer, x_mm=10.0, y_mm=20.0)
    assert proposed.ok
    assert proposed.details is not None
    assert {*proposed.details["kinds"]} == {"rough", "warm", "cold", "stiff", "soft"}
    assert workplace.ask("finding", finger="index", kind="warm", x_mm=10.0, y_mm=20.0).ok
    for verb, details in (("edit", {"kind": "cold"}), ("withdraw", {"reason": "an edge"})):
        assert workplace.ask(verb, finding=1, **details).text.endswith("of finding 1 kept here, not yet on disk.")
    assert workplace.ask("undo").text == "Undo for finding 1 kept here, not yet on disk."
    kept = workplace.journal.of("console/finding")
    assert [(record["change"], record["kind"], record["withdrawn"]) for record in kept] == [
        ("mark", "warm", ""),
        ("edit", "cold", ""),
        ("withdraw", "cold", "an edge"),
        ("undo", "cold", ""),
    ]
    assert "propose" not in {act["verb"] for act in workplace.kept_acts}
    assert not workplace.ask("propose", x_mm="here").ok


def test_engaging_waits_until_sound_was_answered(workplace: Workplace) -> None:
    assert workplace.ask("engage").text == "Cannot engage: sound not checked."
    assert not workplace.ask("sound", answer="what").ok
    assert workplace.ask("sound", answer="heard").ok
    assert workplace.ask("engage").text == "ENGAGING"
    assert workplace.site.asked == ["engage"]


@pytest.mark.parametrize("old", ["the link is too slow: a round trip of 400 ms", "the remote site ends it"])
def test_an_old_refusal_of_the_remote_site_stops_neither_engaging_nor_clearing(workplace: Workplace, old: str) -> None:
    workplace.ask("sound", answer="heard")
    workplace.site.answer = lambda: BRIEF | {"refusal": old}
    workplace.console.take_answer(101.0, workplace.site.answer())
    assert workplace.ask("engage").text == "ENGAGING"
    happen(workplace.console, 101.0, "fault", fault=Fault(FaultCode.FORCE_SWINGS, "index", value=1.2, rate_hz=23.0))
    assert workplace.ask("clear_fault").text == "Cleared. Nothing moves. Engage again."
    assert workplace.site.asked == ["engage", "clear_fault"]


@pytest.mark.parametrize(
    ("verb", "fails", "text"),
    [
        ("engage", Refused("a fault is latched"), "a fault is latched"),
        ("estop", LocalControlSilent("nobody"), texts.STOP_NOT_SENT),
        ("disengage", LocalControlSilent("nobody"), texts.SITE_SILENT),
    ],
)
def test_why_the_site_did_not_do_it_is_answered(workplace: Workplace, verb: str, fails: Exception, text: str) -> None:
    workplace.ask("sound", answer="refused")
    workplace.site.fails = fails
    assert workplace.ask(verb) == Answer(False, text)


def test_who_is_not_in_control_may_stop_and_take_over_but_nothing_else(workplace: Workplace) -> None:
    assert workplace.ask("disengage", workplace.second).text == "Control is at OR-1 1. Take control first."
    assert workplace.ask("estop", workplace.second).ok
    assert workplace.ask("take_control", workplace.second).text == "OR-1 2 took control."
    assert workplace.ask("disengage", workplace.first).text.startswith("Control is at OR-1 2.")
    happen(workplace.console, 102.0, "engaged")
    assert workplace.ask("take_control", workplace.first).text == "Not while engaged. Pause first."


def test_a_session_has_a_study_number_and_ends_with_what_was_kept(workplace: Workplace) -> None:
    assert workplace.ask("begin", pseudonym="Anna Meier").text == "Use a study number, not a name."
    assert not workplace.ask("finding", finger="index").ok
    assert workplace.ask("begin", pseudonym="P-0417", sides={"top": "head", "right": "left"}).ok
    assert workplace.ask("begin", pseudonym="P-0418").text == "Examination P-0417 is under way. End it first."
    assert workplace.ask("finding", finger="index", kind="warm", at_s=101.0).ok
    ended = workplace.ask("end")
    assert ended.text == "1 finding not yet on disk. Report has 1 finding without a place."
    assert workplace.ask("end").text == "No examination is under way."
    assert [record["what"] for record in workplace.journal.of("console/session")] == ["begin", "end"]


def test_an_examination_counts_the_messages_that_were_lost_in_it(workplace: Workplace) -> None:
    figures = workplace.console.site.figures
    figures["recording_lost"] = 7
    workplace.ask("begin", pseudonym="P-0418")
    figures.update(recording_lost=9, recorded=True)
    assert "2 messages lost" in workplace.ask("end").text


def test_a_note_after_the_end_says_that_the_report_may_lack_it(workplace: Workplace) -> None:
    assert workplace.ask("begin", pseudonym="P-0417").ok
    assert workplace.ask("finding", finger="index", kind="warm", at_s=101.0).ok
    assert not workplace.ask("note", finding=1, text="a").text.endswith(NOTE_AFTER_END)
    assert workplace.ask("end").ok
    noted = workplace.ask("note", finding=1, text="a, and more")
    assert noted.ok
    assert noted.text.endswith(NOTE_AFTER_END)


def test_an_examination_ends_although_the_site_was_lost_while_it_was_engaged(workplace: Workplace) -> None:
    assert workplace.ask("begin", pseudonym="P-0417").ok
    happen(workplace.console, 101.0, "engaged")
    workplace.site.fails = LocalControlSilent("nobody")
    ended = workplace.ask("end")
    assert ended.ok
    assert ended.text.startswith("The operator site does not answer. It may be engaged: press STOP.")
    assert workplace.site.asked == ["disengage"]
    assert workplace.console.examination.pseudonym is None


def test_what_is_recorded_is_confirmed_by_the_patient_before_the_examination(workplace: Workplace) -> None:
    workplace.console.noted = ("touch", "picture")
    refused = workplace.ask("begin", pseudonym="P-0417")
    assert refused.text == "Ask the patient about the recording, then tick the answer."
    assert not workplace.ask("begin", pseudonym="P-0417", consent="yes").ok
    assert workplace.journal.of("console/session") == []
    assert workplace.ask("begin", pseudonym="P-0417", consent=True).ok
    (begun,) = workplace.journal.of("console/session")
    assert begun["consented"] == ("touch", "picture")


def test_the_remote_sites_answer_counts_where_it_is_stricter(workplace: Workplace) -> None:
    console = workplace.console
    console.noted = ("touch", "pain", "picture")
    assert not console.consent.allows("picture"), "the remote site's answer is not known yet"
    console.take("operator/figures", 101 * S, figures(remote_consent={}))
    assert console.consent.agreed == console.noted, "no answer does not restrict"
    assert "No answer noted at the remote site." in consent_check(console)
    console.take("operator/figures", 101 * S, figures(remote_consent={"consented": ["pain", "touch"]}))
    assert (console.consent.agreed, console.consent.allows("picture")) == (("touch", "pain"), False)
    assert consent_check(console) == (
        "Patient's answers differ: here touch, pain, picture; remote touch, pain. Counts: touch, pain."
    )
    assert workplace.ask("begin", pseudonym="P-0417", consent=True).ok
    (begun,) = workplace.journal.of("console/session")
    assert begun["consented"] == ("touch", "pain")
    console.take("operator/figures", 101 * S, figures(remote_consent={"consented": ["picture", "touch", "pain"]}))
    assert consent_check(console) == ""


def test_nobody_begins_while_touch_is_recorded_against_the_patients_answer(workplace: Workplace) -> None:
    workplace.console.take("operator/figures", 101 * S, figures(remote_consent={"consented": ["pain"]}))
    refused = workplace.ask("begin", pseudonym="P-0417", consent=True)
    assert refused.text == "The patient has not agreed to have touch recorded: remove record, then start again."
    workplace.console.take("operator/figures", 101 * S, figures(remote_consent={"consented": ["pain"]}, recorded={}))
    assert not workplace.ask("begin", pseudonym="P-0417").ok, "the remote site's answer is confirmed as well"
    assert workplace.ask("begin", pseudonym="P-0417", consent=True).ok


def consent_check(console: Console) -> str:
    """What the check list says of the consent; empty where it is ready."""
    (found,) = [check for check in checks(console, 101.0, "operator.toml") if check["name"] == "consent"]
    return str(found["text"])


@pytest.mark.parametrize(
    "details",
    [
        {"finger": "nose"},
        {},
        {"finger": "index", "kind": "hole"},
        {"finger": "index", "x_mm": 1.0},
        {"finger": "index", "x_mm": float("nan"), "y_mm": 0.0},
        {"finger": "index", "x_mm": True, "y_mm": 0.0},
        {"finger": "index", "at_s": "now"},
    ],
)
def test_a_finding_that_is_none_is_refused(workplace: Workplace, details: dict[str, Any]) -> None:
    workplace.ask("begin", pseudonym="P-0417")
    assert not workplace.ask("finding", **details).ok
    assert workplace.console.examination.findings == {}


def test_a_note_is_kept_as_it_was_written(workplace: Workplace) -> None:
    workplace.ask("begin", pseudonym="P-0417")
    ident = (workplace.ask("finding", finger="index", x_mm=10.0, y_mm=0.0).details or {})["id"]
    hostile = "<img src=x onerror=alert(1)>\u202e\x00" * 300
    assert workplace.ask("note", finding=ident, text=hostile).ok
    assert workplace.console.examination.findings[ident].note == hostile
    assert not workplace.ask("note", finding=ident, text="x" * (LONGEST_NOTE + 1)).ok
    assert workplace.console.examination.findings[ident].note == hostile
    assert workplace.ask("note", finding=ident, text="half \ud83d").ok
    assert workplace.console.examination.findings[ident].note == "half \ufffd"
    kept = [str(act["details"].get("text", "")) for act in workplace.kept_acts]
    assert max(map(len, kept)) <= 200, "the whole note is with its finding"


def test_a_note_that_is_sent_twice_is_kept_once(workplace: Workplace) -> None:
    workplace.ask("begin", pseudonym="P-0417")
    workplace.ask("finding", finger="index", x_mm=10.0, y_mm=0.0)
    answers = [workplace.ask("note", finding=1, text=text) for text in ("hard", "hard", "softer", "hard")]
    assert [(answer.ok, answer.text == answers[0].text) for answer in answers] == [(True, True)] * 4
    changes = [(found["change"], found["note"]) for found in workplace.journal.of("console/finding")]
    assert changes == [("mark", ""), ("note", "hard"), ("note", "softer"), ("note", "hard")]
    for note in ("softer", "hard", ""):
        assert workplace.ask("undo").ok
        assert workplace.console.examination.findings[1].note == note
    assert workplace.ask("withdraw", finding=1, reason="scar").ok
    assert not workplace.ask("note", finding=1, text="").ok


def test_an_undo_that_is_sent_again_after_a_lost_answer_undoes_no_further_change(workplace: Workplace) -> None:
    workplace.ask("begin", pseudonym="P-0417")
    workplace.ask("finding", finger="index", x_mm=10.0, y_mm=0.0)
    for text in ("hard", "softer"):
        assert workplace.ask("note", finding=1, text=text).ok
    for changes in (1, 3, "2", -1):
        refused = workplace.ask("undo", finding=1, changes=changes)
        assert (refused.ok, refused.text) == (False, "Changed since. Look at it, then undo again.")
    assert not workplace.ask("undo", finding=2, changes=2).ok
    found = workplace.console.examination.findings
    first, again = (workplace.ask("undo", finding=1, changes=2) for _ in range(2))
    assert first.ok
    assert again == first
    assert found[1].note == "hard"
    assert [kept["change"] for kept in workplace.journal.of("console/finding")] == ["mark", "note", "note", "undo"]
    assert workplace.ask("undo", finding=1, changes=1).ok
    assert found[1].note == ""
    assert workplace.ask("undo", finding=1, changes=1).ok, "again"
    assert workplace.ask("undo", finding=1, changes=0).text == "There is nothing to undo."
    workplace.ask("end")
    assert workplace.ask("undo", finding=1, changes=1).text == "There is nothing to undo."


def test_a_finding_that_is_marked_again_after_a_lost_answer_is_kept_once(workplace: Workplace) -> None:
    workplace.ask("begin", pseudonym="P-0417")
    mark: dict[str, Any] = {"finger": "index", "at_s": 100.5, "kind": "warm", "x_mm": 10.0, "y_mm": 0.0}
    first, again = (workplace.ask("finding", **mark) for _ in range(2))
    assert first.ok
    assert again == first
    assert workplace.ask("finding", **mark | {"kind": None}).ok
    assert [found["change"] for found in workplace.journal.of("console/finding")] == ["mark"]
    assert workplace.ask("finding", **mark | {"kind": "cold", "x_mm": 12.0}).text.startswith("Change of finding 1 ")
    (found,) = workplace.console.examination.findings.values()
    assert (found.kind, found.x_m) == ("cold", 0.012)
    assert workplace.ask("undo").ok
    assert workplace.console.examination.findings[1].kind == "warm"
    for other in ({"finger": "thumb"}, {"at_s": 100.6}, {"at_s": 100.6, "x_mm": None, "y_mm": None}):
        assert workplace.ask("finding", **mark | other).ok
    assert workplace.ask("withdraw", finding=1, reason="scar").ok
    assert (workplace.ask("finding", **mark).details or {})["id"] == 4, "a withdrawn finding is not brought back"


def test_the_values_at_a_place_are_answered_with_their_uncertainty(workplace: Workplace) -> None:
    workplace.observer.quantities = ("temperature",)
    answer = workplace.ask("place", workplace.observer, x_mm=10.0, y_mm=0.0)
    assert answer.text == "24.1 ± 0.3 °C, 1 touch, 0 s ago"
    assert workplace.ask("place", workplace.observer, x_mm=90.0, y_mm=0.0).text == "Nothing was felt here."
    assert not workplace.ask("place", x_mm="here").ok


def test_the_map_of_materials_names_the_material_of_a_place(workplace: Workplace) -> None:
    workplace.console.tactile_map.take(sample("material", 1, 0.01, 0.0, 0.8, 1.0)._replace(name="pvc"))
    workplace.observer.quantities = ("material",)
    answers = [workplace.ask("place", workplace.observer, x_mm=x_mm, y_mm=0.0).text for x_mm in (10.0, 90.0)]
    assert answers == ["PVC > 99 %", "Nothing was felt here."]


def test_a_pressed_place_has_the_probability_of_a_lump(workplace: Workplace) -> None:
    for number, (column, line) in enumerate(product(range(-4, 5), repeat=2), 100):
        x_m, y_m = 0.3 + 0.005 * column, 0.005 * line
        ln_k = math.log(1200.0 if math.hypot(x_m - 0.3, y_m) < 0.006 else 600.0 + number % 7)
        workplace.console.tactile_map.take(sample("stiffness", number, x_m, y_m, ln_k, 0.02**2))
    workplace.observer.quantities = ("stiffness",)
    answers = [workplace.ask("place", workplace.observer, x_mm=x_mm, y_mm=0.0).text for x_mm in (300.0, 320.0)]
    assert ["lump > 99 %" in text for text in answers] == [True, False]
    assert re.search(r"N/m, lump \d %, .* times the .* N/m around it \(\d+ touches\), 1 touch", answers[1])


def test_a_past_alarm_is_acknowledged_with_a_name_and_a_present_fault_is_not(workplace: Workplace) -> None:
    console = workplace.console
    assert workplace.ask("acknowledge").text == "No past alarm waits to be acknowledged."
    happen(console, 101.0, "fault", fault=Fault(FaultCode.FORCE_SWINGS, "index", value=1.2, rate_hz=23.0))
    console.step(101.0)
    assert not workplace.ask("acknowledge").ok, "its cause is still there"
    happen(console, 101.5, "cleared")
    console.step(101.5)
    assert workplace.ask("acknowledge").ok
    assert workplace.site.asked == [], "no fault of the site is cleared by it"
    assert [alarm.cleared_by for alarm in console.alarms.listed] == ["OR-1 1"]


def test_who_clears_a_fault_clears_its_alarm_too_and_nothing_else(workplace: Workplace) -> None:
    console = workplace.console
    assert workplace.ask("clear_fault").text == "There is nothing to clear."
    happen(console, 101.0, "fault", fault=Fault(FaultCode.FORCE_SWINGS, "index", value=1.2, rate_hz=23.0))
    console.step(101.0)
    assert workplace.ask("clear_fault").ok
    assert workplace.site.asked == ["clear_fault"]
    console.step(101.1)
    workplace.commands.step(101.1)
    (alarm,) = console.alarms.listed
    assert (alarm.cleared_by, alarm.ended_s) == ("OR-1 1", 101.1)
    happen(console, 110.0, "fault", fault=Fault(FaultCode.FORCE_SWINGS, "index", value=1.2, rate_hz=23.0))
    console.step(110.0)
    happen(console, 110.0, "cleared")
    console.step(110.1)
    workplace.commands.step(110.1)
    assert console.alarms.listed[0].waits, "that was another one"


def test_clearing_a_fault_acknowledges_no_alarm_that_is_over_only_afterwards(workplace: Workplace) -> None:
    console = workplace.console
    happen(console, 101.0, "fault", fault=Fault(FaultCode.FORCE_SWINGS, "index", value=1.2, rate_hz=23.0))
    lost = {"link": Cause(Priority.HIGH, texts.LINK_LOST, texts.LINK_BACK, latches=True)}
    over = {"stop": Cause(Priority.HIGH, texts.not_confirmed(["index"]), texts.STOP_LATE, latches=True)}
    console.step(101.0)
    console.alarms.step(101.0, over, complete=False)
    assert workplace.ask("clear_fault").ok
    console.alarms.step(101.1, lost | over, complete=False)
    happen(console, 101.5, "cleared")
    console.step(101.5)
    workplace.commands.step(101.5)
    assert [alarm.text for alarm in console.alarms.listed if alarm.waits] == [texts.LINK_BACK, texts.STOP_LATE]
    assert [alarm.ident for alarm in console.alarms.listed if alarm.cleared_by] == ["fault"]


def test_a_fault_of_the_remote_site_is_not_called_cleared_before_it_is(workplace: Workplace) -> None:
    workplace.site.answer = lambda: BRIEF | {"remote_fault": fault_figures(Fault(FaultCode.PATIENT_STOP))}
    workplace.console.take_answer(101.0, workplace.site.answer())
    assert workplace.ask("clear_fault") == Answer(True, "The remote site is asked to clear its fault.")
    assert workplace.site.asked == ["clear_fault"]


def nested(depth: int) -> list[Any]:
    value: list[Any] = []
    for _ in range(depth):
        value = [value]
    return value


STRANGE = {"nested": nested(5000), "digits": 10**5000}


@pytest.mark.parametrize("verb", ["reboot", "", None, 7, ["engage"], "play", "seek", *STRANGE])
def test_what_there_is_not_cannot_be_asked_for(workplace: Workplace, verb: object) -> None:
    verb = STRANGE.get(str(verb), verb)
    assert not workplace.ask(verb).ok
    assert workplace.site.asked == []
    assert workplace.kept == [(verb if isinstance(verb, str) else type(verb).__name__, False)]


@pytest.mark.parametrize(("verb", "text"), [("disengage", "PAUSED. Outputs neutral."), ("estop", "STOPPING")])
def test_an_act_is_kept_before_it_is_done_but_for_a_stop_and_again_with_who_and_its_answer(
    workplace: Workplace, verb: str, text: str
) -> None:
    kept_before: list[dict[str, Any]] = []

    def look() -> dict[str, Any]:
        kept_before.extend(workplace.kept_acts)
        return dict(BRIEF)

    workplace.site.answer = look
    assert workplace.ask(verb) == Answer(True, text)
    done = workplace.kept_acts[-1]
    assert (done["who"], done["verb"], done["ok"], done["answer"]) == ("OR-1 1", verb, True, text)
    assert kept_before == ([{**done, "ok": None, "answer": ""}] if verb == "disengage" else [])
    assert len(workplace.kept) == len(kept_before) + 1
    workplace.ask("engage", workplace.second)
    refused = workplace.kept_acts[-1]
    assert (refused["who"], refused["verb"], refused["ok"]) == ("OR-1 2", "engage", False)


@pytest.mark.parametrize(
    "details",
    [
        {"half \ud83d": 1},
        {"x" * 10_000: 1},
        {"deep": [[[["\ud83d"]]]]},
        {"n": 10**400},
        *({"strange": value} for value in STRANGE.values()),
    ],
    ids=["half", "long", "deep", "number", *STRANGE],
)
def test_an_act_with_details_that_no_file_takes_is_answered_and_recorded(
    workplace: Workplace, details: dict[str, Any]
) -> None:
    assert workplace.ask("disengage", **details).ok
    assert workplace.ask("estop", **details).ok
    assert workplace.kept == [("disengage", None), ("disengage", True), ("estop", True)]


@pytest.mark.parametrize("error", [ValueError("no such record"), KeyError("stream"), AssertionError()])
def test_what_cannot_be_recorded_is_not_done_but_for_a_stop(
    workplace: Workplace, monkeypatch: pytest.MonkeyPatch, contained: Contained, error: Exception
) -> None:
    def fail(*given: object) -> None:
        raise error

    monkeypatch.setattr(workplace.journal, "write", fail)
    assert workplace.ask("disengage") == Answer(False, texts.REQUEST_NOT_RECORDED)
    assert workplace.site.asked == []
    assert workplace.ask("estop").ok
    assert workplace.site.asked == ["estop"]
    (name,) = contained.take()
    assert name.startswith("record of acts: ")


def test_stops_while_one_waits_wait_for_the_same_one(workplace: Workplace, monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[str] = []
    waiting: Future[dict[str, Any]] = Future()

    def ask(verb: str, details: object = None) -> "Future[dict[str, Any]]":
        asked.append(verb)
        return waiting

    monkeypatch.setattr(workplace.site, "ask", ask)

    async def stop() -> list[Answer]:
        stops = [asyncio.create_task(workplace.commands.ask(workplace.first, "estop", {}, 101.0)) for _ in range(100)]
        await asyncio.sleep(0.01)
        waiting.set_result(dict(BRIEF))
        return [await stop for stop in stops]

    assert all(answer.ok for answer in asyncio.run(stop()))
    assert asked == ["estop"]


@pytest.mark.parametrize("text", ["P-1\n2026-11-25 ERROR forged", "P-1\x1b[31m", "P-1\u202e"])
def test_a_study_number_is_printable_and_a_verb_stands_on_one_line_of_the_log(
    workplace: Workplace, caplog: pytest.LogCaptureFixture, text: str
) -> None:
    caplog.set_level("INFO")
    assert not workplace.ask("begin", pseudonym=text).ok
    assert workplace.console.examination.pseudonym is None
    assert not workplace.ask(text).ok
    assert len(caplog.records) >= 2
    assert all(record.getMessage().isprintable() for record in caplog.records)


def test_a_report_that_fails_inside_says_so_and_ends_nothing(workplace: Workplace, contained: Contained) -> None:
    class Failing(Reporting):
        async def write(self, pseudonym: str, files: Sequence[Path]) -> str:
            raise ValueError("embedded null byte")

    workplace.commands.examining.reporting = Failing((), None)

    async def examine() -> None:
        await workplace.commands.ask(workplace.first, "begin", {"pseudonym": "P-0417"}, 101.0)
        await workplace.commands.ask(workplace.first, "end", {}, 102.0)
        await asyncio.sleep(0.01)

    asyncio.run(examine())
    (name,) = contained.take()
    assert "embedded null byte" in name
    assert "No report: report: ValueError" in str(workplace.commands.examining.saved)


def test_refusals_without_end_are_answered_and_only_a_part_is_recorded(
    workplace: Workplace, caplog: pytest.LogCaptureFixture
) -> None:
    caplog.set_level("INFO")
    for _ in range(500):
        assert not workplace.ask("estop", workplace.observer).ok
    kept = len(workplace.kept)
    assert 1 <= kept <= 20
    assert len(caplog.records) <= 20
    workplace.observer.name = "student 4"  # the same visitor by another page
    later = asyncio.run(workplace.commands.ask(workplace.observer, "engage", {}, 201.0))
    assert not later.ok
    assert workplace.kept_acts[-1]["details"]["refused_before"] == 500 - kept
    assert workplace.ask("estop").ok


def test_clutch_and_scale_are_asked_of_the_site_and_recorded(workplace: Workplace) -> None:
    answer = workplace.ask("clutch", open=True)
    assert (answer.ok, answer.text) == (True, "Clutch open. The remote hand stays.")
    assert workplace.ask("clutch", open=False).text == "Clutch closed."
    assert workplace.ask("scale", scale=5).text == "Motion scale 1:5."
    assert workplace.site.asked == ["clutch", "clutch", "scale"]
    assert workplace.kept == [(verb, ok) for verb in ("clutch", "clutch", "scale") for ok in (None, True)]
    assert [act["details"] for act in workplace.kept_acts[::2]] == [{"open": True}, {"open": False}, {"scale": 5}]


MARKS = {f"{name}{number}": 0.1 * number for number in range(1, 5) for name in "uvxy"}
NO_NUMBERS = (None, "1", True, math.nan, math.inf, 10**400)
NO_MARKS = ({"u1": 1.1}, {"x4": None}, {"y2": "1"}, {"v3": math.nan}, {"u2": True})
WRONG = {
    "Say whether the clutch opens or closes.": [("clutch", {"open": o}) for o in (None, 1, "true", [], {})],
    "The motion scale is one of 1:1, 1:2, 1:5.": [("scale", {"scale": s}) for s in (None, 0, 3, 2.0, True, "2", [])],
    "Four marks are needed, each on picture and map.": [("camera_marks", MARKS | wrong) for wrong in NO_MARKS],
    "A place has x_mm and y_mm.": [
        (verb, place)
        for verb in ("place", "propose")
        for n in NO_NUMBERS
        for place in ({"x_mm": n}, {"x_mm": 1.0, "y_mm": n})
    ],
    "This alarm's sound cannot be paused.": [
        ("quiet", {"alarm": "behind", "seconds": seconds}) for seconds in (*NO_NUMBERS, -1.0)
    ],
}


@pytest.mark.parametrize("text", WRONG)
def test_wrong_details_are_refused_and_nothing_is_asked_of_the_site(workplace: Workplace, text: str) -> None:
    workplace.console.take("operator/figures", 101 * S, figures(behind=True))
    workplace.console.step(101.0)
    for verb, details in WRONG[text]:
        assert workplace.ask(verb, **details) == Answer(False, text), details
    assert workplace.site.asked == []


def test_the_sound_of_an_alarm_pauses_for_a_minute_at_most(workplace: Workplace) -> None:
    workplace.console.take("operator/figures", 101 * S, figures(behind=True))
    workplace.console.step(101.0)
    for seconds, paused_s in ((30, 30), (1e6, 60)):
        assert workplace.ask("quiet", alarm="behind", seconds=seconds).text == f"Sound paused {paused_s} s."
        assert workplace.console.alarms.listed[0].quiet_until_s == 101.0 + paused_s


def test_a_refusal_of_the_site_is_the_answer(workplace: Workplace) -> None:
    workplace.site.fails = Refused("a finger presses: lift it, or open the clutch, then change the scale")
    assert workplace.ask("scale", scale=2) == Answer(False, str(workplace.site.fails))


def test_the_marks_of_the_picture_are_recorded(workplace: Workplace) -> None:
    assert workplace.ask("camera_marks", **MARKS).text == "Picture registered with the map."
    assert workplace.kept_acts[-1]["details"] == MARKS
    assert marked_places({1: workplace.kept_acts[-1]}, math.inf) == tuple((0.1 * n, 0.1 * n) for n in range(1, 5))
    assert workplace.site.asked == []


def test_the_protocols_list_every_request(workplace: Workplace) -> None:
    table = PROTOCOLS.read_text("utf-8").partition("| verb | details | who |\n|---|---|---|\n")[2].partition("\n\n")[0]
    listed = [verb for row in table.splitlines() for verb in row.split("|")[1].strip().split(", ")]
    assert sorted(listed) == sorted({*workplace.commands._verbs, "play", "pause", "seek"})
