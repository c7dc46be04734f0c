"""Reads the recordings of a soak: their readable length, the largest values, and the latched faults."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import msgpack
from mcap.records import Message

from common.faults.texts import said_fault
from common.link.session_state import Happening
from common.recording.truncated_mcap import TruncatedMcap
from robustness.soak_judge import LIMITS, Extreme
from teletaction.session.conclude import recordings_of
from teletaction.session.demo_files import PROCESSES

LOST_AT_MOST_S = 0.5
"""Largest allowed loss at the end of a killed process's recording, s."""
_SESSIONS = ("remote/session", "operator/session")


@dataclass(slots=True)
class Records:
    """Contents of the recordings.

    Attributes:
        messages: number of messages in each file, by name.
        extremes: largest value of each quantity in LIMITS, by name.
        faults: time of each latch, s, and its reason.
        wrong: problems with reading.
    """

    messages: dict[str, int] = field(default_factory=dict)
    extremes: dict[str, Extreme] = field(default_factory=dict)
    faults: list[tuple[float, str]] = field(default_factory=list)
    wrong: list[str] = field(default_factory=list)


def read_records(folder: Path, ends_s: Mapping[str, Sequence[float]]) -> Records:
    """Read all recordings of a session.

    Args:
        folder: folder of the recordings; those of restarted processes have a number.
        ends_s: times at which each process was killed, in order, and the end of the session, s.
    """
    records = Records()
    for process in PROCESSES:
        try:
            files = sorted(recordings_of(folder, process), key=lambda path: path.stat().st_mtime_ns)
        except ValueError:
            files = []
        if len(files) != len(ends_s[process]):
            records.wrong.append(f"{process}: {len(files)} recordings of {len(ends_s[process])} lives")
            continue
        for path, end_s in zip(files, ends_s[process], strict=True):
            _read(path, end_s, records)
    return records


def _read(path: Path, end_s: float, records: Records) -> None:
    last_s, count = 0.0, 0
    with path.open("rb") as file:
        recording = TruncatedMcap(file)
        for topic, message in recording.messages():
            last_s = max(last_s, message.log_time * 1e-9)
            count += 1
            _take(topic, message, records)
    records.messages[path.name] = count
    if recording.damaged_parts:
        records.wrong.append(f"{path.name}: {recording.damaged_parts} damaged parts")
    if end_s - last_s > LOST_AT_MOST_S:
        records.wrong.append(f"{path.name}: ends {end_s - last_s:.2f} s before its process did")


def _take(topic: str, message: Message, records: Records) -> None:
    time_s = message.log_time * 1e-9
    if topic in _SESSIONS:
        happening = Happening.unpack(message.data)
        if happening.what == "fault":
            records.faults.append((time_s, said_fault(happening.fault)))
    elif topic in ("truth_fingertips", "truth_contact"):
        entry = msgpack.unpackb(message.data)
        for (stream, field_name), (name, _) in LIMITS.items():
            if stream == topic:
                so_far = records.extremes.get(name, (-math.inf, 0.0))
                records.extremes[name] = max(so_far, (max(entry[field_name]), time_s), key=lambda each: each[0])
