"""Reads a recorded session as arrays: sent and rendered values, and the true ones at fingers and patient."""

from array import array
from bisect import bisect_left, bisect_right
from collections import defaultdict
from collections.abc import Iterable
from dataclasses import dataclass, field
from operator import itemgetter
from pathlib import Path
from typing import Any, Self

import numpy as np
from msgspec.structs import asdict, replace

from common.faults.texts import said_fault
from common.link.session_state import Happening
from common.privacy.recording_file import open_recording
from common.recording.reader import RecordingReader
from common.recording.recorded_row import Row
from common.wire.messages import TOUCH_COLUMN, Touch
from common.wire.packets import N
from operator_site.recorded_rows import Rendered, Skin
from remote_site.recorded_rows import Gate
from teletaction.recordings.columns import Columns, Floats, Values, as_floats
from teletaction.recordings.merge import ORIGIN
from teletaction.recordings.recorded_rows import STREAMS, read


@dataclass(frozen=True, slots=True)
class Series:
    """Values over time: `time_s` (n,), and each field (n,) or (n, 5)."""

    time_s: Floats
    values: dict[str, Floats]

    def __getitem__(self, name: str) -> Floats:
        return self.values[name]

    def __len__(self) -> int:
        return len(self.time_s)


@dataclass(frozen=True, slots=True)
class SessionData:
    """Series and events of one recording; times in s on the operator host's monotonic clock if it is merged.

    Attributes:
        touch: columns of the touch packets that the remote site sent, such as mode, contact_force_n and object_c.
        rendered: output of the operator's gate: force_n, motor_rpm, plate_set_c, peltier, limits, age_s, engaged.
        gate: output of the patient's gate: z_m, heater, limits.
        fingertips: true values at the operator's modules (motor_rpm, motor_mv, plate_c, felt_c, force_n, ...).
        contact: true values at the remote fingers (mode, object, force_n, plate_c, ...).
        skin: skin model of the operator site (felt_c, surface_c, flux_w_m2).
        thermal: for each finger, the results of the thermal identification over time.
        truth_events: events of the simulated world.
        sent_events: events that the remote site sent; `time_ns` is converted, too.
        played: events that were displayed to the operator.
        motor_switches: changes of a module's motor voltage.
        happenings: session events of each site, such as a fault and its reason.
        counts: number of messages of each stream.
        leads_s: lead of the clock of each merged recording's host over the times here, s, at its last message.
    """

    touch: Series
    rendered: Series
    gate: Series
    fingertips: Series
    contact: Series
    skin: Series
    thermal: dict[int, list[dict[str, Any]]]
    truth_events: list[dict[str, Any]]
    sent_events: list[dict[str, Any]]
    played: list[dict[str, Any]]
    motor_switches: list[dict[str, Any]]
    happenings: list[dict[str, Any]] = field(default_factory=list)
    counts: dict[str, int] = field(default_factory=dict)
    leads_s: dict[str, float] = field(default_factory=dict)

    def answers(self, finger: int, after_s: float, before_s: float) -> list[dict[str, Any]]:
        """Return the results of a finger's thermal identification between two times, s, without them."""
        rows = self.thermal.get(finger, [])
        first = bisect_right(rows, after_s, key=itemgetter("time_s"))
        return rows[first : bisect_left(rows, before_s, first, key=itemgetter("time_s"))]

    @classmethod
    def read(cls, path: Path) -> Self:
        """Read a merged session recording.

        Raises:
            OSError: the file cannot be read.
            ValueError: the recording is truncated or damaged; the message names place and remedy.
        """
        times: dict[str, array[float]] = defaultdict(lambda: array("d"))
        entries: dict[str, list[Any]] = defaultdict(list)
        columns = {stream: Columns(values) for stream, values in _COLUMNS.items()}
        leads_s: dict[str, float] = {}
        with open_recording(path) as file:
            reader = RecordingReader(path, file)
            for _, channel, message in reader.messages(STREAMS):
                try:
                    entry = read(channel.topic, message.data)
                except ValueError as error:
                    raise reader.damaged(channel.topic, message.log_time, error) from None
                lead_ns = message.publish_time - message.log_time
                leads_s[channel.metadata.get(ORIGIN, "")] = lead_ns * 1e-9
                if channel.topic == "remote/event":
                    entry = replace(entry, time_ns=entry.time_ns - lead_ns)
                times[channel.topic].append(message.log_time * 1e-9)
                columns.get(channel.topic, entries[channel.topic]).append(entry)
        counts = {stream: count for stream, count in reader.counts.items() if count}
        thermal: dict[int, list[dict[str, Any]]] = defaultdict(list)
        for time_s, row in zip(times["remote/thermal"], entries["remote/thermal"], strict=True):
            thermal[row.finger].append({"time_s": time_s, **asdict(row)})
        return cls(
            touch=Series(np.array(times["remote/touch"]), columns["remote/touch"].arrays()),
            rendered=Series(np.array(times["operator/rendered"]), columns["operator/rendered"].arrays()),
            gate=Series(np.array(times["remote/gate"]), columns["remote/gate"].arrays()),
            fingertips=Series(np.array(times["truth_fingertips"]), columns["truth_fingertips"].arrays()),
            contact=Series(np.array(times["truth_contact"]), columns["truth_contact"].arrays()),
            skin=Series(np.array(times["operator/skin"]), columns["operator/skin"].arrays()),
            thermal=dict(thermal),
            truth_events=_timed(times["truth_event"], entries["truth_event"]),
            sent_events=[asdict(row) for row in entries["remote/event"]],
            played=_timed(times["operator/played"], [asdict(row) for row in entries["operator/played"]]),
            motor_switches=_timed(times["truth_motor"], entries["truth_motor"]),
            happenings=[
                {
                    "time_s": t,
                    "site": site,
                    "what": happening.what,
                    "text": _said(happening),
                    "fault": happening.fault,
                }
                for site in ("remote", "operator")
                for t, happening in zip(times[f"{site}/session"], entries[f"{site}/session"], strict=True)
            ],
            counts=counts,
            leads_s=leads_s,
        )


def _said(happening: Happening) -> str:
    """Return the text of a happening or of its fault, or that a person requested it."""
    asked = "asked for" if happening.what == "disengaged" else ""
    return happening.text or said_fault(happening.fault) or asked


def _rows(kind: type[Row]) -> Values:
    names = [name for name in kind.__struct_fields__ if name != "fault"]
    return lambda rows: {name: as_floats([getattr(row, name) for row in rows]) for name in names}


def _maps(maps: list[dict[str, Any]]) -> dict[str, Floats]:
    numeric = [name for name, value in (maps[0] if maps else {}).items() if not isinstance(value, str)]
    return {name: as_floats([entry[name] for entry in maps]) for name in numeric}


def _touches(touches: list[Touch]) -> dict[str, Floats]:
    blocks = np.array([touch.block for touch in touches], dtype=np.float64).reshape(len(touches), N, len(TOUCH_COLUMN))
    values = {name: blocks[:, :, column] for name, column in TOUCH_COLUMN.items()}
    values["sequence"] = as_floats([touch.sequence for touch in touches])
    values["state"] = as_floats([int(touch.state) for touch in touches])
    return values


_COLUMNS: dict[str, Values] = {
    "remote/touch": _touches,
    "operator/rendered": _rows(Rendered),
    "remote/gate": _rows(Gate),
    "truth_fingertips": _maps,
    "truth_contact": _maps,
    "operator/skin": _rows(Skin),
}
"""Values of the streams whose messages are read as arrays."""


def _timed(time_s: Iterable[float], maps: list[dict[str, Any]]) -> list[dict[str, Any]]:
    return [{"time_s": t, **entry} for t, entry in zip(time_s, maps, strict=True)]
