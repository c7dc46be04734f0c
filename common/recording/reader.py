"""Reads a whole recording; every checksum is verified before any content is used."""

import heapq
import zlib
from collections.abc import Iterator, Sequence
from pathlib import Path
from shlex import quote
from typing import IO

from mcap.opcode import Opcode
from mcap.records import Attachment, Channel, Chunk, ChunkIndex, DataEnd, Footer, Message, Metadata, Schema, Statistics

from common.recording.encrypted_file import DamagedChunk, decrypting
from common.recording.mcap_records import (
    LONGEST_RECORD_BYTES,
    MAGIC,
    MESSAGE_BYTES,
    Entry,
    Unreadable,
    check_chunk,
    contents,
    entries,
    parse,
)
from common.recording.truncated_mcap import has_end
from common.version import software_version
from common.wire.packets import BadPacket, Packet, WrongVersion

_PACKETS = ("remote/touch", "operator/touch", "remote/motion", "operator/motion")
"""Streams of packets, as they are on the wire."""


class DamagedRecording(ValueError):
    """A recording that differs from what was written. The message names file, place and remedy in one line."""

    def __init__(self, path: Path, what: str):
        super().__init__(f"{path}: damaged: {what}; `teletaction recover {quote(str(path))}` keeps what can be read")


class RecordingReader:
    """Content of a recording.

    Attributes:
        path: path of the file.
        start_ns, end_ns: times of the first and last message, ns.
        counts: number of messages of each stream.
        channels: channels of the streams, in the file's order.
        metadata, attachments: by name.
    """

    def __init__(self, path: Path, file: IO[bytes]):
        """Check all of `file`, found at `path`; the file must be seekable.

        Raises:
            DamagedRecording: a checksum is wrong, or the index does not match the file.
            ValueError: the file is no MCAP file, is truncated, or has no statistics.
        """
        self.path, self._file = path, file
        try:
            found = _checked(path, file)
        except DamagedChunk as error:
            raise DamagedRecording(path, str(error)) from None
        if found.statistics is None:
            raise ValueError(f"{path}: its index has no statistics: not a recording of this program")
        self.start_ns: int = found.statistics.message_start_time
        self.end_ns: int = found.statistics.message_end_time
        self.counts: dict[str, int] = {}
        self.channels = list(found.channels.values())
        for channel in found.channels.values():
            count = found.statistics.channel_message_counts.get(channel.id, 0)
            self.counts[channel.topic] = self.counts.get(channel.topic, 0) + count
        self.metadata = {entry.name: entry.metadata for entry in found.metadata}
        self.attachments = {entry.name: entry for entry in found.attachments}
        self._channels, self._schemas, self._chunks = found.channels, found.schemas, list(found.chunks.values())

    def messages(
        self, streams: Sequence[str] | None = None, from_ns: int | None = None
    ) -> Iterator[tuple[Schema | None, Channel, Message]]:
        """Yield messages in order of time, of `streams` only where given, and from `from_ns` on.

        Raises:
            DamagedRecording: a chunk's content is invalid although its checksum is right.
        """
        reading = self._in_order(streams, from_ns)
        while True:
            try:
                item = next(reading, None)
            except Exception as error:  # the exceptions over damaged bytes have no common base
                why = str(error) if isinstance(error, Unreadable) else type(error).__name__
                raise DamagedRecording(self.path, f"messages cannot be read ({why})") from None
            if item is None:
                return
            yield item

    def _in_order(
        self, streams: Sequence[str] | None, from_ns: int | None
    ) -> Iterator[tuple[Schema | None, Channel, Message]]:
        """Yield messages as `messages` does; those of one time come in the file's order."""
        waiting: list[tuple[int, int, int, Message]] = []
        waiting_bytes = 0
        chunks = [chunk for chunk in self._chunks if self._holds(chunk, streams, from_ns)]
        chunks.sort(key=lambda chunk: (chunk.message_start_time, chunk.chunk_start_offset), reverse=True)
        while chunks or waiting:
            if not chunks or (
                waiting and waiting[0][:2] < (chunks[-1].message_start_time, chunks[-1].chunk_start_offset)
            ):
                *_, message = heapq.heappop(waiting)
                waiting_bytes -= MESSAGE_BYTES + len(message.data)
                channel = self._channels[message.channel_id]
                yield self._schemas[channel.schema_id] if channel.schema_id else None, channel, message
                continue
            chunk = chunks.pop()
            for place, message in enumerate(self._read(chunk)):
                topic = self._channels[message.channel_id].topic
                if (streams is None or topic in streams) and (from_ns is None or message.log_time >= from_ns):
                    heapq.heappush(waiting, (message.log_time, chunk.chunk_start_offset, place, message))
                    waiting_bytes += MESSAGE_BYTES + len(message.data)
            if waiting_bytes > LONGEST_RECORD_BYTES:
                raise Unreadable(chunk.chunk_start_offset, "too many of its chunks are of the same time")

    def _read(self, chunk: ChunkIndex) -> Iterator[Message]:
        """Yield the messages of a chunk in the file's order."""
        for record in contents(next(entries(self._file, chunk.chunk_start_offset))):
            if isinstance(record, Message):
                if not chunk.message_start_time <= record.log_time <= chunk.message_end_time:
                    raise Unreadable(chunk.chunk_start_offset, "its index states other times than its chunks")
                yield record

    def _holds(self, chunk: ChunkIndex, streams: Sequence[str] | None, from_ns: int | None) -> bool:
        """Return whether a chunk can hold messages of `streams` from `from_ns` on; one without an index always can."""
        if from_ns is not None and chunk.message_end_time < from_ns:
            return False
        topics = [self._channels[number].topic for number in chunk.message_index_offsets]
        return streams is None or not topics or any(topic in streams for topic in topics)

    def damaged(self, stream: str, time_ns: int, why: object) -> ValueError:
        """Return the error of a message whose content does not fit its stream: of another version, or damaged."""
        version = next((facts["version"] for facts in self.metadata.values() if "version" in facts), None)
        if version not in (None, software_version()) and (schema := self._other_schema()):
            return ValueError(f"{self.path}: recorded by version {version}: {schema}; open it with that version")
        at_s = (time_ns - self.start_ns) * 1e-9
        return DamagedRecording(self.path, f"{stream} at {at_s:.3f} s: {' '.join(str(why).split())}")

    def _other_schema(self) -> str:
        """Describe the schema version of the recorded packets if it is not this program's; empty otherwise."""
        first = next(self.messages(_PACKETS), None)
        if first is None:
            return ""
        try:
            Packet.decode(first[2].data)
        except WrongVersion as error:
            return str(error)
        except BadPacket:  # it is longer than the header alone
            return ""
        return ""


def _checked(path: Path, file: IO[bytes]) -> "_Checked":
    encrypted = decrypting(file)
    if encrypted is not None and encrypted.problem:
        raise DamagedChunk(encrypted.problem)
    file.seek(0)
    if file.read(len(MAGIC)) != MAGIC:
        raise ValueError(f"{path}: not an MCAP file; recordings are what a process writes to its `record`")
    if not has_end(file):
        raise ValueError(
            f"{path}: cut, without its end; `teletaction recover {quote(str(path))}` makes a whole one of it"
        )
    return _Checked(path, file)


class _Checked:
    """Checks all records of a file that has its end.

    Raises:
        DamagedRecording: a record is damaged.
    """

    def __init__(self, path: Path, file: IO[bytes]):
        self.statistics: Statistics | None = None
        self.schemas: dict[int, Schema] = {}
        self.channels: dict[int, Channel] = {}
        self.chunks: dict[int, ChunkIndex] = {}
        self.metadata: list[Metadata] = []
        self.attachments: list[Attachment] = []
        self._path = path
        self._lengths: dict[int, int] = {}
        self._start_ns: int | None = None
        data_crc, summary_crc = zlib.crc32(MAGIC), 0
        in_summary = False
        end = 0
        try:
            for entry in entries(file):
                if in_summary:
                    # The footer's own checksum covers the footer up to that checksum.
                    covered = entry.packed[:-4] if entry.opcode == Opcode.FOOTER else entry.packed
                    summary_crc = zlib.crc32(covered, summary_crc)
                if entry.opcode == Opcode.DATA_END:
                    in_summary = True
                elif not in_summary:
                    data_crc = zlib.crc32(entry.packed, data_crc)
                self._take(entry, data_crc, summary_crc)
                end = entry.offset + entry.length + len(MAGIC)
        except Unreadable as error:
            raise DamagedRecording(path, f"byte {error.offset}: {error}") from None
        if end != file.seek(0, 2):
            raise DamagedRecording(path, f"byte {end}: more data follow after its end")
        if self._lengths != {offset: chunk.chunk_length for offset, chunk in self.chunks.items()}:
            raise DamagedRecording(path, "its index does not match its chunks")

    def _take(self, entry: Entry, data_crc: int, summary_crc: int) -> None:
        if entry.opcode == Opcode.CHUNK:
            self._chunk(entry)
            return
        record = parse(entry)
        match record:
            case DataEnd() if record.data_section_crc not in (0, data_crc):
                raise DamagedRecording(self._path, "the checksum of all data is wrong (metadata, or an index)")
            case Footer() if record.summary_crc not in (0, summary_crc):
                raise DamagedRecording(self._path, f"byte {entry.offset}: the checksum of its index is wrong")
            case Metadata():
                self.metadata.append(record)
            case Attachment():
                self.attachments.append(record)
            case Statistics():
                self.statistics = record
            case Schema():
                self.schemas[record.id] = record
            case Channel():
                self.channels[record.id] = record
            case ChunkIndex():
                self.chunks[record.chunk_start_offset] = record

    def _chunk(self, entry: Entry) -> None:
        chunk = parse(entry)
        assert isinstance(chunk, Chunk)
        if self._start_ns is None:
            self._start_ns = chunk.message_start_time
        try:
            check_chunk(entry)
        except Unreadable as error:
            first_s, last_s = (
                (time_ns - self._start_ns) * 1e-9 for time_ns in (chunk.message_start_time, chunk.message_end_time)
            )
            which = f"chunk with the messages of {first_s:.3f} to {last_s:.3f} s"
            raise Unreadable(entry.offset, f"{which}: {error}") from None
        self._lengths[entry.offset] = entry.length
