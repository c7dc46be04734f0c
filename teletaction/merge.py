"""One recording of a session out of those that its processes made, in order of time."""

import heapq
import struct
from collections.abc import Iterable
from pathlib import Path
from typing import IO

from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap.records import Channel, Message, Metadata, Schema
from mcap.stream_reader import StreamReader
from mcap.writer import CompressionType, Writer

Recorded = tuple[Schema | None, Channel, Message]


def merge_recordings(recordings: list[Path], out: Path) -> dict[str, int]:
    """Merge MCAP files into one; returns how many messages each stream has.

    All times are of one machine's monotonic clock, so they order the streams of all processes. A file
    without its end, as a killed process leaves it, gives what it has.

    Raises:
        OSError: a recording cannot be read or `out` cannot be written.
    """
    counts: dict[str, int] = {}
    with out.open("wb") as file:
        writer = Writer(file, compression=CompressionType.ZSTD)
        writer.start(profile="teletaction", library="teletaction")
        channels: dict[str, int] = {}
        files = [path.open("rb") for path in recordings]
        try:
            streams: list[Iterable[Recorded]] = []
            for path, f in zip(recordings, files, strict=True):
                metadata, messages = _read(f)
                streams.append(messages)
                for entry in metadata:
                    writer.add_metadata(f"{path.stem}/{entry.name}", entry.metadata)
            for schema, channel, message in heapq.merge(*streams, key=lambda entry: entry[2].log_time):
                if channel.topic not in channels:
                    assert schema is not None
                    schema_id = writer.register_schema(schema.name, schema.encoding, schema.data)
                    channels[channel.topic] = writer.register_channel(
                        channel.topic, channel.message_encoding, schema_id
                    )
                writer.add_message(channels[channel.topic], message.log_time, message.data, message.publish_time)
                counts[channel.topic] = counts.get(channel.topic, 0) + 1
        finally:
            for f in files:
                f.close()
        writer.finish()  # type: ignore[no-untyped-call]
    return counts


def _read(file: IO[bytes]) -> tuple[list[Metadata], Iterable[Recorded]]:
    """Metadata, and messages in order of time; a whole file's messages are read as they are asked for."""
    try:
        reader = make_reader(file)
        if reader.get_summary() is not None:
            return list(reader.iter_metadata()), reader.iter_messages()
    except (McapError, struct.error, OSError):
        pass  # no index at its end, or not even room for one: the process that wrote it did not close it
    file.seek(0)
    return _read_cut(file)


def _read_cut(file: IO[bytes]) -> tuple[list[Metadata], list[Recorded]]:
    schemas: dict[int, Schema] = {}
    channels: dict[int, Channel] = {}
    metadata: list[Metadata] = []
    messages: list[Recorded] = []
    try:
        for record in StreamReader(file).records:
            if isinstance(record, Schema):
                schemas[record.id] = record
            elif isinstance(record, Channel):
                channels[record.id] = record
            elif isinstance(record, Metadata):
                metadata.append(record)
            elif isinstance(record, Message):
                channel = channels[record.channel_id]
                messages.append((schemas.get(channel.schema_id), channel, record))
    except (McapError, struct.error):
        pass  # here it was cut
    messages.sort(key=lambda entry: entry[2].log_time)
    return metadata, messages
