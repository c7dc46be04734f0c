"""Chunks whose compressed bytes expand to another length than the chunk states."""

import struct
import tracemalloc

import pytest
import zstandard
from mcap.opcode import Opcode

from common.recording.mcap_records import Entry, Unreadable, check_chunk

CONTENT = bytes(1 << 24)


def chunk(stated_bytes: int, *, size_in_the_frame: bool = True) -> Entry:
    packed = zstandard.ZstdCompressor(write_content_size=size_in_the_frame).compress(CONTENT)
    head = struct.pack("<QQQII4sQ", 0, 1, stated_bytes, 0, 4, b"zstd", len(packed))
    return Entry(0, Opcode.CHUNK, head + packed)


@pytest.mark.parametrize("size_in_the_frame", [True, False])
def test_a_chunk_takes_no_more_memory_than_it_states(size_in_the_frame: bool) -> None:
    entry = chunk(1000, size_in_the_frame=size_in_the_frame)
    tracemalloc.start()
    try:
        with pytest.raises(Unreadable):
            check_chunk(entry)
        assert tracemalloc.get_traced_memory()[1] < 1 << 20
    finally:
        tracemalloc.stop()


@pytest.mark.parametrize("size_in_the_frame", [True, False])
def test_a_chunk_that_states_its_length_is_read(size_in_the_frame: bool) -> None:
    assert check_chunk(chunk(len(CONTENT), size_in_the_frame=size_in_the_frame)).uncompressed_size == len(CONTENT)
