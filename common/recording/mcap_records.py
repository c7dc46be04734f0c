"""Reads the records of an MCAP file one by one; damage is confined to the record in which it lies.

Every length is compared with the file's size before use, and every record is parsed from its own bytes only.
"""

import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from io import BytesIO
from typing import IO

from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.records import (
    Attachment,
    AttachmentIndex,
    Channel,
    Chunk,
    ChunkIndex,
    DataEnd,
    Footer,
    Header,
    McapRecord,
    MessageIndex,
    Metadata,
    MetadataIndex,
    Schema,
    Statistics,
    SummaryOffset,
)
from mcap.stream_reader import breakup_chunk, get_chunk_data_stream, zstandard  # type: ignore[attr-defined]  # the decompressor is not the library's own name

MAGIC = b"\x89MCAP0\r\n"
LONGEST_RECORD_BYTES = 1 << 28
"""Maximum size of a record or decompressed chunk, bytes; a larger one is damage. Normal chunks have some 256 KiB."""
HEAD_BYTES = 9
MESSAGE_BYTES = HEAD_BYTES + 22
"""Length of a message without its data, bytes."""
_KINDS: dict[int, type[McapRecord]] = {
    Opcode.HEADER: Header,
    Opcode.FOOTER: Footer,
    Opcode.SCHEMA: Schema,
    Opcode.CHANNEL: Channel,
    Opcode.CHUNK: Chunk,
    Opcode.MESSAGE_INDEX: MessageIndex,
    Opcode.CHUNK_INDEX: ChunkIndex,
    Opcode.ATTACHMENT: Attachment,
    Opcode.ATTACHMENT_INDEX: AttachmentIndex,
    Opcode.STATISTICS: Statistics,
    Opcode.METADATA: Metadata,
    Opcode.METADATA_INDEX: MetadataIndex,
    Opcode.SUMMARY_OFFSET: SummaryOffset,
    Opcode.DATA_END: DataEnd,
}
"""Kinds of records that this program writes; messages are inside chunks only."""


class Unreadable(ValueError):
    """A damaged record. `offset` is its start in the file, bytes."""

    def __init__(self, offset: int, why: str):
        super().__init__(why)
        self.offset = offset


@dataclass(frozen=True, slots=True)
class Entry:
    """A record as stored in the file: its offset, its kind, and its bytes after the head of nine."""

    offset: int
    opcode: int
    content: bytes

    @property
    def name(self) -> str:
        """Kind of the record, for people."""
        return Opcode(self.opcode).name.lower().replace("_", " ")

    @property
    def length(self) -> int:
        """Length with its head, bytes."""
        return HEAD_BYTES + len(self.content)

    @property
    def packed(self) -> bytes:
        """Bytes as stored in the file."""
        return struct.pack("<BQ", self.opcode, len(self.content)) + self.content


def entries(file: IO[bytes], offset: int = len(MAGIC)) -> Iterator[Entry]:
    """Yield records from `offset` to the footer, in the file's order.

    Raises:
        Unreadable: a record is incomplete, too long, or of an unknown kind.
    """
    size = file.seek(0, 2)
    while True:
        file.seek(offset)
        head = file.read(HEAD_BYTES)
        if len(head) < HEAD_BYTES:
            raise Unreadable(offset, "the file ends here")
        opcode, length = struct.unpack("<BQ", head)
        if opcode not in _KINDS:
            raise Unreadable(offset, "no record begins here")
        if length > min(size - offset - HEAD_BYTES, LONGEST_RECORD_BYTES):
            name = Opcode(opcode).name.lower().replace("_", " ")
            raise Unreadable(offset, f"a {name} of {length} bytes is longer than it can be")
        entry = Entry(offset, opcode, file.read(length))
        yield entry
        if opcode == Opcode.FOOTER:
            return
        offset += entry.length


def parse(entry: Entry) -> McapRecord:
    """Return the fields of a record; raises Unreadable where they are damaged or an attachment's checksum is wrong."""
    kind = _KINDS[entry.opcode]
    stream = ReadDataStream(BytesIO(entry.content))
    try:
        record: McapRecord = kind.read(stream)  # type: ignore[attr-defined]  # every kind has it, but not their base
    except Exception as error:  # the library's exceptions over damaged bytes have no common base
        raise Unreadable(entry.offset, f"its fields cannot be read ({type(error).__name__})") from None
    if isinstance(record, Attachment):
        (checksum,) = struct.unpack("<I", entry.content[-4:])
        if checksum not in (0, zlib.crc32(entry.content[:-4])):
            raise Unreadable(entry.offset, "its checksum is wrong")
    return record


def check_chunk(entry: Entry) -> Chunk:
    """Return a chunk with the right checksum; raises Unreadable."""
    chunk = parse(entry)
    assert isinstance(chunk, Chunk)
    if chunk.compression not in ("", "zstd"):
        raise Unreadable(entry.offset, "its compression is unknown")
    if chunk.uncompressed_size > LONGEST_RECORD_BYTES:
        raise Unreadable(entry.offset, f"its content of {chunk.uncompressed_size} bytes is longer than it can be")
    try:
        # The decompressor takes the memory that the compressed bytes ask for, whatever size the chunk states.
        honest = not chunk.compression or zstandard.frame_content_size(chunk.data) in (-1, chunk.uncompressed_size)
        if honest:
            get_chunk_data_stream(chunk, validate_crc=True)
    except Exception:  # the exceptions of the library and its decompressors have no common base
        raise Unreadable(entry.offset, "its checksum is wrong") from None
    if not honest:
        raise Unreadable(entry.offset, "its content has another length than it states")
    return chunk


def contents(entry: Entry) -> list[McapRecord]:
    """Return schemas, channels and messages of a chunk; raises Unreadable."""
    chunk = check_chunk(entry)
    try:
        return breakup_chunk(chunk)
    except Exception as error:
        raise Unreadable(entry.offset, f"its content cannot be read ({type(error).__name__})") from None
