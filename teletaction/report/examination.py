"""An examination out of a recording: whose it was, what was felt where, what was found, and who did what."""

import hashlib
import json
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from common.recording.reader import RecordingReader
from common.recording.recorded_fields import Fits, flag, maybe, number, read_map, text, whole
from common.wire.messages import Touch
from operator_site.console.map.tactile_map import TactileMap
from operator_site.recorded_rows import Clock

_MAPS: dict[str, dict[str, Fits]] = {
    "operator/figures": {},
    "console/session": {
        "what": text,
        "at_s": number,
        "pseudonym": maybe(text),
        "wall_clock": maybe(text),
        "who": maybe(text),
    },
    "console/finding": {
        "id": whole,
        "at_s": number,
        "kind": maybe(text),
        "finger": maybe(text),
        "x_m": maybe(number),
        "y_m": maybe(number),
        "text": text,
        "compare": maybe(text),
        "note": maybe(text),
    },
    "console/alarm": {
        "id": text,
        "since_s": number,
        "priority": maybe(text),
        "text": maybe(text),
        "ended_s": maybe(number),
        "cleared_by": maybe(text),
    },
    "console/act": {"at_s": number, "who": maybe(text), "verb": text, "ok": maybe(flag), "answer": maybe(text)},
}
STREAMS = ("operator/touch", "operator/clock", *_MAPS)


@dataclass(slots=True)
class Examination:
    """What a recording knows beside the signals; times in s of the operator site's clock.

    Attributes:
        console: whether a console took part.
        begun: the record of the examination's begin: pseudonym, wall_clock, who, sides; empty without one.
        ended_s: when it ended; None where that is not recorded.
        findings: as they were kept, by number.
        acts: who asked for what, in order, by time, page and verb; with `ok` None one that was never answered.
        alarms: the newest record of each.
        felt: the map.
        sequences: sequence number of each touch packet.
        clock: offset, uncertainty and round trip, s, 20 times a second.
        figures: the operator site's figures, the newest; empty without any.
        facts: what each recording says of itself: configuration, hashes, version.
        tables: each calibrated table's kind, date, sensor and number of touches.
        damaged: messages that could not be read.
    """

    console: bool = False
    begun: dict[str, Any] = field(default_factory=dict)
    ended_s: float | None = None
    findings: dict[int, dict[str, Any]] = field(default_factory=dict)
    acts: dict[tuple[float, str | None, str], dict[str, Any]] = field(default_factory=dict)
    alarms: dict[tuple[str, float], dict[str, Any]] = field(default_factory=dict)
    felt: TactileMap = field(default_factory=TactileMap)
    sequences: list[int] = field(default_factory=list)
    clock: list[tuple[float, float, float]] = field(default_factory=list)
    figures: dict[str, Any] = field(default_factory=dict)
    facts: dict[str, dict[str, str]] = field(default_factory=dict)
    tables: list[dict[str, Any]] = field(default_factory=list)
    damaged: Counter[str] = field(default_factory=Counter)

    @classmethod
    def read(cls, path: Path) -> "Examination":
        """Read a merged recording; a message that cannot be read is counted and left out.

        Raises:
            OSError: it cannot be read.
            ValueError: it is no whole recording, or a checksum is wrong.
        """
        made = cls()
        with path.open("rb") as file:
            reader = RecordingReader(path, file)
            for name, facts in reader.metadata.items():
                made.facts[name.removesuffix("/session")] = dict(facts)
            for attached in reader.attachments.values():
                made._take_table(attached.name, attached.data)
            for _, channel, message in reader.messages(STREAMS):
                try:
                    made.take(channel.topic, message.log_time * 1e-9, message.data)
                except ValueError:
                    made.damaged[channel.topic] += 1
        return made

    def take(self, stream: str, t_s: float, payload: bytes) -> None:
        """Take one message.

        Raises:
            ValueError: it is not what the stream carries.
        """
        if stream == "operator/touch":
            touch = Touch.decode(payload)
            self.sequences.append(touch.sequence)
            self.felt.felt(t_s, touch.rows, touch.told)
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
            case "console/session":
                self._take_session(entry)
            case "console/finding":
                self.findings[entry["id"]] = entry
            case "console/alarm":
                self.alarms[entry["id"], entry["since_s"]] = entry
            case "console/act":
                self.acts[entry["at_s"], entry["who"], entry["verb"]] = entry

    def _take_session(self, entry: dict[str, Any]) -> None:
        if entry["what"] == "begin":
            # Another examination begins with nothing felt and nothing found, as at the console.
            if self.begun:
                self.felt = TactileMap()
            self.begun, self.ended_s, self.findings = entry, None, {}
        else:
            self.ended_s = entry["at_s"]

    def _take_table(self, name: str, content: bytes) -> None:
        try:
            table = json.loads(content)
        except ValueError:
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

    def configurations(self) -> dict[str, str]:
        """The hash of each process's configuration."""
        return {
            origin: hashlib.sha256(facts["configuration"].encode()).hexdigest()
            for origin, facts in self.facts.items()
            if "configuration" in facts
        }
