"""An examination out of a recording: whose it was, what was felt where, what was found, and who did what."""

import hashlib
import json
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import msgpack
from mcap.reader import make_reader

from common.messages import Touch
from common.packets import BadPacket
from operator_site.console.tactile_map import TactileMap

STREAMS = (
    "operator/touch",
    "operator/clock",
    "operator/figures",
    "console/session",
    "console/finding",
    "console/alarm",
    "console/act",
)


@dataclass(slots=True)
class Examination:
    """What a recording knows beside the signals; times in s of the operator site's clock.

    Attributes:
        console: whether a console took part.
        begun: the record of the examination's begin: pseudonym, wall_clock, who, sides; empty without one.
        ended_s: when it ended; None where that is not recorded.
        findings: as they were kept, by number.
        acts: who did what, in order.
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
    acts: list[dict[str, Any]] = field(default_factory=list)
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
        """
        made = cls()
        with path.open("rb") as file:
            reader = make_reader(file)
            for entry in reader.iter_metadata():
                made.facts[entry.name.removesuffix("/session")] = dict(entry.metadata)
            for attached in reader.iter_attachments():
                made._take_table(attached.name, attached.data)
            for _, channel, message in reader.iter_messages(topics=STREAMS):
                try:
                    made.take(channel.topic, message.log_time * 1e-9, message.data)
                except (BadPacket, ValueError, TypeError, KeyError, IndexError):
                    made.damaged[channel.topic] += 1
        return made

    def take(self, stream: str, t_s: float, payload: bytes) -> None:
        """Take one message.

        Raises:
            ValueError, TypeError, KeyError: it is not what the stream carries.
        """
        if stream == "operator/touch":
            touch = Touch.decode(payload)
            self.sequences.append(touch.sequence)
            self.felt.felt(t_s, touch.block.tolist(), touch.told)
            return
        entry: Any = msgpack.unpackb(payload)
        self.console = self.console or stream.startswith("console/")
        match stream:
            case "operator/clock" if None not in entry:
                offset_s, uncertainty_s, round_trip_s = (1e-9 * float(value) for value in entry)
                self.clock.append((offset_s, uncertainty_s, round_trip_s))
            case "operator/figures":
                self.figures = dict(entry)
            case "console/session":
                self._take_session(entry)
            case "console/finding":
                self.findings[int(entry["id"])] = dict(entry)
            case "console/alarm":
                self.alarms[str(entry["id"]), float(entry["since_s"])] = dict(entry)
            case "console/act":
                self.acts.append(dict(entry))

    def _take_session(self, entry: dict[str, Any]) -> None:
        if entry["what"] == "begin":
            # Another examination begins with nothing felt and nothing found, as at the console.
            if self.begun:
                self.felt = TactileMap()
            self.begun, self.ended_s, self.findings = dict(entry), None, {}
        else:
            self.ended_s = float(entry["at_s"])

    def _take_table(self, name: str, content: bytes) -> None:
        try:
            table = json.loads(content)
        except ValueError:
            table = None
        known = table if isinstance(table, dict) else {}
        things = known.get("materials") or known.get("surfaces") or []
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
