"""Reads a recording as named messages with wall-clock times."""

from collections.abc import Iterator, Sequence
from datetime import datetime
from pathlib import Path
from typing import IO, NamedTuple

from common.recording.clock_anchor import ClockAnchor
from common.recording.reader import RecordingReader
from teletaction.export.named_fields import Named
from teletaction.export.topics import TOPICS
from teletaction.recordings.merge import ORIGIN

_OPERATOR = ("operator/clock", "operator/session")
"""Streams of which the operator site's recording has at least one."""

FIRST_YEAR, LAST_YEAR = 2000, 2200
"""Range of the year in which a recording may have begun; formats of files hold few others."""


class NamedMessage(NamedTuple):
    """One message: its stream, times in ns, and its fields.

    `monotonic_ns` is the time on the recording host's own clock, `wall_ns` the time since 1970 (UTC).
    """

    topic: str
    monotonic_ns: int
    wall_ns: int
    fields: Named


class NamedRecording:
    """A whole recording of one site, or several merged.

    Attributes:
        path: path of the file.
        topics: streams that have messages, in the order of TOPICS.
        anchor: conversion of all times to the wall clock.
        facts: metadata of each recording by name, such as `remote/session`.
    """

    def __init__(self, path: Path, file: IO[bytes], began: datetime | None = None):
        """Open `file`, found at `path`.

        Args:
            path: path of the file, for errors.
            file: the open file, seekable.
            began: wall-clock time of the first message; needed where the recording has no clock anchor.

        Raises:
            ValueError: the file is no whole recording, or has no clock anchor and `began` is missing,
                or `began` is in another century.
        """
        self._reader = RecordingReader(path, file)
        self.path = path
        self.facts = self._reader.metadata
        self.topics = [topic for topic in TOPICS if self._reader.counts.get(topic)]
        self.anchor = self._anchor(began)

    @property
    def begin_ns(self) -> int:
        """Wall-clock time of the first message, ns since 1970 (UTC)."""
        return self.anchor.wall_time_ns(self._reader.start_ns)

    @property
    def end_ns(self) -> int:
        """Wall-clock time of the last message, ns since 1970 (UTC)."""
        return self.anchor.wall_time_ns(self._reader.end_ns)

    def messages(self, topics: Sequence[str] | None = None) -> Iterator[NamedMessage]:
        """Yield messages in order of time, of `topics` only where given.

        Raises:
            ValueError: a message is damaged; the error names stream, time and remedy.
        """
        for _, channel, message in self._reader.messages(self.topics if topics is None else topics):
            try:
                fields = TOPICS[channel.topic].read(message.data)
            except ValueError as error:
                raise self._reader.damaged(channel.topic, message.log_time, error) from None
            wall_ns = self.anchor.wall_time_ns(message.log_time)
            yield NamedMessage(channel.topic, message.publish_time, wall_ns, fields)

    def _anchor(self, began: datetime | None) -> ClockAnchor:
        if began is not None:
            if not FIRST_YEAR <= began.year <= LAST_YEAR:
                raise ValueError(
                    f"began {began.isoformat()}: its year is none of a recording ({FIRST_YEAR} to {LAST_YEAR})"
                )
            return ClockAnchor("", self._reader.start_ns, round(began.timestamp() * 1e9), 0)
        # All times of a merged file are of the operator host's clock, whatever its recordings are called.
        here = {f"{each.metadata.get(ORIGIN)}/session" for each in self._reader.channels if each.topic in _OPERATOR}
        names = sorted(self.facts, key=lambda name: (name not in here, name))
        anchors = [anchor for name in names if (anchor := ClockAnchor.read(self.facts[name])) is not None]
        if not anchors:
            raise ValueError(
                f"{self.path}: has no wall-clock time, as recorded by version 0.1.0; "
                "give the time of its first message: --began 2026-01-31T10:00:00+00:00, or began= in Python"
            )
        return anchors[0]
