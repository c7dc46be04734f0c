"""Repairs a recording that a killed process, a full disk or a bad disk truncated or damaged."""

from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import IO

from mcap.records import Attachment, Channel, Message, Metadata, Schema
from mcap.writer import CompressionType, Writer

from common.files.private_file import creating
from common.privacy.recording_file import create_recording, open_recording, recipient_of
from common.recording.encrypted_file import DamagedChunk
from common.recording.mcap_records import MAGIC
from common.recording.reader import RecordingReader
from common.recording.truncated_mcap import TruncatedMcap


@dataclass(frozen=True, slots=True)
class Recovered:
    """Result of a recovery.

    Attributes:
        out: the whole recording.
        messages: number of messages of each stream.
        seconds: time from the first to the last message, s.
        unreadable_bytes: bytes outside all readable records.
        damaged_parts: records left out because their content or checksum is wrong.
        doubtful: the checksum of all data is wrong although every part is right, so metadata may be wrong.
    """

    out: Path
    messages: Counter[str]
    seconds: float
    unreadable_bytes: int
    damaged_parts: int
    doubtful: bool


def recover(path: Path, out: Path | None = None) -> Recovered | None:
    """Write the readable part of a recording into a new file; return None if the recording is whole and undamaged.

    The part of an encrypted recording is encrypted for the same key.

    Args:
        path: the recording, opened for reading only.
        out: file to create; by default `NAME-recovered.mcap` in the same folder.

    Raises:
        ValueError: `path` is not an MCAP file, nothing in it can be read, or `out` exists.
        OSError: `path` cannot be read or `out` cannot be written.
    """
    out = out or path.with_name(f"{path.stem}-recovered.mcap")
    with open_recording(path) as file:
        if not _begins(path, file):
            raise ValueError(f"{path}: not an MCAP file; recordings are what a process writes to its `record`")
        if _is_whole(path, file):
            return None
        cut = TruncatedMcap(file)
        try:
            with creating(out) as made:
                with create_recording(made, recipient_of([file]), replace=True) as copy:
                    messages, seconds = _rewrite(cut, copy)
                if not messages:
                    raise ValueError(f"{path}: not one message in it can be read")
        except FileExistsError:
            raise ValueError(f"{out}: exists; name another file with --out") from None
    return Recovered(out, messages, seconds, cut.unreadable_bytes, cut.damaged_parts, cut.doubtful)


def _begins(path: Path, file: IO[bytes]) -> bool:
    """Return whether a file begins as a recording; raises ValueError where an encrypted one is damaged there."""
    try:
        return file.read(len(MAGIC)) == MAGIC
    except DamagedChunk as error:
        raise ValueError(f"{path}: {error}: without its beginning, nothing can be recovered") from None


def _is_whole(path: Path, file: IO[bytes]) -> bool:
    """Return True if the whole recording can be read and every checksum is right."""
    try:
        for _ in RecordingReader(path, file).messages():
            pass
    except ValueError:
        return False
    return True


def _rewrite(cut: TruncatedMcap, out: IO[bytes]) -> tuple[Counter[str], float]:
    """Copy the readable records.

    Returns the number of messages of each stream and the time from the first to the last, s.
    """
    messages: Counter[str] = Counter()
    first_ns = last_ns = None
    schemas: dict[int, int] = {0: 0}
    channels: dict[int, tuple[int, str]] = {}
    writer = Writer(out, compression=CompressionType.ZSTD, enable_data_crcs=True)
    writer.start(profile="teletaction", library="teletaction")
    for record in cut.records():
        match record:
            case Metadata():
                writer.add_metadata(record.name, record.metadata)
            case Attachment():
                writer.add_attachment(record.create_time, record.log_time, record.name, record.media_type, record.data)
            case Schema() if record.id not in schemas:
                schemas[record.id] = writer.register_schema(record.name, record.encoding, record.data)
            case Channel() if record.id not in channels and record.schema_id in schemas:
                schema = schemas[record.schema_id]
                number = writer.register_channel(record.topic, record.message_encoding, schema, record.metadata)
                channels[record.id] = number, record.topic
            case Message() if record.channel_id in channels:
                number, stream = channels[record.channel_id]
                writer.add_message(number, record.log_time, record.data, record.publish_time, record.sequence)
                messages[stream] += 1
                first_ns = record.log_time if first_ns is None else min(first_ns, record.log_time)
                last_ns = record.log_time if last_ns is None else max(last_ns, record.log_time)
    writer.finish()  # type: ignore[no-untyped-call]  # the library leaves it untyped
    seconds = 0.0 if first_ns is None or last_ns is None else (last_ns - first_ns) * 1e-9
    return messages, seconds
