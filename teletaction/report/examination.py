"""Reads an examination from a recording: patient, map, findings, and the requests of the users."""

import hashlib
import json
import math
from collections import Counter
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from common.files.read_files import NotToml, parse_toml
from common.privacy.recording_file import open_recording
from common.recording.reader import RecordingReader
from common.recording.recorded_fields import Map, map_of, read_map
from common.recording.recorded_row import Finite, Whole
from common.tenderness.patient_row import read_patient
from common.wire.messages import Touch
from common.wire.roughness_um import RoughnessUm
from operator_site.console.camera.camera_picture import Picture
from operator_site.console.map.patient_shift import Movement, PatientShift
from operator_site.console.map.tactile_map import TactileMap
from operator_site.console.tenderness.pain_presses import PainPresses
from operator_site.console.tenderness.tender_search import Tenderness, search_tenderness
from operator_site.recorded_rows import Clock
from teletaction.report.pictures.covered_picture import Pixels, covered, marked_places
from teletaction.report.pictures.finding_stills import Still, stills

_MAPS: dict[str, Map] = {
    "operator/figures": map_of(),
    "console/session": map_of(what=str, at_s=Finite, pseudonym=str | None, wall_clock=str | None, who=str | None),
    "console/finding": map_of(
        id=Whole,
        at_s=Finite,
        kind=str | None,
        finger=str | None,
        x_m=Finite | None,
        y_m=Finite | None,
        text=str,
        compare=str | None,
        note=str | None,
        contrast=dict[str, Any] | None,
        confidence=str | None,
        body=dict[str, Any] | None,
        withdrawn=str | None,
    ),
    "console/alarm": map_of(
        id=str,
        since_s=Finite,
        priority=str | None,
        text=str | None,
        ended_s=Finite | None,
        cleared_by=str | None,
    ),
    "console/act": map_of(at_s=Finite, who=str | None, verb=str, ok=bool | None, answer=str | None),
}
STREAMS = ("operator/touch", "operator/clock", "remote/patient", *_MAPS)
"""Names of the recorded streams that an examination reads."""
PICTURES = "console/camera"
"""Name of the recorded stream of the camera."""


@dataclass(slots=True)
class Examination:
    """Content of a recording besides the signals; times in s of the operator site's clock.

    Attributes:
        console: True if a console took part.
        begun: record of the examination's start: pseudonym, wall_clock, who, sides; empty without one.
        ended_s: time of its end, s; None if not recorded.
        operator_s, touched_s: times of the operator site's first message and touch packet, s; None without one.
        findings: last record of each finding, by number.
        acts: requests of the users in order, by time, page and verb; `ok` is None for an unanswered request.
        alarms: last record of each alarm.
        felt: the tactile map.
        movements: movements of the patient under the map, oldest first.
        pain: presses with the patient's answers; empty without consent to record pain.
        sequences: sequence number of each touch packet.
        clock: offset, uncertainty and round trip, s, 20 times a second.
        figures: last figures of the operator site; empty without any.
        clocks: fields of the `ClockLine` by which the remote host's times were converted; empty for one host.
        facts: metadata of each recording: configuration, hashes, version.
        tables: name, kind, date, sensor, number of touches and hash of each calibrated table.
        stills: the camera's picture at the moment of each finding, by number.
        pictures: number of recorded pictures of the camera.
        damaged: number of unreadable messages, by stream.
    """

    console: bool = False
    begun: dict[str, Any] = field(default_factory=dict)
    ended_s: float | None = None
    operator_s: float | None = None
    touched_s: float | None = None
    findings: dict[int, dict[str, Any]] = field(default_factory=dict)
    acts: dict[tuple[float, str | None, str], dict[str, Any]] = field(default_factory=dict)
    alarms: dict[tuple[str, float], dict[str, Any]] = field(default_factory=dict)
    felt: TactileMap = field(default_factory=TactileMap)
    movements: list[Movement] = field(default_factory=list)
    pain: PainPresses = field(default_factory=lambda: PainPresses(math.inf))
    _shift: PatientShift = field(default_factory=PatientShift)
    sequences: list[int] = field(default_factory=list)
    clock: list[tuple[float, float, float]] = field(default_factory=list)
    figures: dict[str, Any] = field(default_factory=dict)
    facts: dict[str, dict[str, str]] = field(default_factory=dict)
    clocks: dict[str, str] = field(default_factory=dict)
    tables: list[dict[str, Any]] = field(default_factory=list)
    stills: dict[int, Still] = field(default_factory=dict)
    pictures: int = 0
    damaged: Counter[str] = field(default_factory=Counter)

    @classmethod
    def read(cls, path: Path, *, blur: bool = False) -> "Examination":
        """Read a merged recording. Unreadable messages are counted and left out.

        Args:
            path: the recording.
            blur: cover the camera's pictures outside the surroundings of the marks.

        Raises:
            OSError: the file cannot be read.
            ValueError: the file is no whole recording, or a checksum is wrong.
        """
        made = cls()
        with open_recording(path) as file:
            reader = RecordingReader(path, file)
            for name, facts in reader.metadata.items():
                made.facts[name.removesuffix("/session")] = dict(facts)
            made.clocks = made.facts.pop("clocks", {})
            for attached in reader.attachments.values():
                made._take_table(attached.name, attached.data)
            for _, channel, message in reader.messages(STREAMS):
                try:
                    made.take(channel.topic, message.log_time * 1e-9, message.data)
                except ValueError:
                    made.damaged[channel.topic] += 1
            with suppress(ModuleNotFoundError):  # the report says so
                moments_s = {number: finding["at_s"] for number, finding in made.findings.items()}
                made.stills = stills(made._pictures(reader), moments_s, made._cover if blur else None)
        return made

    def _pictures(self, reader: RecordingReader) -> Iterator[Picture]:
        for _, _, message in reader.messages((PICTURES,)):
            try:
                picture = Picture.of_record(message.data)
            except ValueError:
                self.damaged[PICTURES] += 1
                continue
            self.pictures += 1
            yield picture

    def _cover(self, pixels: Pixels, at_s: float) -> Pixels:
        return covered(pixels, marked_places(self.acts, at_s))

    def take(self, stream: str, t_s: float, payload: bytes) -> None:
        """Take one message of a stream, recorded at `t_s` (s).

        Raises:
            ValueError: the payload is no message of this stream.
        """
        if self.operator_s is None and stream.startswith("operator/"):
            self.operator_s = t_s
        if stream == "operator/touch":
            self._touch(t_s, Touch.decode(payload))
            return
        if stream == "remote/patient":
            patient = read_patient(payload)
            if self.ended_s is None:
                self.pain.take_answer(t_s, patient.pain, polled=False)
            return
        self.console = self.console or stream.startswith("console/")
        if stream == "operator/clock":
            clock = Clock.unpack(payload)
            if clock.uncertainty_ns is not None:
                self.clock.append((1e-9 * clock.offset_ns, 1e-9 * clock.uncertainty_ns, 1e-9 * clock.round_trip_ns))
            return
        entry = read_map(payload, _MAPS[stream])
        match stream:
            case "operator/figures":
                self.figures = entry
                self.felt.roughness_um = RoughnessUm.of(entry.get("roughness_um"))
            case "console/session":
                self._take_session(entry)
            case "console/finding":
                self.findings[entry["id"]] = entry
            case "console/alarm":
                self.alarms[entry["id"], entry["since_s"]] = entry
            case "console/act":
                # The request to begin the next examination has its answer in that one's file.
                if entry["verb"] != "begin" or entry.get("ok") is not None or self.ended_s is None:
                    self.acts[entry["at_s"], entry["who"], entry["verb"]] = entry

    def _touch(self, t_s: float, touch: Touch) -> None:
        self.sequences.append(touch.sequence)
        self.touched_s = t_s if self.touched_s is None else self.touched_s
        if self.ended_s is not None:  # the hand may feel another patient by now
            return
        rows = touch.rows
        self.felt.add(t_s, rows, touch.summaries)
        self.pain.take_touch(t_s, rows)
        if (movement := self._shift.step(t_s, rows)) is not None:
            self.movements.append(movement)
            self.felt.moved_s = movement.since_s

    def _take_session(self, entry: dict[str, Any]) -> None:
        if entry["what"] == "begin":
            # As at the console, an examination begins with an empty map and no findings.
            if self.touched_s is not None and self.touched_s < entry["at_s"]:
                self.felt, self.pain = TactileMap(self.felt.roughness_um), PainPresses(math.inf)
                self.movements, self._shift = [], PatientShift()
            self.begun, self.ended_s, self.findings = entry, None, {}
        else:
            self.ended_s = entry["at_s"]

    def _take_table(self, name: str, content: bytes) -> None:
        try:
            table = json.loads(content)
        except (ValueError, RecursionError):
            table = None
        known = table if isinstance(table, dict) else {}
        things = known.get("materials") or known.get("surfaces")
        things = things if isinstance(things, list) else []
        touches = [thing.get("touches") or thing.get("strokes") for thing in things if isinstance(thing, dict)]
        self.tables.append(
            {
                "name": name,
                "kind": known.get("kind"),
                "made_on": known.get("made_on"),
                "sensor_serial": known.get("sensor_serial"),
                "touches": sum(number for number in touches if isinstance(number, int)) or None,
                "hash": known.get("content_hash") or hashlib.sha256(content).hexdigest(),
            }
        )

    def valid_findings(self) -> list[dict[str, Any]]:
        """Return the findings that were not withdrawn."""
        return [finding for finding in self.findings.values() if not finding.get("withdrawn")]

    def tenderness(self) -> Tenderness:
        """Return the most tender place, from all presses of the recording; this takes up to half a second."""
        return search_tenderness(self.pain.settled(final=True))

    def consent(self) -> str:
        """Return what the patient agreed to have recorded, for people; empty where no recording has an answer.

        Answers that differ between the recordings are given one by one.
        """
        answers = {}
        for origin, facts in self.facts.items():
            try:
                answer = parse_toml(facts.get("configuration", "")).get("consent")
            except NotToml:
                continue
            if isinstance(answer, dict):
                answers[origin] = ", ".join(name for name, agreed in answer.items() if agreed) or "nothing"
        if len(set(answers.values())) > 1:
            return "; ".join(f"{origin}: {answer}" for origin, answer in answers.items())
        return next(iter(answers.values()), "")

    def configurations(self) -> dict[str, str]:
        """Return the SHA-256 hash of each process's configuration, hexadecimal."""
        return {
            origin: hashlib.sha256(facts["configuration"].encode()).hexdigest()
            for origin, facts in self.facts.items()
            if "configuration" in facts
        }
