"""Writes named messages for Rerun: every number as a curve on a wall-clock and a monotonic time line."""

import math
from collections import defaultdict
from collections.abc import Iterable
from pathlib import Path

import numpy as np
import rerun as rr

from common.files.private_file import replacing, write_private
from teletaction.export.columns import columns_of, row_of
from teletaction.export.log_entries import log_entry
from teletaction.export.named_recording import NamedMessage, NamedRecording

_LEVELS = {2: rr.TextLogLevel.INFO, 3: rr.TextLogLevel.WARN, 4: rr.TextLogLevel.ERROR}
_GROUP = 20_000
"""Number of messages of a stream that are written at once; limits the memory for a long session."""


def write_rerun(recording: NamedRecording, out: Path) -> dict[str, int]:
    """Write `session.rrd` into `out`: scalars such as `/remote/touch/index/object_c`, and a text log."""
    counts = dict.fromkeys(recording.topics, 0)
    with (
        replacing(out / "session.rrd") as made,
        rr.RecordingStream("teletaction", recording_id=recording.path.stem) as stream,
    ):
        write_private(made, b"")  # Rerun opens this file and keeps its mode.
        stream.save(made)
        curves = Curves(stream, recording.topics)
        ahead_ns = recording.anchor.wall_time_ns(0)
        for message in recording.messages():
            counts[message.topic] += 1
            # One clock for both sites, unlike the message's own.
            curves.add(message._replace(monotonic_ns=message.wall_ns - ahead_ns))
        curves.write()
    return counts


class Curves:
    """Writes the numbers of messages to a Rerun stream in groups, and entries of the log at once."""

    def __init__(self, stream: rr.RecordingStream, topics: Iterable[str]):
        """Write messages of these topics to `stream`."""
        self._stream = stream
        self._waiting = {topic: _TopicCurves(stream, topic) for topic in topics}

    def add(self, message: NamedMessage) -> None:
        """Add one message."""
        self._waiting[message.topic].add(message)
        if (entry := log_entry(message)) is not None:
            self._stream.set_time("time", timestamp=np.datetime64(message.wall_ns, "ns"))
            self._stream.set_time("monotonic", duration=np.timedelta64(message.monotonic_ns, "ns"))
            self._stream.log("log", rr.TextLog(entry["message"], level=_LEVELS[entry["level"]]))

    def write(self) -> None:
        """Write the numbers that were added. An unknown value makes no point."""
        for curves in self._waiting.values():
            curves.write()


class _TopicCurves:
    """The numbers of one stream."""

    def __init__(self, stream: rr.RecordingStream, topic: str):
        self._stream = stream
        self._path = {
            name: f"{topic}/{name.replace('.', '/')}"
            for name, schema in columns_of(topic).items()
            if schema["type"] in ("number", "integer", "boolean")
        }
        self._times: list[tuple[int, int]] = []
        self._values: dict[str, list[float]] = defaultdict(list)

    def add(self, message: NamedMessage) -> None:
        self._times.append((message.wall_ns, message.monotonic_ns))
        row = row_of(message.topic, message.fields)
        for name in self._path:
            self._values[name].append(math.nan if row[name] is None else float(row[name]))
        if len(self._times) >= _GROUP:
            self.write()

    def write(self) -> None:
        wall_ns, monotonic_ns = np.array(self._times, dtype=np.int64).reshape(-1, 2).T
        for name, path in self._path.items():
            values = np.array(self._values[name])
            known = ~np.isnan(values)
            if not known.any():
                continue
            self._stream.send_columns(
                path,
                indexes=[
                    rr.TimeColumn("time", timestamp=wall_ns[known].view("datetime64[ns]")),
                    rr.TimeColumn("monotonic", duration=monotonic_ns[known].view("timedelta64[ns]")),
                ],
                columns=rr.Scalars.columns(scalars=values[known]),
            )
        self._times.clear()
        self._values.clear()
