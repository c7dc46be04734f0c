"""Reads the findings of an examination for clinical documents: texts, wall-clock times, and values in UCUM units."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from datetime import UTC, datetime, timedelta
from typing import Any, NamedTuple
from uuid import UUID, uuid5

from common.files.printable import printable
from operator_site.console.examination.body import BodyMark, body_mark
from operator_site.console.map.tactile_map import ExploredPlace
from operator_site.console.texts import count
from teletaction.export.named_recording import NamedRecording
from teletaction.report.examination import Examination

PSEUDONYMS = "urn:teletaction:pseudonym"
"""Name space of the subjects' pseudonyms."""
UNIT_TEXT = {"Cel": "°C"}
"""Common text of the UCUM units that have one."""
_UCUM = {"temperature": "Cel", "roughness": "V", "stiffness": "N/m"}
"""UCUM unit of each quantity of the tactile map."""
_NAMES = UUID("5f0cf1f2-7f4e-4c52-9d7c-6c1a6c0d1a55")
"""Name space of the identifiers. The same recording gives the same identifiers."""
_LONGEST_TEXT = 100_000
"""Maximum length of a text, characters. A note of the console fits, even with every character escaped."""


class Quantity(NamedTuple):
    """A value of a finding and its standard deviation, None if unknown, both in a UCUM unit."""

    name: str
    value: float
    sd: float | None
    unit: str


@dataclass(frozen=True, slots=True)
class ClinicalFinding:
    """A finding, with the final values of the tactile map at its place. Texts are printable, and empty if unknown.

    Attributes:
        number: number of the finding in its examination.
        at: wall-clock time, UTC.
        kind: kind of finding, such as `warm`.
        text: finding in words.
        note: note of the operator.
        quantities: place in mm on the remote bench, and the measured values; empty without a place.
        details: further texts by name: finger, comparison with the surroundings, likeliest material, place on
            body, and as stated at the begin the examined part and the sides of the map; none is empty.
        site: region of the body and its side, or with the landmark where the operator gave one for this finding.
    """

    number: int
    at: datetime
    kind: str
    text: str
    note: str
    quantities: tuple[Quantity, ...]
    details: dict[str, str]
    site: str


class ClinicalExamination:
    """The examination of one recording.

    Attributes:
        pseudonym: pseudonym of the subject, printable; empty if unknown.
        begun: wall-clock time of the examination's start, or of the first message, UTC.
        ended: wall-clock time of its end, UTC; None if not recorded.
        recorded: wall-clock times of the recording's first and last message, UTC.
        versions: versions of the software that recorded it, sorted.
        findings: all findings that were not withdrawn, in the order in which they were marked.
        withdrawn: number of the findings that were withdrawn.
    """

    def __init__(self, recording: NamedRecording):
        """Read the findings of a recording.

        Raises:
            OSError: the recording cannot be read.
            ValueError: the recording is damaged.
        """
        self._recording, self._examination = recording, Examination.read(recording.path)
        begun, ended_s = self._examination.begun, self._examination.ended_s
        self.pseudonym = plain_text(begun.get("pseudonym") or "")
        self.recorded = _wall_time(recording.begin_ns), _wall_time(recording.end_ns)
        self.begun = self._time(begun["at_s"]) if begun else self.recorded[0]
        self.ended = None if ended_s is None else self._time(ended_s)
        versions = {facts["version"] for facts in recording.facts.values() if "version" in facts}
        self.versions = sorted(map(plain_text, versions))
        found = self._examination.findings.values()
        self.findings = [self._finding(finding) for finding in found if not finding.get("withdrawn")]
        self.withdrawn = len(found) - len(self.findings)

    @property
    def conclusion(self) -> str:
        """Summary in words, with the numbers of withdrawn findings and of unread messages, if any."""
        damaged = self._examination.damaged.total()
        unread = f" {count(damaged, 'message')} of the recording could not be read." if damaged else ""
        withdrawn = f" {count(self.withdrawn, 'finding')} withdrawn and left out." if self.withdrawn else ""
        return f"{count(len(self.findings), 'finding')} marked by the operator; not signed.{withdrawn}{unread}"

    def identifier(self, name: str) -> UUID:
        """Return the identifier of a named part; the same recording and name give the same one."""
        pseudonym = self._examination.begun.get("pseudonym")
        return uuid5(_NAMES, f"{self._recording.begin_ns} {pseudonym} {name}")

    def _time(self, at_s: float) -> datetime:
        try:
            return _wall_time(self._recording.anchor.wall_time_ns(round(at_s * 1e9)))
        except OverflowError:
            raise ValueError(f"{self._recording.path}: has an impossible time, {at_s:g} s") from None

    def _finding(self, finding: Mapping[str, Any]) -> ClinicalFinding:
        x_m, y_m = finding.get("x_m"), finding.get("y_m")
        here = None if x_m is None or y_m is None else self._examination.felt.at(x_m, y_m)
        material = None if here is None or here.material is None else here.material[0]
        mark, examined = body_mark(finding), body_mark(self._examination.begun)
        # The landmark of the examined part is not that of each finding.
        site = mark or (None if examined is None else BodyMark(examined.region, examined.side))
        details = {
            "finger": finding.get("finger"),
            "comparison": finding.get("compare"),
            "material": material,
            "place on body": None if mark is None else mark.text(),
            "examined part": None if examined is None else examined.text(),
            "sides of the map": _sides(self._examination.begun.get("sides")),
        }
        return ClinicalFinding(
            number=finding["id"],
            at=self._time(finding["at_s"]),
            kind=plain_text(finding.get("kind") or ""),
            text=plain_text(finding["text"]),
            note=plain_text(finding.get("note") or ""),
            quantities=() if here is None else tuple(_quantities(here)),
            details={name: plain for name, text in details.items() if (plain := plain_text(text or ""))},
            site="" if site is None else plain_text(site.text()),
        )


def plain_text(text: str) -> str:
    """Return text of bounded length with its lines, without blanks around it; unprintable characters are escaped."""
    return "\n".join(printable(line, _LONGEST_TEXT) for line in text.split("\n"))[:_LONGEST_TEXT].strip()


def _quantities(here: ExploredPlace) -> Iterator[Quantity]:
    yield Quantity("x on the remote bench", 1e3 * here.x_m, None, "mm")
    yield Quantity("y on the remote bench", 1e3 * here.y_m, None, "mm")
    for name, unit in _UCUM.items():
        if (measured := getattr(here, name)) is not None:
            yield Quantity(name, measured.value, measured.sd, unit)
    if here.material is not None:
        yield Quantity("share of material", here.material[1], None, "1")


def _sides(sides: object) -> str:
    """Return the parts of the body at the edges of the map, such as `top: head, right: left side`."""
    known = sides.items() if isinstance(sides, Mapping) else ()
    return ", ".join(f"{edge}: {name}" for edge, name in known if isinstance(name, str))


def _wall_time(wall_ns: int) -> datetime:
    """Return the time of a wall-clock reading, ns since 1970, to the microsecond."""
    return datetime(1970, 1, 1, tzinfo=UTC) + timedelta(microseconds=wall_ns // 1000)
