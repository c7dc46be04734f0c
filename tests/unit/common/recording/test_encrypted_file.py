"""The encrypted file: any content, read at any place; what was changed, moved, removed or cut is found."""

import io
import struct
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import IO, cast

import pytest
import zmq
from hypothesis import given
from hypothesis import strategies as st
from zmq.utils import z85

pytest.importorskip("nacl")

from common.recording.encrypted_file import (
    CHUNK_BYTES,
    HEADER_BYTES,
    MAGIC,
    CannotDecrypt,
    DamagedChunk,
    EncryptedReader,
    EncryptedWriter,
    Header,
    is_encrypted,
)

PUBLIC, SECRET = (key.decode() for key in zmq.curve_keypair())
OWN = SECRET.encode()
HEADER, KEY = Header.make(PUBLIC)


def encrypted(parts: Sequence[bytes], *, ends: bool = True) -> bytes:
    """An encrypted file whose chunks end where the parts do; `ends` says whether it has its last chunk."""
    file = io.BytesIO()
    writer = EncryptedWriter(file, HEADER, KEY)
    for part in parts:
        writer.write(part)
        writer.flush()
    if ends:
        writer.end()
    return file.getvalue()


def reader(content: bytes) -> EncryptedReader:
    return EncryptedReader(io.BytesIO(content), OWN)


def places(content: bytes) -> list[tuple[int, int]]:
    """Start and end of each chunk in the file, with its length."""
    found, at = [], HEADER_BYTES
    while at < len(content):
        (word,) = struct.unpack_from("<I", content, at)
        end = at + 4 + (word & ~(1 << 31)) + 16
        found.append((at, end))
        at = end
    return found


def read_all(content: bytes) -> bytes:
    return io.BufferedReader(reader(content)).read()


CONTENTS = st.lists(st.binary(max_size=300) | st.integers(0, 3).map(lambda n: bytes(n * CHUNK_BYTES // 2)), max_size=6)


@given(CONTENTS)
def test_any_content_comes_back(parts: list[bytes]) -> None:
    whole = reader(encrypted(parts))
    assert (whole.cut, whole.problem) == (False, "")
    assert io.BufferedReader(whole).read() == b"".join(parts)


@given(
    CONTENTS,
    st.lists(st.tuples(st.sampled_from(("seek", "back", "on", "read")), st.integers(0, 200_000)), max_size=12),
)
def test_any_way_of_reading_gives_the_plain_bytes(parts: list[bytes], steps: list[tuple[str, int]]) -> None:
    content = b"".join(parts)
    plain: IO[bytes] = io.BytesIO(content)
    file = cast(IO[bytes], io.BufferedReader(reader(encrypted(parts)), 4096))
    for step, number in steps:
        match step:
            case "seek":
                assert file.seek(number) == plain.seek(number)
            case "back":
                back = -min(number, len(content))
                assert file.seek(back, 2) == plain.seek(back, 2)
            case "on":
                assert file.seek(number, 1) == plain.seek(number, 1)
            case "read":
                assert file.read(number) == plain.read(number)
        assert file.tell() == plain.tell()


def test_a_place_before_the_start_is_refused() -> None:
    with pytest.raises(ValueError, match="before the start"):
        reader(encrypted([b"abc"])).seek(-1)


@given(st.lists(st.binary(min_size=1, max_size=40), min_size=1, max_size=4), st.data())
def test_each_changed_bit_is_found(parts: list[bytes], data: st.DataObject) -> None:
    content = bytearray(encrypted(parts))
    at = data.draw(st.integers(0, len(content) - 1))
    content[at] ^= 1 << data.draw(st.integers(0, 7))
    if at < len(MAGIC):
        assert not is_encrypted(io.BytesIO(bytes(content)))
        return
    try:
        found = reader(bytes(content))
    except CannotDecrypt:
        assert at < HEADER_BYTES
        return
    try:
        io.BufferedReader(found).read()
    except DamagedChunk:
        return
    assert found.problem or found.cut


@given(st.lists(st.binary(min_size=1, max_size=40), min_size=3, max_size=5, unique=True), st.data())
def test_a_moved_repeated_or_removed_chunk_is_found(parts: list[bytes], data: st.DataObject) -> None:
    content = encrypted(parts)
    chunks = [content[start:end] for start, end in places(content)]
    order = data.draw(st.lists(st.sampled_from(range(len(chunks))), max_size=len(chunks) + 1))
    if order == list(range(len(order))):  # the file itself, or a cut one
        return
    found = reader(content[:HEADER_BYTES] + b"".join(chunks[number] for number in order))
    if not found.problem:
        with pytest.raises(DamagedChunk):
            io.BufferedReader(found).read()


def test_a_chunk_of_another_file_is_found() -> None:
    one, other = encrypted([b"first", b"second"]), io.BytesIO()
    writer = EncryptedWriter(other, *Header.make(PUBLIC))
    for part in (b"third", b"fourth"):
        writer.write(part)
        writer.flush()
    writer.end()
    (start, end), *_ = places(one)
    (begin, stop), *_ = places(other.getvalue())
    with pytest.raises(DamagedChunk, match="chunk 0"):
        read_all(one[:start] + other.getvalue()[begin:stop] + one[end:])


@given(st.lists(st.binary(min_size=1, max_size=40), max_size=5), st.data())
def test_a_cut_file_is_read_up_to_its_last_whole_chunk_and_says_so(parts: list[bytes], data: st.DataObject) -> None:
    content = encrypted(parts)
    length = data.draw(st.integers(0, len(content) - 1))
    if length < HEADER_BYTES:
        with pytest.raises(CannotDecrypt, match="cut within its head"):
            reader(content[:length])
        return
    found = reader(content[:length])
    whole = sum(end <= length for _, end in places(content))
    assert found.cut
    assert io.BufferedReader(found).read() == b"".join(parts[:whole])


def test_a_forged_end_is_found() -> None:
    """A file that was cut between chunks does not become whole by an empty last chunk of somebody else."""
    content = encrypted([b"one", b"two"])
    start, _ = places(content)[1]
    assert "changed" in reader(content[:start] + struct.pack("<I", 1 << 31) + bytes(16)).problem


def test_bytes_after_the_end_and_impossible_lengths_are_found() -> None:
    content = encrypted([b"one"])
    assert "more bytes" in reader(content + b"x").problem
    assert "impossible length" in reader(content[:HEADER_BYTES] + b"\xff\xff\xff\x7f" + content).problem


def test_without_the_damaged_chunk_the_others_are_read() -> None:
    content = bytearray(encrypted([b"one", b"two", b"three"]))
    content[places(bytes(content))[1][0] + 5] ^= 1
    found = reader(bytes(content))
    found.skips_damage = True
    assert io.BufferedReader(found).read() == b"one\0\0\0three"


def test_another_key_and_another_version_open_nothing() -> None:
    content = encrypted([b"one"])
    _, other = zmq.curve_keypair()
    with pytest.raises(CannotDecrypt, match="cannot be opened"):
        EncryptedReader(io.BytesIO(content), other)
    with pytest.raises(CannotDecrypt, match="format 2"):
        reader(MAGIC + b"\x02" + content[len(MAGIC) + 1 :])


def test_nothing_of_the_content_is_in_the_file_and_no_two_files_are_alike() -> None:
    files = []
    for _ in range(2):
        file = io.BytesIO()
        writer = EncryptedWriter(file, *Header.make(PUBLIC))
        writer.write(b"pseudonym P-0417 " * 100)
        writer.end()
        files.append(file.getvalue())
    assert b"P-0417" not in files[0]
    assert files[0][41:] != files[1][41:]


@pytest.mark.parametrize("fails", [False, True])
def test_a_file_that_was_not_finished_has_no_end(fails: bool, tmp_path: Path) -> None:
    path = tmp_path / "file"
    with suppress(RuntimeError), EncryptedWriter(path.open("wb"), HEADER, KEY) as writer:
        writer.write(b"one")
        writer.flush()
        writer.write(b"two")
        if fails:
            raise RuntimeError
    with EncryptedReader(path.open("rb"), OWN) as found:
        assert found.cut is fails
        assert io.BufferedReader(found).read() == (b"one" if fails else b"onetwo")
    with path.open("wb") as file:
        abandoned = EncryptedWriter(file, HEADER, KEY)
        abandoned.flush()
        del abandoned
    assert path.stat().st_size == HEADER_BYTES


GOLDEN_SECRET = z85.encode(bytes(range(32)))
GOLDEN_KEY = bytes(range(32, 64))
GOLDEN = bytes.fromhex(
    "89544143454e430a018f40c5adb68f25624ae5b214ea767a6ec94d829d3d7b5e1ad1ba6f3e2138285f56e62cd0b815c8"
    "63d9cf478975c49c647c2717d4f1fbe8083e9a052ecaa65b6a8f5a4a078e4b0196930c1f5e96c93b72d373a64285804f"
    "cd428e26531951bf4935f7c6c4e54a39f932a9e2bf79da3c1f000102030405060708090a0b0c0d0e040000005daa4643"
    "b36826905ba58c7fc985cac9db9be36e04000080dba2321b4efd625a55e4e3ee34a2555ae1255371"
)
"""A file of two chunks, `felt` and `seen`."""


def test_golden_bytes() -> None:
    assert is_encrypted(io.BytesIO(GOLDEN))
    golden = EncryptedReader(io.BytesIO(GOLDEN), GOLDEN_SECRET)
    assert golden.header.public_key.encode() == zmq.curve_public(GOLDEN_SECRET)
    assert io.BufferedReader(golden).read() == b"feltseen"
    file = io.BytesIO()
    writer = EncryptedWriter(file, Header(golden.header.recipient, golden.header.sealed, bytes(range(15))), GOLDEN_KEY)
    for part in (b"felt", b"seen"):
        writer.flush()
        writer.write(part)
    writer.end()
    assert file.getvalue() == GOLDEN
