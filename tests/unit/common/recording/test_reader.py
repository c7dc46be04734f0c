"""Messages come in order of time, whatever the times of the chunks are, and their memory is limited."""

import tracemalloc
from collections.abc import Iterable, Sequence
from pathlib import Path
from unittest.mock import patch

import pytest
from mcap.records import ChunkIndex
from mcap.writer import CompressionType, Writer

from common.privacy.recording_file import open_recording
from common.recording import reader as reader_module
from common.recording.mcap_records import MESSAGE_BYTES
from common.recording.reader import DamagedRecording, RecordingReader

STREAMS = ("first", "second")
CHUNKS: dict[str, list[list[int]]] = {
    "one after the other": [[1, 2, 3], [4, 5, 6], [7, 8]],
    "all of one time": [[5, 5, 5], [5, 5], [5, 5, 5]],
    "an end that the next begin with": [[3, 5, 5], [5, 5, 5], [5, 7], [5, 6]],
    "a clock that began again": [[100, 101, 3, 4], [5, 6], [102, 7]],
    "backwards": [[9, 8], [7, 6], [5, 4]],
    "all of the same times": [[1, 5, 9], [1, 5, 9], [1, 5, 9]],
}


def made(path: Path, chunks: Iterable[Sequence[int]], content: bytes = b"") -> list[tuple[int, int]]:
    """Write chunks of messages at these times, ns; return time and number of each message in the file's order."""
    written = []
    with path.open("wb") as file:
        writer = Writer(file, chunk_size=1 << 30, compression=CompressionType.ZSTD, enable_data_crcs=True)
        writer.start("teletaction", "teletaction")
        schema = writer.register_schema("any", "jsonschema", b"{}")
        channels = [writer.register_channel(stream, "msgpack", schema) for stream in STREAMS]
        for times_ns in chunks:
            for time_ns in times_ns:
                number = len(written)
                writer.add_message(channels[number % 2], time_ns, content, time_ns, number)
                written.append((time_ns, number))
            writer.flush()  # type: ignore[no-untyped-call]  # the library leaves it untyped
        writer.finish()  # type: ignore[no-untyped-call]
    return written


def read(path: Path, streams: Sequence[str] | None = None, from_ns: int | None = None) -> list[tuple[int, int]]:
    with open_recording(path) as file:
        messages = RecordingReader(path, file).messages(streams, from_ns)
        return [(message.log_time, message.sequence) for _, _, message in messages]


@pytest.mark.parametrize("name", CHUNKS)
def test_messages_come_in_order_of_time_and_those_of_one_time_in_the_files_order(tmp_path: Path, name: str) -> None:
    path = tmp_path / "a.mcap"
    written = sorted(made(path, CHUNKS[name]))
    assert read(path) == written
    for number, stream in enumerate(STREAMS):
        assert read(path, [stream]) == [each for each in written if each[1] % 2 == number]
    assert read(path, from_ns=5) == [each for each in written if each[0] >= 5]
    assert read(path, ["no stream"]) == []


@pytest.mark.parametrize("name", ["one after the other", "all of one time"])
def test_chunks_that_do_not_overlap_are_in_memory_one_by_one(tmp_path: Path, name: str) -> None:
    path = tmp_path / "a.mcap"
    times_ns = {"one after the other": lambda k: [k, k, k], "all of one time": lambda _: [5, 5, 5]}[name]
    made(path, map(times_ns, range(40)), bytes(100_000))
    with open_recording(path) as file:
        reader = RecordingReader(path, file)
        tracemalloc.start()
        try:
            assert sum(1 for _ in reader.messages()) == 120
            assert tracemalloc.get_traced_memory()[1] < 4 * 300_000
        finally:
            tracemalloc.stop()


def test_chunks_of_the_same_times_fill_no_memory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """All chunks must be open before the first message that is not at their begin: a few bytes would fill a machine."""
    path = tmp_path / "a.mcap"
    made(path, [[1, 9]] * 10, bytes(100_000))
    monkeypatch.setattr(reader_module, "LONGEST_RECORD_BYTES", 11 * (100_000 + MESSAGE_BYTES))
    assert len(read(path)) == 20
    monkeypatch.setattr(reader_module, "LONGEST_RECORD_BYTES", 10 * (100_000 + MESSAGE_BYTES))
    with pytest.raises(DamagedRecording, match="too many of its chunks are of the same time"):
        read(path)


@pytest.mark.parametrize(("field", "moved_ns"), [("message_start_time", 5), ("message_end_time", -5)])
def test_an_index_with_times_other_than_the_chunks_changes_no_order(tmp_path: Path, field: str, moved_ns: int) -> None:
    path, write = tmp_path / "a.mcap", ChunkIndex.write

    def moved(index: ChunkIndex, *to: object) -> None:
        setattr(index, field, getattr(index, field) + moved_ns)
        write(index, *to)  # type: ignore[arg-type]

    with patch.object(ChunkIndex, "write", moved):
        made(path, [[10, 20], [12, 22]])
    with pytest.raises(DamagedRecording, match="its index states other times than its chunks"):
        read(path)
