"""Merges the recordings of a session's processes into one, in order of time."""

import heapq
import logging
from collections import Counter
from collections.abc import Iterable, Iterator, Sequence
from contextlib import ExitStack, suppress
from dataclasses import asdict, dataclass
from operator import itemgetter
from pathlib import Path
from typing import IO

from mcap.records import Attachment, Channel, Message, Metadata, Schema
from mcap.writer import CompressionType, Writer

from common.files.each_once import require_each_once
from common.files.private_file import replacing
from common.link.session_state import Happening
from common.privacy.recording_file import create_recording, open_recording, recipient_of
from common.recording.reader import RecordingReader
from common.recording.truncated_mcap import TruncatedMcap, has_end
from operator_site.recorded_rows import Clock
from teletaction.recordings.one_clock import ClockLine, TwoClocks, require_one_host

log = logging.getLogger(__name__)

Recorded = tuple[Schema | None, Channel, Message]
ORIGIN = "recording"
"""Key of a channel's metadata that names its recording. A restarted process makes several recordings."""
_CLOCK = "operator/clock"
_SESSIONS = ("operator/session", "remote/session")


@dataclass(frozen=True, slots=True)
class _Recording:
    name: str
    clock_id: str
    """Monotonic clock of its times; empty for a recording of version 0.1.0."""
    metadata: list[Metadata]
    attachments: list[Attachment]
    messages: Iterable[Recorded]
    """Messages in order of time. Those of a whole file are read on demand."""
    offsets: list[tuple[int, Clock]]
    """Offsets of the other host's clock that it measured, with their times, ns."""
    sessions: set[int]
    """Numbers of the sessions that it is part of, as far as known."""


def merge_recordings(recordings: list[Path], out: Path) -> dict[str, int]:
    """Merge MCAP files into one; return the number of messages of each stream.

    Log times are of the operator host's monotonic clock, and order the streams of all processes. Publish times are as
    recorded. Where the remote site ran on another host, its times are converted by the measured offset of the clocks;
    the metadata `clocks` state the offset and its uncertainty. Where a recording is encrypted, `out`
    is encrypted for the same key.

    Metadata and attachments are named `RECORDING/NAME`. Each channel's metadata names its recording. A truncated file,
    as a killed process leaves it, or a damaged one contributes its readable part; damage is logged.

    Raises:
        OSError: a recording cannot be read or `out` cannot be written.
        TwoClocks: the recordings are of several hosts and cannot be put on one clock.
        ValueError: a recording is named twice.
    """
    require_each_once(recordings)
    counts: Counter[str] = Counter()
    with ExitStack() as files:
        opened = [files.enter_context(open_recording(path)) for path in recordings]
        sources = [_open(path, file) for path, file in zip(recordings, opened, strict=True)]
        clocks = _Clocks(sources)
        made = files.enter_context(replacing(out))
        file = files.enter_context(create_recording(made, recipient_of(opened), replace=True))
        writer = Writer(file, compression=CompressionType.ZSTD, enable_data_crcs=True)
        writer.start(profile="teletaction", library="teletaction")
        if clocks.line is not None:
            writer.add_metadata("clocks", {name: str(value) for name, value in asdict(clocks.line).items()})
        for source in sources:
            for entry in source.metadata:
                writer.add_metadata(f"{source.name}/{entry.name}", entry.metadata)
            for attached in source.attachments:
                name = f"{source.name}/{attached.name}"
                writer.add_attachment(attached.create_time, attached.log_time, name, attached.media_type, attached.data)
        channels: dict[tuple[str, int], int] = {}
        streams = [clocks.entries(source) for source in sources]
        for log_ns, origin, schema, channel, message in heapq.merge(*streams, key=itemgetter(0)):
            key = origin, channel.id
            if key not in channels:
                channels[key] = _register(writer, schema, channel, origin)
            writer.add_message(channels[key], log_ns, message.data, message.publish_time)
            counts[channel.topic] += 1
        writer.finish()  # type: ignore[no-untyped-call]  # the library leaves it untyped
    return dict(counts)


class _Clocks:
    """Conversion of each recording's times to one clock.

    Attributes:
        line: offset of the other host's clock; None where all recordings are of one host.
    """

    def __init__(self, sources: Sequence[_Recording]):
        hosts = {source.clock_id for source in sources} - {""}
        measuring = [source for source in sources if source.offsets]
        self.line: ClockLine | None = None
        self._here = ""
        if len(hosts) <= 1:
            if "" in {source.clock_id for source in sources} and measuring:
                require_one_host([source.name for source in sources], ClockLine.fit(measuring[0].offsets))
            return
        names = ", ".join(source.name for source in sources)
        if len(hosts) > 2 or len({source.clock_id for source in measuring}) != 1:
            raise TwoClocks(
                f"{names}: recorded on {len(hosts)} hosts, or on one that was restarted; merge those of one session on "
                "two hosts, with the operator site's, which compares their clocks"
            )
        self._here = measuring[0].clock_id
        try:
            self.line = ClockLine.fit(offset for source in measuring for offset in source.offsets)
        except TwoClocks as error:
            raise TwoClocks(f"{names}: recorded on two hosts, and {error}") from None
        here = set[int]().union(*(source.sessions for source in sources if source.clock_id == self._here))
        there = set[int]().union(*(source.sessions for source in sources if source.clock_id != self._here))
        if here and there and not here & there:
            raise TwoClocks(f"{names}: recorded on two hosts in different sessions, so their clocks were not compared")

    def entries(self, source: _Recording) -> Iterator[tuple[int, str, Schema | None, Channel, Message]]:
        """Yield messages of a recording with their time on the one clock, ns, and the recording's name.

        Messages from before the start of the operator's host have no time on its clock. They are left out, and logged.
        """
        other = self.line if source.clock_id != self._here else None
        early = 0
        for schema, channel, message in source.messages:
            log_ns = message.log_time if other is None else other.operator_time_ns(message.log_time)
            if log_ns < 0:
                early += 1
            else:
                yield log_ns, source.name, schema, channel, message
        if early:
            log.warning("%s: %d messages are older than the operator's host has run; left out", source.name, early)


def _clock_id(metadata: Iterable[Metadata]) -> str:
    return next((entry.metadata["clock_id"] for entry in metadata if "clock_id" in entry.metadata), "")


def _offsets(messages: Iterable[Recorded]) -> list[tuple[int, Clock]]:
    found = []
    for _, channel, message in messages:
        if channel.topic == _CLOCK:
            with suppress(ValueError):  # a reader of the merged file finds the damaged message
                found.append((message.log_time, Clock.unpack(message.data)))
    return found


def _sessions(messages: Iterable[Recorded]) -> set[int]:
    found = set()
    for _, channel, message in messages:
        if channel.topic in _SESSIONS:
            with suppress(ValueError):  # likewise
                found.add(Happening.unpack(message.data).session)
    return found - {0}


def _register(writer: Writer, schema: Schema | None, channel: Channel, origin: str) -> int:
    schema_id = 0 if schema is None else writer.register_schema(schema.name, schema.encoding, schema.data)
    return writer.register_channel(
        channel.topic, channel.message_encoding, schema_id, {**channel.metadata, ORIGIN: origin}
    )


def _open(path: Path, file: IO[bytes]) -> _Recording:
    try:
        reader = RecordingReader(path, file)
    except ValueError as error:
        return _open_cut(path, file, error)
    metadata = [Metadata(name, entry) for name, entry in reader.metadata.items()]
    return _Recording(
        path.stem,
        _clock_id(metadata),
        metadata,
        list(reader.attachments.values()),
        reader.messages(),
        _offsets(reader.messages([_CLOCK])),
        _sessions(reader.messages(_SESSIONS)),
    )


def _open_cut(path: Path, file: IO[bytes], why: ValueError) -> _Recording:
    schemas: dict[int, Schema] = {}
    channels: dict[int, Channel] = {}
    metadata: list[Metadata] = []
    attachments: list[Attachment] = []
    messages: list[Recorded] = []
    cut = TruncatedMcap(file)
    for record in cut.records():
        match record:
            case Schema():
                schemas[record.id] = record
            case Channel():
                channels[record.id] = record
            case Metadata():
                metadata.append(record)
            case Attachment():
                attachments.append(record)
            case Message() if record.channel_id in channels:
                channel = channels[record.channel_id]
                messages.append((schemas.get(channel.schema_id), channel, record))
    if has_end(file) or cut.damaged_parts:
        log.warning("%s; left out", why)
    messages.sort(key=lambda entry: entry[2].log_time)
    return _Recording(
        path.stem, _clock_id(metadata), metadata, attachments, messages, _offsets(messages), _sessions(messages)
    )
