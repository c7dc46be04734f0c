"""Reads the intact part of a truncated or damaged MCAP file, left by a killed process or a bad disk."""

import mmap
import re
import zlib
from collections.abc import Iterator
from typing import IO

from mcap.opcode import Opcode
from mcap.records import Channel, DataEnd, McapRecord, Message

from common.recording.encrypted_file import decrypting
from common.recording.mcap_records import (
    LONGEST_RECORD_BYTES,
    MAGIC,
    Entry,
    Unreadable,
    check_chunk,
    contents,
    entries,
    parse,
)

_FOOTER_HEAD = bytes([Opcode.FOOTER]) + (20).to_bytes(8, "little")
_END_BYTES = len(_FOOTER_HEAD) + 20 + len(MAGIC)
_CHUNK_HEAD = re.compile(rb"\x06(?=(.{4}\x00{4}).{16}(.{8}).{4}(\x00{4}|\x04\x00{3}zstd)(.{4}\x00{4}))", re.DOTALL)
"""Start of a chunk: length, size of its content, compression and length of its data; the lengths are below 4 GiB."""
_FIXED_BYTES = 36
"""Length of a chunk without its head, its compression and its data, bytes."""
_IN_VAIN = 16
"""Maximum size of all content that is read in vain in search of a chunk, as a multiple of the file's length.

LONGEST_RECORD_BYTES are added. A file may state any number of overlapping chunks, and each costs as much as it states.
"""
_NAMES = (Opcode.SCHEMA, Opcode.CHANNEL)
_FINDERS = (Opcode.HEADER, Opcode.MESSAGE_INDEX, Opcode.CHUNK_INDEX, Opcode.ATTACHMENT_INDEX, Opcode.METADATA_INDEX)
"""Records that only locate other records."""


def has_end(file: IO[bytes]) -> bool:
    """Return whether a file ends as a closed recording does."""
    encrypted = decrypting(file)
    if encrypted is not None and (encrypted.cut or encrypted.problem):
        return False
    if file.seek(0, 2) < _END_BYTES:
        return False
    file.seek(-_END_BYTES, 2)
    end = file.read(_END_BYTES)
    return end.startswith(_FOOTER_HEAD) and end.endswith(MAGIC)


class TruncatedMcap:
    """The intact part of a recording.

    Attributes:
        unreadable_bytes: number of bytes outside any record; known after `records` has ended.
        damaged_parts: number of records whose content or checksum is wrong; they are omitted.
        doubtful: whether the checksum of all data is wrong although no part is. Parts without a checksum may be wrong.
    """

    def __init__(self, file: IO[bytes]):
        """Read `file`; of an encrypted one, the chunks that were changed are skipped."""
        self._file = file
        if (encrypted := decrypting(file)) is not None:
            encrypted.skips_damage = True
        self._length = file.seek(0, 2)
        self._content: mmap.mmap | bytes | None = None
        self._vain_bytes = 0
        self._data_crc = 0
        self.unreadable_bytes = self._length
        self.damaged_parts = 0
        self.doubtful = False

    def records(self) -> Iterator[McapRecord]:
        """Yield schemas, channels, messages, metadata and attachments from the file's start, in the file's order.

        After an unreadable place it continues with the next intact chunk.
        """
        self._file.seek(0)
        self.unreadable_bytes = self._length
        self.damaged_parts = 0
        if self._file.read(len(MAGIC)) != MAGIC:
            return
        self.unreadable_bytes = 0
        self._vain_bytes = LONGEST_RECORD_BYTES + _IN_VAIN * self._length
        self._data_crc = zlib.crc32(MAGIC)
        yield from self._named_at_the_end()
        offset: int | None = len(MAGIC)
        while offset is not None:
            try:
                for entry in entries(self._file, offset):
                    yield from self._read(entry)
                return
            except Unreadable as error:
                offset = self._sound_chunk(error.offset + 1)
                self.unreadable_bytes += (self._length if offset is None else offset) - error.offset

    def messages(self) -> Iterator[tuple[str, Message]]:
        """Yield each message with its topic, in the order of `records`; messages without a channel are omitted."""
        topics: dict[int, str] = {}
        for record in self.records():
            if isinstance(record, Channel):
                topics[record.id] = record.topic
            elif isinstance(record, Message) and record.channel_id in topics:
                yield topics[record.channel_id], record

    def _named_at_the_end(self) -> list[McapRecord]:
        """Return schemas and channels from the index, because the chunk that first has them may be damaged."""
        if not has_end(self._file):
            return []
        self._file.seek(-_END_BYTES + len(_FOOTER_HEAD), 2)
        start = int.from_bytes(self._file.read(8), "little")
        try:
            index = [parse(entry) for entry in entries(self._file, start) if entry.opcode in _NAMES]
        except (Unreadable, OverflowError, OSError):
            return []
        return index

    def _read(self, entry: Entry) -> list[McapRecord]:
        try:
            if entry.opcode == Opcode.CHUNK:
                found = contents(entry)
            else:
                found = [] if entry.opcode in _FINDERS else [parse(entry)]
        except Unreadable:
            self.damaged_parts += 1
            found = []
        match found:
            case [DataEnd(data_section_crc=checksum)]:
                sound = not self.damaged_parts and not self.unreadable_bytes
                self.doubtful = sound and checksum not in (0, self._data_crc)
        self._data_crc = zlib.crc32(entry.packed, self._data_crc)
        return found

    def _sound_chunk(self, start: int) -> int | None:
        """Return the offset of the next chunk from `start` on with the right checksum; None where there is none."""
        if start >= self._length:
            return None
        if self._content is None:
            self._content = self._whole()
        for found in _CHUNK_HEAD.finditer(self._content, start):
            length, size, compression, data = found.groups()
            stated = int.from_bytes(data, "little")
            cost = max(stated, int.from_bytes(size, "little"))
            if int.from_bytes(length, "little") != _FIXED_BYTES + len(compression) + stated or cost > self._vain_bytes:
                continue
            try:
                if check_chunk(next(entries(self._file, found.start()))).uncompressed_crc:
                    return found.start()
            except Unreadable:
                pass
            self._vain_bytes -= cost
        return None

    def _whole(self) -> mmap.mmap | bytes:
        """Return the whole file; that of an encrypted one is in memory."""
        if decrypting(self._file) is None:
            return mmap.mmap(self._file.fileno(), 0, access=mmap.ACCESS_READ)
        self._file.seek(0)
        return self._file.read()
