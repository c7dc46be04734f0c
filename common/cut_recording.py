"""Reading an MCAP file from its beginning to where it is cut, as a killed process or a full disk leaves it."""

import struct
from collections.abc import Iterator
from typing import IO

from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap.records import Chunk, McapRecord
from mcap.stream_reader import StreamReader, breakup_chunk


def is_whole(file: IO[bytes]) -> bool:
    """Whether the file ends with its index, as only a closed recording does."""
    file.seek(0)
    try:
        return make_reader(file).get_summary() is not None
    except (McapError, struct.error, OSError, ValueError):
        return False  # no index at its end, or not even room for one


class CutRecording:
    """The readable part of a recording.

    Attributes:
        unreadable_bytes: after the last record that was read; known once `records` has ended.
        damaged_chunks: chunks before that whose check sum is wrong; they are left out.
    """

    def __init__(self, file: IO[bytes]):
        """Read `file`, which must be able to seek."""
        self._file = file
        self._length = file.seek(0, 2)
        self.unreadable_bytes = self._length
        self.damaged_chunks = 0

    def records(self) -> Iterator[McapRecord]:
        """Schemas, channels, messages, metadata and attachments from the file's beginning, in its own order."""
        self._file.seek(0)
        self.damaged_chunks = 0
        # A record longer than the file is damage: to believe its length would take as much memory.
        records = StreamReader(self._file, emit_chunks=True, record_size_limit=self._length).records
        while True:
            try:
                record = next(records, None)
            except Exception:  # what the reader raises over damaged bytes has no common base
                return
            self.unreadable_bytes = self._length - self._file.tell()
            if record is None:
                return
            if isinstance(record, Chunk):
                yield from self._contents(record)
            else:
                yield record

    def _contents(self, chunk: Chunk) -> list[McapRecord]:
        try:
            return breakup_chunk(chunk, validate_crc=True)
        except Exception:  # nor what it and its decompressors raise
            self.damaged_chunks += 1
            return []
