"""Holds one examination at the console: its pseudonym, its begin and end, and its findings."""

from dataclasses import dataclass, field, replace
from typing import Any

from common.fingers import FINGERS
from common.link.session_state import Refused
from operator_site.console import texts
from operator_site.console.examination.findings import KINDS, compare, describe, likely_kind
from operator_site.console.map.tactile_map import TactileMap

LONGEST_NOTE = 10_000
"""Maximum length of a note, characters."""
LONGEST_PSEUDONYM = 40
"""Maximum length of a pseudonym, characters."""
SIDES = ("head", "feet", "left", "right")
"""Parts of the body at which an edge of the map may lie."""


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

    def record(self) -> dict[str, Any]:
        """Return the record to store; a later record of the same id replaces an earlier one."""
        found = {name: getattr(self, name) for name in self.__slots__}
        return {"id": found.pop("ident"), **found}

    @classmethod
    def of(cls, record: dict[str, Any]) -> "Finding":
        """Read a record that `record` made; raise KeyError or TypeError on anything else."""
        return cls(**{"ident": record["id"], **{name: value for name, value in record.items() if name != "id"}})


@dataclass(slots=True)
class Examination:
    """Applies the user's actions. Pure: time is an argument, s.

    Attributes:
        pseudonym: None while no examination is under way.
        began_s, ended_s: begin and end of the newest examination; None before they happen.
        sides: parts of the body at the map's top and right edges; None if not given.
        findings: by number, in the order in which they were made.
    """

    pseudonym: str | None = None
    began_s: float | None = None
    ended_s: float | None = None
    sides: dict[str, str] | None = None
    findings: dict[int, Finding] = field(default_factory=dict)

    def begin(self, now_s: float, pseudonym: object, sides: object = None) -> None:
        """Begin an examination.

        Raises:
            Refused: an examination is under way, or the pseudonym is invalid.
        """
        if self.pseudonym is not None:
            raise Refused(texts.SESSION_OPEN.format(pseudonym=self.pseudonym))
        if not isinstance(pseudonym, str) or not 0 < len(pseudonym.strip()) <= LONGEST_PSEUDONYM:
            raise Refused(texts.STUDY_NUMBER_LENGTH.format(longest=LONGEST_PSEUDONYM))
        if not pseudonym.strip().isprintable():
            raise Refused(texts.STUDY_NUMBER_PRINTABLE)
        if texts.looks_like_a_name(pseudonym):
            raise Refused(texts.STUDY_NUMBER)
        known = (
            isinstance(sides, dict) and {*sides} == {"top", "right"} and all(side in SIDES for side in sides.values())
        )
        self.sides = dict(sides) if known and isinstance(sides, dict) else None
        self.pseudonym, self.began_s, self.ended_s = pseudonym.strip(), now_s, None
        self.findings = {}

    def end(self, now_s: float) -> str:
        """End the examination; return its pseudonym.

        Raises:
            Refused: no examination is under way.
        """
        if self.pseudonym is None:
            raise Refused(texts.NO_SESSION)
        ended, self.pseudonym, self.ended_s = self.pseudonym, None, now_s
        return ended

    def find(self, tactile_map: TactileMap, details: dict[str, Any], now_s: float) -> Finding:
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
        place_mm = details.get("x_mm"), details.get("y_mm")
        if not _number(at_s) or not (place_mm == (None, None) or all(_number(value) for value in place_mm)):
            raise Refused(texts.FINDING_NUMBERS)
        ident = max(self.findings, default=0) + 1
        if place_mm == (None, None):
            finding = Finding(ident, at_s, kind, finger, None, None, " ".join(filter(None, (kind, "a moment"))))
        else:
            x_m, y_m = (float(value or 0.0) / 1000.0 for value in place_mm)
            here, around = tactile_map.at(x_m, y_m), tactile_map.around(x_m, y_m)
            kind = kind or likely_kind(here, around)
            finding = Finding(ident, at_s, kind, finger, x_m, y_m, describe(kind, here), compare(kind, here, around))
        self.findings[ident] = finding
        return finding

    def note(self, ident: object, text: object) -> Finding:
        """Write a note to a finding; it replaces an earlier note.

        Raises:
            Refused: there is no such finding, or the text is too long.
        """
        finding = self.findings.get(ident) if isinstance(ident, int) else None
        if finding is None:
            raise Refused(texts.NO_FINDING)
        if not isinstance(text, str) or len(text) > LONGEST_NOTE:
            raise Refused(texts.NOTE_LENGTH.format(longest=LONGEST_NOTE))
        self.findings[finding.ident] = noted = replace(finding, note=text)
        return noted

    def take(self, stream: str, record: dict[str, Any]) -> None:
        """Apply a record of the examination from a recording."""
        if stream == "console/finding":
            finding = Finding.of(record)
            self.findings[finding.ident] = finding
        elif stream == "console/session" and record.get("what") == "begin":
            self.pseudonym, self.began_s, self.ended_s = str(record["pseudonym"]), float(record["at_s"]), None
            self.sides = record.get("sides")
            self.findings = {}
        elif stream == "console/session":
            self.pseudonym, self.ended_s = None, float(record["at_s"])


def _number(value: object) -> bool:
    """Return whether a value is a finite number below 1e12, and no truth value."""
    return isinstance(value, (int, float)) and not isinstance(value, bool) and abs(value) < 1e12  # also not NaN
