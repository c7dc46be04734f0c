"""Holds one examination at the console: its pseudonym, its begin and end, and its findings.

A finding is an object: it is marked, edited, noted, withdrawn, and each such change can be undone. Each change is a
record of the whole finding, so that the records alone give the present state and the history.
"""

from dataclasses import asdict, dataclass, field, fields, replace
from typing import Any

from common.files.constants import within
from common.fingers import FINGERS
from common.link.session_state import Refused
from operator_site.console import texts
from operator_site.console.examination.body import BodyMark, body_mark, read_mark
from operator_site.console.examination.contrast import compared, contrast_of
from operator_site.console.examination.findings import KINDS, TENDER, describe, likely_kind
from operator_site.console.examination.tender_finding import tender_text
from operator_site.console.map.tactile_map import TactileMap
from operator_site.console.tenderness.tender_search import NOT_SEARCHED, Tenderness

LONGEST_NOTE = 10_000
"""Maximum length of a note, characters."""
LONGEST_PSEUDONYM = 40
"""Maximum length of a pseudonym, characters."""
LONGEST_REASON = 200
"""Maximum length of the reason of a withdrawal, characters."""
CHANGES = ("note", "edit", "withdraw")
"""Changes of a finding that can be undone."""
SIDES = ("head", "feet", "left", "right")
"""Parts of the body at which an edge of the map may lie."""
_LARGEST = 1e12
"""Largest time, s, and coordinate, mm, of a finding."""


@dataclass(frozen=True, slots=True)
class Finding:
    """A place or moment that a person marked; m on the remote bench, s of the operator site's clock."""

    ident: int
    at_s: float
    kind: str | None
    finger: str
    x_m: float | None
    y_m: float | None
    text: str
    compare: str = ""
    note: str = ""
    contrast: dict[str, Any] | None = None
    """Quantity, value, sd and clear of the contrast with the surroundings, K or a ratio; None if it is unknown."""
    confidence: str = "none"
    """Confidence that the place differs as its kind says, one of CONFIDENCES."""
    body: BodyMark | None = None
    withdrawn: str = ""
    """Reason of the withdrawal; empty for a finding that stands."""
    change: str = "mark"
    """What made this record: mark, one of CHANGES, or undo."""

    def record(self) -> dict[str, Any]:
        """Return the record to store; a later record of the same id replaces an earlier one."""
        found = asdict(self)
        return {"id": found.pop("ident"), **found}

    @classmethod
    def of(cls, record: dict[str, Any]) -> "Finding":
        """Read a record that `record` made, also an older one with fewer fields; unknown fields are ignored.

        Raises:
            KeyError, TypeError: anything else.
        """
        known = {each.name for each in fields(cls)} - {"ident", "body"}
        given = {name: value for name, value in record.items() if name in known}
        return cls(ident=record["id"], body=body_mark(record), **given)


@dataclass(slots=True)
class Examination:
    """Applies the user's actions. Pure: time is an argument, s.

    Attributes:
        pseudonym: None while no examination is under way.
        began_s, ended_s: begin and end of the newest examination; None before they happen.
        sides: parts of the body at the map's top and right edges; None if not given.
        body: place of the examination on the body; None if not given.
        findings: by number, in the order in which they were made.
        undoable: earlier states of the findings that undo returns to, oldest first.
    """

    pseudonym: str | None = None
    began_s: float | None = None
    ended_s: float | None = None
    sides: dict[str, str] | None = None
    body: BodyMark | None = None
    findings: dict[int, Finding] = field(default_factory=dict)
    undoable: list[Finding] = field(default_factory=list)

    def begin(self, now_s: float, pseudonym: object, sides: object = None, body: object = None) -> None:
        """Begin an examination.

        Raises:
            Refused: an examination is under way, or the pseudonym or the place on the body is invalid.
        """
        if self.pseudonym is not None:
            raise Refused(texts.SESSION_OPEN.format(pseudonym=self.pseudonym))
        if not isinstance(pseudonym, str) or not 0 < len(pseudonym.strip()) <= LONGEST_PSEUDONYM:
            raise Refused(texts.STUDY_NUMBER_LENGTH.format(longest=LONGEST_PSEUDONYM))
        if not pseudonym.strip().isprintable():
            raise Refused(texts.STUDY_NUMBER_PRINTABLE)
        if texts.looks_like_a_name(pseudonym):
            raise Refused(texts.STUDY_NUMBER)
        self.body = read_mark(body)
        self.sides = _sides(sides)
        self.pseudonym, self.began_s, self.ended_s = pseudonym.strip(), now_s, None
        self.findings, self.undoable = {}, []

    def end(self, now_s: float) -> str:
        """End the examination; return its pseudonym.

        Raises:
            Refused: no examination is under way.
        """
        if self.pseudonym is None:
            raise Refused(texts.NO_SESSION)
        ended, self.pseudonym, self.ended_s = self.pseudonym, None, now_s
        return ended

    def find(
        self, tactile_map: TactileMap, details: dict[str, Any], now_s: float, tenderness: Tenderness = NOT_SEARCHED
    ) -> Finding:
        """Mark a place, or a moment if no place is given.

        Raises:
            Refused: no examination is under way, or the details are not valid for a finding.
        """
        if self.pseudonym is None:
            raise Refused(texts.BEGIN_FIRST)
        kind, finger = details.get("kind"), details.get("finger")
        if (kind is not None and kind not in KINDS) or finger not in FINGERS:
            raise Refused(texts.FINDING_NEEDS.format(kinds=", ".join(KINDS)))
        at_s = details.get("at_s", now_s)
        if not within(at_s, -_LARGEST, _LARGEST):
            raise Refused(texts.FINDING_NUMBERS)
        x_m, y_m = _place(details)
        ident = max(self.findings, default=0) + 1
        made = Finding(ident, at_s, kind, finger, x_m, y_m, "", body=read_mark(details.get("body")))
        self.findings[ident] = finding = _measured(tactile_map, made, tenderness)
        return finding

    def marked(self, details: dict[str, Any]) -> Finding | None:
        """Return the standing finding of the same moment and finger: the answer to its request was lost; None else."""
        return next(
            (
                found
                for found in self.findings.values()
                if (found.at_s, found.finger) == (details.get("at_s"), details.get("finger")) and not found.withdrawn
            ),
            None,
        )

    def edit(self, tactile_map: TactileMap, details: dict[str, Any], tenderness: Tenderness = NOT_SEARCHED) -> Finding:
        """Change kind, place or body of a finding, as far as given, and describe it again by the present map.

        Details that change nothing return the finding as it was.

        Raises:
            Refused: no such finding stands, or the details are not valid for a finding.
        """
        before = self._under_way(details.get("finding"))
        kind = details.get("kind", before.kind)
        if kind is not None and kind not in KINDS:
            raise Refused(texts.FINDING_NEEDS.format(kinds=", ".join(KINDS)))
        edited = replace(before, kind=kind, change="edit")
        if "x_mm" in details or "y_mm" in details:
            x_m, y_m = _place(details)
            edited = replace(edited, x_m=x_m, y_m=y_m)
        if "body" in details:
            edited = replace(edited, body=read_mark(details["body"]))
        if edited == replace(before, change="edit"):
            return before
        if (edited.kind, edited.x_m, edited.y_m) != (before.kind, before.x_m, before.y_m):
            edited = _measured(tactile_map, edited, tenderness)
        return self._change(before, edited)

    def note(self, ident: object, text: object) -> Finding:
        """Write a note to a finding; it replaces an earlier note.

        Raises:
            Refused: no such finding stands, or the text is too long.
        """
        before = self.standing(ident)
        if not isinstance(text, str) or len(text) > LONGEST_NOTE:
            raise Refused(texts.NOTE_LENGTH.format(longest=LONGEST_NOTE))
        return self._change(before, replace(before, note=text, change="note"))

    def withdraw(self, ident: object, reason: object) -> Finding:
        """Withdraw a finding; it stays in record and report with the reason.

        Raises:
            Refused: no such finding stands, or there is no reason.
        """
        before = self._under_way(ident)
        if not isinstance(reason, str) or not 0 < len(reason.strip()) <= LONGEST_REASON:
            raise Refused(texts.REASON_NEEDED.format(longest=LONGEST_REASON))
        return self._change(before, replace(before, withdrawn=reason.strip(), change="withdraw"))

    def undone(self, details: dict[str, Any]) -> Finding | None:
        """Return the finding of an undo that was carried out, but whose answer was lost; None for any other request.

        Raises:
            Refused: the request names no finding that stands.
        """
        if self.pseudonym is None or details.get("changes") != len(self.undoable) + 1:
            return None
        finding = self.standing(details.get("finding"))
        return finding if finding.change == "undo" else None

    def undo(self, details: dict[str, Any]) -> Finding:
        """Undo the last change of a finding that is not undone yet; return the finding as it is again.

        `details` may name that finding, and the number of `changes` that can be undone.

        Raises:
            Refused: there is no such change, or the details name another one.
        """
        if self.pseudonym is None or not self.undoable:
            raise Refused(texts.NOTHING_TO_UNDO)
        named = details.get("finding"), details.get("changes")
        if named not in ((None, None), (self.undoable[-1].ident, len(self.undoable))):
            raise Refused(texts.CHANGED_SINCE)
        finding = replace(self.undoable.pop(), change="undo")
        self.findings[finding.ident] = finding
        return finding

    def _under_way(self, ident: object) -> Finding:
        if self.pseudonym is None:
            raise Refused(texts.NO_SESSION)
        return self.standing(ident)

    def standing(self, ident: object) -> Finding:
        """Return a finding that is not withdrawn.

        Raises:
            Refused: there is none with this number.
        """
        finding = self.findings.get(ident) if isinstance(ident, int) else None
        if finding is None:
            raise Refused(texts.NO_FINDING)
        if finding.withdrawn:
            raise Refused(texts.WAS_WITHDRAWN.format(number=finding.ident))
        return finding

    def _change(self, before: Finding, after: Finding) -> Finding:
        self.undoable.append(before)
        self.findings[after.ident] = after
        return after

    def take(self, stream: str, record: dict[str, Any]) -> None:
        """Apply a record of the examination from a recording."""
        if stream == "console/finding":
            finding = Finding.of(record)
            before = self.findings.get(finding.ident)
            if finding.change in CHANGES and before is not None:
                self.undoable.append(before)
            elif finding.change == "undo" and self.undoable:
                self.undoable.pop()
            self.findings[finding.ident] = finding
        elif stream == "console/session" and record.get("what") == "begin":
            self.pseudonym, self.began_s, self.ended_s = str(record["pseudonym"]), float(record["at_s"]), None
            self.sides, self.body = record.get("sides"), body_mark(record)
            self.findings, self.undoable = {}, []
        elif stream == "console/session":
            self.pseudonym, self.ended_s = None, float(record["at_s"])


def _sides(given: object) -> dict[str, str] | None:
    """Return the parts of the body at the map's top and right edges; None if not both are given."""
    if not isinstance(given, dict) or {*given} != {"top", "right"} or any(side not in SIDES for side in given.values()):
        return None
    return dict(given)


def _place(details: dict[str, Any]) -> tuple[float | None, float | None]:
    """Return the place of a finding, m; None for a moment without a place.

    Raises:
        Refused: only one coordinate is given, or one is no number.
    """
    x_mm, y_mm = details.get("x_mm"), details.get("y_mm")
    if x_mm is None and y_mm is None:
        return None, None
    if not (within(x_mm, -_LARGEST, _LARGEST) and within(y_mm, -_LARGEST, _LARGEST)):
        raise Refused(texts.FINDING_NUMBERS)
    return x_mm / 1000.0, y_mm / 1000.0


def _measured(tactile_map: TactileMap, finding: Finding, tenderness: Tenderness) -> Finding:
    """Return a finding with kind, text and contrast by the map, or by the tenderness, at its place."""
    if finding.x_m is None or finding.y_m is None:
        text = " ".join(filter(None, (finding.kind, "a moment")))
        return replace(finding, text=text, compare="", contrast=None, confidence="none")
    if finding.kind == TENDER:
        said, confidence = tender_text(tenderness, finding.x_m, finding.y_m)
        return replace(finding, text=TENDER, compare=said, contrast=None, confidence=confidence)
    here, around = (look(finding.x_m, finding.y_m) for look in (tactile_map.at, tactile_map.around))
    kind = finding.kind or likely_kind(here, around)
    differs = contrast_of(kind, here, around)
    return replace(
        finding,
        kind=kind,
        text=describe(kind, here, tactile_map.roughness_um),
        compare=compared(kind, here, around, tactile_map.roughness_um),
        contrast=None if differs is None else differs.record(),
        confidence="none" if differs is None else differs.confidence,
    )
