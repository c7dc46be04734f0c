import contextlib
import json
import os
import stat
import struct
import threading
import time
from collections import Counter
from pathlib import Path
from typing import IO, Any, cast

import pytest
from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap.records import Message
from mcap.stream_reader import StreamReader

from common import recording
from common.recording import Recorder, recording_figures
from common.software_version import software_version

SCHEMAS = {"touch": {"type": "array", "description": "a packet"}, "event": {"type": "object"}}


@pytest.fixture(autouse=True)
def _no_pause(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recording, "FLUSH_S", 0.002)


def record(path: Path, messages: int) -> Recorder:
    with Recorder(path, SCHEMAS, {"configuration": "rate_hz = 500.0\n", "key": "curve:abc"}) as recorder:
        for n in range(messages):
            recorder.write("touch", 10**12 + n * 2_000_000, n.to_bytes(4, "little") * 25)
            if n % 10 == 0:
                recorder.write("event", 10**12 + n * 2_000_000, b"event")
    return recorder


def test_the_public_reader_finds_everything(tmp_path: Path) -> None:
    recorder = record(tmp_path / "s.mcap", 1000)
    assert (recorder.written, recorder.lost, recorder.failed) == (Counter(touch=1000, event=100), 0, None)
    with (tmp_path / "s.mcap").open("rb") as file:
        reader = make_reader(file)
        summary = reader.get_summary()
        assert summary is not None
        assert summary.statistics is not None
        counts = summary.statistics.channel_message_counts
        assert {c.topic: counts[c.id] for c in summary.channels.values()} == {"touch": 1000, "event": 100}
        assert {c.message_encoding for c in summary.channels.values()} == {"msgpack"}
        assert {s.name: json.loads(s.data) for s in summary.schemas.values()} == SCHEMAS
        (metadata,) = list(reader.iter_metadata())
        assert metadata.metadata.pop("version") == software_version()
        assert metadata.metadata == {"configuration": "rate_hz = 500.0\n", "key": "curve:abc"}
        times = [(m.log_time, m.publish_time, m.data[:4]) for _, c, m in reader.iter_messages() if c.topic == "touch"]
    start = 10**12
    assert times == [(start + n * 2_000_000, start + n * 2_000_000, n.to_bytes(4, "little")) for n in range(1000)]


def test_between_two_flushes_a_recording_grows_by_one_chunk_however_much_is_written(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Each chunk of the file costs memory until the file is closed: a session of hours must not pay by the byte."""
    monkeypatch.setattr(recording, "FLUSH_S", 0.25)
    record(tmp_path / "s.mcap", 1500)
    with (tmp_path / "s.mcap").open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    assert summary.statistics is not None
    # A busy machine may let a flush or two fall into the writing of these 200 kB.
    assert 1 <= summary.statistics.chunk_count <= 4


def test_a_file_cut_anywhere_still_yields_its_closed_chunks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recording, "CHUNK_BYTES", 16 * 1024)
    record(tmp_path / "s.mcap", 2000)
    whole = (tmp_path / "s.mcap").read_bytes()
    for share in (0.3, 0.5, 0.77):
        cut = tmp_path / "cut.mcap"
        cut.write_bytes(whole[: int(len(whole) * share)])
        found: list[Message] = []
        # The reader says in more ways than one that the file ends in the middle of a record.
        with cut.open("rb") as file, contextlib.suppress(McapError, struct.error):
            for item in StreamReader(file).records:
                found.extend([item] if isinstance(item, Message) else [])
        numbers = [int.from_bytes(m.data[:4], "little") for m in found if m.data != b"event"]
        assert numbers == list(range(len(numbers)))
        # At most the chunk under way is lost; chunk and index take some bytes more than the messages.
        chunk_messages = recording.CHUNK_BYTES / 131
        assert len(numbers) >= 2000 * share * 0.95 - 2 * chunk_messages


class SlowDisk:
    """A path whose file takes nothing while the disk is stuck."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.moving = threading.Event()
        self.moving.set()

    def is_file(self) -> bool:
        return False

    def open(self, mode: str) -> IO[bytes]:
        self.file = self.path.open("wb", buffering=0)
        return cast(IO[bytes], self)

    def write(self, data: bytes) -> int:
        self.moving.wait(30.0)
        return self.file.write(data)

    def __getattr__(self, name: str) -> Any:
        return getattr(self.file, name)


def test_a_stuck_disk_never_makes_the_loop_wait_and_what_does_not_fit_is_counted_and_said_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr(recording, "_QUEUE_LENGTH", 10)
    disk = SlowDisk(tmp_path / "s.mcap")
    recorder = Recorder(cast(Path, disk), SCHEMAS, {})
    disk.moving.clear()
    for n in range(1000):
        recorder.write("touch", n, b"x")  # each comes back although nothing moves before all are written
    assert not disk.moving.is_set()
    lost = recorder.lost
    # Ten wait in the queue; ten more may have been taken from it before the disk was stuck.
    assert 980 <= lost <= 990
    disk.moving.set()
    while recorder.written["touch"] < 1000 - lost:
        time.sleep(0.001)
    for n in range(3):
        recorder.write("touch", 2000 + n, b"x")
    recorder.close()
    assert recorder.failed is None
    assert recorder.written == Counter(touch=1000 - lost + 3)
    assert [record.levelname for record in caplog.records] == ["WARNING"]
    assert "the disk is slower than the data" in caplog.text


def test_a_disk_that_stays_stuck_does_not_keep_the_process(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recording, "_CLOSE_S", 0.05)
    disk = SlowDisk(tmp_path / "s.mcap")
    recorder = Recorder(cast(Path, disk), SCHEMAS, {})
    disk.moving.clear()
    recorder.write("touch", 1, b"x")
    recorder.close()
    assert recorder.failed == "the disk took nothing for 0.05 s"
    assert recorder.lost == 1
    assert recording_figures(recorder) == {"recorded": {}, "recording_lost": 1, "recording_failed": recorder.failed}
    disk.moving.set()
    recorder._thread.join(30.0)


def test_a_full_disk_stops_the_recording_and_not_the_loop(caplog: pytest.LogCaptureFixture) -> None:
    if not Path("/dev/full").exists():
        pytest.skip("no /dev/full here")
    recorder = Recorder(Path("/dev/full"), SCHEMAS, {})
    for n in range(3000):
        recorder.write("touch", n, bytes(100))
    recorder.close()
    assert recorder.failed is not None
    assert "space" in recorder.failed
    recorder.write("touch", 0, b"x")
    assert recorder.lost == 3001
    assert recorder.written.total() == 0
    assert [record.levelname for record in caplog.records] == ["ERROR"]


def test_a_writer_that_dies_of_anything_stops_the_recording_and_not_the_loop(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def die(*_: object, **__: object) -> None:
        raise RuntimeError("out of order")

    monkeypatch.setattr("mcap.writer.Writer.add_message", die)
    recorder = Recorder(tmp_path / "s.mcap", SCHEMAS, {})
    recorder.write("touch", 1, b"x")
    recorder._thread.join(30.0)
    for n in range(10):
        recorder.write("touch", n, b"x")
    recorder.close()
    assert recording_figures(recorder) == {"recorded": {}, "recording_lost": 11, "recording_failed": "out of order"}
    assert [record.getMessage() for record in caplog.records] == ["recording stopped: out of order"]


def test_an_unknown_stream_is_the_callers_error_and_the_recording_goes_on(tmp_path: Path) -> None:
    with Recorder(tmp_path / "s.mcap", SCHEMAS, {}) as recorder:
        with pytest.raises(ValueError, match="'tuoch' is not in the recording's schemas: touch, event"):
            recorder.write("tuoch", 1, b"x")
        recorder.write("touch", 2, b"x")
    assert (recorder.written, recorder.lost, recorder.failed) == (Counter(touch=1), 0, None)


def test_attached_files_come_back_whole(tmp_path: Path) -> None:
    table = bytes(range(256)) * 300
    with Recorder(tmp_path / "s.mcap", SCHEMAS, {}, {"materials.json": table, "empty.json": b""}):
        pass
    with (tmp_path / "s.mcap").open("rb") as file:
        found = {attached.name: attached.data for attached in make_reader(file).iter_attachments()}
    assert found == {"materials.json": table, "empty.json": b""}


def test_what_was_written_is_in_the_file_without_closing_it(tmp_path: Path) -> None:
    """However little it is: the chunk under way is ended on time, not when it is full."""
    recorder = Recorder(tmp_path / "s.mcap", SCHEMAS, {})
    recorder.write("touch", 7, b"seven")
    while not recorder.written:
        time.sleep(0.001)
    found: list[bytes] = []
    with (tmp_path / "s.mcap").open("rb") as file, contextlib.suppress(McapError, struct.error):
        found.extend(item.data for item in StreamReader(file).records if isinstance(item, Message))
    assert found == [b"seven"]
    recorder.close()


def test_what_comes_after_the_end_is_lost_and_counted(tmp_path: Path) -> None:
    recorder = record(tmp_path / "s.mcap", 1)
    recorder.write("touch", 1, b"x")
    assert recorder.lost == 1


def test_a_site_that_does_not_record_has_figures_too() -> None:
    assert recording_figures(None) == {"recorded": {}, "recording_lost": 0, "recording_failed": ""}


def test_a_folder_that_is_not_there_is_said(tmp_path: Path) -> None:
    with pytest.raises(OSError, match="No such file"):
        Recorder(tmp_path / "absent" / "s.mcap", SCHEMAS, {})


def test_closing_twice_is_no_error(tmp_path: Path) -> None:
    recorder = record(tmp_path / "s.mcap", 1)
    recorder.close()


def test_a_durable_recording_calls_written_only_what_the_disk_has_and_does_not_wait_for_the_next_flush(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(recording, "FLUSH_S", 60.0)
    synced: list[int] = []
    moving = threading.Event()

    def sync(number: int) -> None:
        if stat.S_ISREG(os.fstat(number).st_mode):
            assert moving.wait(30.0)
            synced.append(os.fstat(number).st_size)

    monkeypatch.setattr(os, "fsync", sync)
    recorder = Recorder(tmp_path / "s.mcap", SCHEMAS, {}, durable=True)
    recorder.write("touch", 7, b"seven")
    while recorder._queue.qsize():
        time.sleep(0.001)
    assert not recorder.written, "the disk has not got it yet"
    moving.set()
    while not recorder.written:
        time.sleep(0.001)
    assert synced == [(tmp_path / "s.mcap").stat().st_size]
    recorder.close()
    assert synced[-1] == (tmp_path / "s.mcap").stat().st_size
