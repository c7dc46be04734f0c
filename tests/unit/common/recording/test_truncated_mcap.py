"""The search for the next chunk of a damaged file takes time in proportion to the file, whatever it holds."""

import io
import struct
from collections.abc import Callable
from pathlib import Path

import pytest
import zmq
import zstandard
from mcap.records import Chunk, Message
from mcap.writer import CompressionType, Writer

from common.recording import mcap_records, truncated_mcap
from common.recording.truncated_mcap import TruncatedMcap

UNREADABLE = b"\xff"
"""A byte with which no record begins."""
HEADS = 1000


def sound(time_ns: int) -> bytes:
    """A recording's start and one chunk with a message."""
    file = io.BytesIO()
    writer = Writer(file, compression=CompressionType.NONE)
    writer.start("teletaction", "teletaction")
    schema = writer.register_schema("any", "jsonschema", b"{}")
    writer.add_message(writer.register_channel("any", "msgpack", schema), time_ns, b"content", time_ns)
    writer.flush()  # type: ignore[no-untyped-call]  # the library leaves it untyped
    return file.getvalue()


FIRST, LAST = sound(1), sound(2)
CHUNK = LAST[LAST.index(struct.pack("<QQQ", 2, 2, 0)[:16]) - 9 :]


def chunk_head(data_bytes: int, content_bytes: int, compression: bytes = b"") -> bytes:
    """Head of a chunk with any checksum."""
    named = struct.pack("<I", len(compression)) + compression
    fields = struct.pack("<QQQI", 0, 0, content_bytes, 1) + named + struct.pack("<Q", data_bytes)
    return struct.pack("<BQ", 6, len(fields) + data_bytes) + fields


def overlapping(_: int) -> bytes:
    """Each head states a chunk up to half of the rest."""
    length = len(chunk_head(0, 0))
    stated = [(HEADS - number - 1) * length // 2 for number in range(HEADS)]
    return b"".join(chunk_head(each, each) for each in stated)


def too_short(_: int) -> bytes:
    """Each head states a record up to the middle of the file, whose data are longer than the record."""
    length = 17
    return b"".join(struct.pack("<BQ8x", 6, (HEADS - n - 1) * length // 2) for n in range(HEADS))


def expanding(content_bytes: int) -> bytes:
    """Each chunk is a few bytes that expand to `content_bytes`."""
    packed = zstandard.ZstdCompressor().compress(bytes(content_bytes))
    return (chunk_head(len(packed), content_bytes, b"zstd") + packed) * HEADS


FALSE = [overlapping, too_short, expanding]


def damaged(path: Path, false: bytes) -> int:
    """Write a sound chunk, one unreadable byte, false chunks and another sound chunk; return the file's length."""
    path.write_bytes(FIRST + UNREADABLE + false + CHUNK)
    return path.stat().st_size


@pytest.mark.parametrize("false", FALSE)
def test_a_sound_chunk_after_false_ones_is_found(tmp_path: Path, false: Callable[[int], bytes]) -> None:
    size = damaged(tmp_path / "a.mcap", false(1000))
    with (tmp_path / "a.mcap").open("rb") as file:
        cut = TruncatedMcap(file)
        assert [record.log_time for record in cut.records() if isinstance(record, Message)] == [1, 2]
    assert cut.unreadable_bytes == size - len(FIRST) - len(CHUNK)


@pytest.mark.parametrize("false", FALSE)
def test_the_content_that_is_read_in_vain_is_limited(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, false: Callable[[int], bytes]
) -> None:
    limit, checked = 1 << 18, 0
    original = mcap_records.get_chunk_data_stream

    def counted(chunk: Chunk, *, validate_crc: bool) -> object:
        nonlocal checked
        checked += max(len(chunk.data), chunk.uncompressed_size)
        return original(chunk, validate_crc=validate_crc)

    monkeypatch.setattr(truncated_mcap, "LONGEST_RECORD_BYTES", limit)
    monkeypatch.setattr(mcap_records, "get_chunk_data_stream", counted)
    size = damaged(tmp_path / "a.mcap", false(1 << 16))
    with (tmp_path / "a.mcap").open("rb") as file:
        times_ns = [record.log_time for record in TruncatedMcap(file).records() if isinstance(record, Message)]
    assert times_ns[0] == 1
    assert checked <= limit + 17 * size


def test_an_encrypted_file_with_many_damaged_places_is_decrypted_a_few_times() -> None:
    pytest.importorskip("nacl")
    from common.recording.encrypted_file import EncryptedReader, EncryptedWriter, Header

    class Counting(io.BytesIO):
        taken = 0

        def read(self, size: int | None = -1) -> bytes:
            content = super().read(size)
            self.taken += len(content)
            return content

    public, secret = zmq.curve_keypair()
    stored = Counting()
    writer = EncryptedWriter(stored, *Header.make(public.decode()))
    writer.write(FIRST + (UNREADABLE + CHUNK + bytes(5000)) * 100)
    writer.end()
    size, stored.taken = len(stored.getvalue()), 0
    stored.seek(0)
    cut = TruncatedMcap(io.BufferedReader(EncryptedReader(stored, secret)))
    assert sum(isinstance(record, Message) for record in cut.records()) == 101
    assert stored.taken < 10 * size
