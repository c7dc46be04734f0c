"""Merges the recordings of a session's processes into one, in order of time."""

import heapq
import logging
from collections import Counter
from collections.abc import Iterable, Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import IO

from mcap.records import Attachment, Channel, Message, Metadata, Schema
from mcap.writer import CompressionType, Writer

from common.files.private_file import create_private
from common.recording.reader import RecordingReader
from common.recording.truncated_mcap import TruncatedMcap, has_end

log = logging.getLogger(__name__)

Recorded = tuple[Schema | None, Channel, Message]
ORIGIN = "recording"
"""Key of a channel's metadata that names its recording. A restarted process makes several recordings."""


@dataclass(frozen=True, slots=True)
class _Recording:
    name: str
    metadata: list[Metadata]
    attachments: list[Attachment]
    messages: Iterable[Recorded]
    """Messages in order of time. Those of a whole file are read on demand."""

    def entries(self) -> Iterator[tuple[str, Schema | None, Channel, Message]]:
        """Yield messages with the name of the recording."""
        for schema, channel, message in self.messages:
            yield self.name, schema, channel, message


def merge_recordings(recordings: list[Path], out: Path) -> dict[str, int]:
    """Merge MCAP files into one; return the number of messages of each stream.

    All times come from one machine's monotonic clock, so they order the streams of all processes. Metadata and
    attachments are named `RECORDING/NAME`. Each channel's metadata names its recording. A truncated file, as a killed
    process leaves it, or a damaged one contributes its readable part; damage is logged.

    Raises:
        OSError: a recording cannot be read or `out` cannot be written.
    """
    counts: Counter[str] = Counter()
    with ExitStack() as files:
        sources = [_open(path, files.enter_context(path.open("rb"))) for path in recordings]
        file = files.enter_context(create_private(out, replace=True))
        writer = Writer(file, compression=CompressionType.ZSTD, enable_data_crcs=True)
        writer.start(profile="teletaction", library="teletaction")
        for source in sources:
            for entry in source.metadata:
                writer.add_metadata(f"{source.name}/{entry.name}", entry.metadata)
            for attached in source.attachments:
                name = f"{source.name}/{attached.name}"
                writer.add_attachment(attached.create_time, attached.log_time, name, attached.media_type, attached.data)
        channels: dict[tuple[str, int], int] = {}
        streams = [source.entries() for source in sources]
        for origin, schema, channel, message in heapq.merge(*streams, key=lambda entry: entry[3].log_time):
            key = origin, channel.id
            if key not in channels:
                channels[key] = _register(writer, schema, channel, origin)
            writer.add_message(channels[key], message.log_time, message.data, message.publish_time)
            counts[channel.topic] += 1
        writer.finish()  # type: ignore[no-untyped-call]  # the library leaves it untyped
    return dict(counts)


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
    return _Recording(path.stem, metadata, list(reader.attachments.values()), reader.messages())


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
    return _Recording(path.stem, metadata, attachments, messages)
