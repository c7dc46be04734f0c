"""Writes a recording as MCAP with JSON messages, which Foxglove and other MCAP tools read."""

import json
from pathlib import Path
from typing import Any

from mcap.writer import CompressionType, Writer

from common.files.private_file import create_private, replacing, write_private
from teletaction.export.foxglove_layout import LAYOUT
from teletaction.export.log_entries import LOG_SCHEMA, log_entry
from teletaction.export.map_images import IMAGE_SCHEMA, map_images
from teletaction.export.named_fields import Named, Schema, finite
from teletaction.export.named_recording import NamedMessage, NamedRecording
from teletaction.export.topics import TOPICS

LOG_NAME = "foxglove.Log"
"""Name of the schema of log entries, which Foxglove knows."""


def schema_name(topic: str) -> str:
    """Return the name of a stream's schema, such as `teletaction.remote/touch`."""
    return f"teletaction.{topic}"


def encoded(fields: Named) -> bytes:
    """Return a message as JSON. A field of unknown value is left out."""
    return json.dumps(_present(fields), allow_nan=False, separators=(",", ":")).encode()


def write_foxglove(recording: NamedRecording, out: Path) -> dict[str, int]:
    """Write `session.mcap` into `out`: one JSON topic a stream, `/log` for people, and `/map/...` with images.

    `layout.json` beside it has panels for Foxglove.

    Log times are wall-clock times, publish times are monotonic times. A field of unknown value is left out.
    """
    counts: dict[str, int] = {}
    with replacing(out / "session.mcap") as made, create_private(made, replace=True) as file:
        writer = Writer(file, compression=CompressionType.ZSTD, enable_data_crcs=True)
        writer.start(profile="", library="teletaction")
        for name, facts in recording.facts.items():
            writer.add_metadata(name, facts)
        channels = {topic: _register(writer, topic, TOPICS[topic].schema) for topic in recording.topics}
        log = _register(writer, "log", LOG_SCHEMA, name=LOG_NAME)
        for message in recording.messages():
            _add(writer, channels[message.topic], message, message.fields)
            counts[message.topic] = counts.get(message.topic, 0) + 1
            if (entry := log_entry(message)) is not None:
                _add(writer, log, message, entry)
                counts["log"] = counts.get("log", 0) + 1
        for quantity, image in map_images(recording):
            channel = _register(writer, f"map/{quantity}", IMAGE_SCHEMA, name="foxglove.CompressedImage")
            writer.add_message(channel, recording.end_ns, json.dumps(image).encode(), recording.end_ns)
            counts[f"map/{quantity}"] = 1
        writer.finish()  # type: ignore[no-untyped-call]  # the library leaves it untyped
    write_private(out / "layout.json", LAYOUT)
    return counts


def _register(writer: Writer, topic: str, schema: Schema, name: str | None = None) -> int:
    number = writer.register_schema(name or schema_name(topic), "jsonschema", json.dumps(schema).encode())
    return writer.register_channel(f"/{topic}", "json", number)


def _add(writer: Writer, channel: int, message: NamedMessage, fields: Named) -> None:
    writer.add_message(channel, message.wall_ns, encoded(fields), message.monotonic_ns)


def _present(value: Any) -> Any:
    """Return a value without its unknown parts: JSON schema has no type for a number that may be null."""
    if isinstance(value, dict):
        return {name: _present(part) for name, part in value.items() if part is not None}
    if isinstance(value, list):
        return [_present(part) for part in value if part is not None]
    return finite(value) if isinstance(value, float) else value
