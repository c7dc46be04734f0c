"""One recording of a session out of those that its processes made, in order of time."""

import heapq
from collections.abc import Iterator
from pathlib import Path

from mcap.reader import make_reader
from mcap.records import Channel, Message, Schema
from mcap.writer import CompressionType, Writer


def merge_recordings(recordings: list[Path], out: Path) -> dict[str, int]:
    """Merge MCAP files into one; returns how many messages each stream has.

    All times are of one machine's monotonic clock, so they order the streams of all processes.

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
            readers = [make_reader(f) for f in files]
            for path, reader in zip(recordings, readers, strict=True):
                for metadata in reader.iter_metadata():
                    writer.add_metadata(f"{path.stem}/{metadata.name}", metadata.metadata)
            streams: list[Iterator[tuple[Schema | None, Channel, Message]]] = [r.iter_messages() for r in readers]
            for schema, channel, message in heapq.merge(*streams, key=lambda entry: entry[2].log_time):
                if channel.topic not in channels:
                    assert schema is not None
                    schema_id = writer.register_schema(schema.name, schema.encoding, schema.data)
                    channels[channel.topic] = writer.register_channel(
                        channel.topic, channel.message_encoding, schema_id
                    )
                writer.add_message(
                    channels[channel.topic], message.log_time, message.data, message.publish_time
                )  # fmt: skip
                counts[channel.topic] = counts.get(channel.topic, 0) + 1
        finally:
            for f in files:
                f.close()
        writer.finish()  # type: ignore[no-untyped-call]
    return counts
