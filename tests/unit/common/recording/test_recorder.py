import contextlib
import errno
import json
import os
import signal
import socket
import stat
import struct
import threading
import time
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Any, cast
from unittest.mock import Mock

import msgpack
import pytest
from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap.records import Message
from mcap.stream_reader import StreamReader

from common.recording import recorder as recording
from common.recording import writer_process
from common.recording.clock_anchor import ClockAnchor
from common.recording.recorder import Recorder, recording_figures
from common.version import software_version
from tests.waiting import wait_until
from tests.writer_thread import write_in_a_thread

SCHEMAS = {"touch": {"type": "array", "description": "a packet"}, "event": {"type": "object"}}


METADATA = {"configuration": "rate_hz = 500.0\n", "key": "curve:abc"}
ATTACHED = {"materials.json": bytes(range(256)) * 300, "empty.json": b""}


def record(path: Path, messages: int, attached: dict[str, bytes] | None = None) -> Recorder:
    with Recorder(path, SCHEMAS, METADATA, attached) as recorder:
        for n in range(messages):
            recorder.write("touch", 10**12 + n * 2_000_000, n.to_bytes(4, "little") * 25)
            if n % 10 == 0:
                recorder.write("event", 10**12 + n * 2_000_000, b"event")
    return recorder


def figures(recorded: dict[str, int], lost: int, failed: str, failed_ns: int | None) -> dict[str, object]:
    return {
        "recorded": recorded,
        "recording_lost": lost,
        "recording_failed": failed,
        "disk_full": False,
        "recording_failed_ns": failed_ns,
    }


def test_the_public_reader_finds_everything(tmp_path: Path) -> None:
    recorder = record(tmp_path / "s.mcap", 1000, ATTACHED)
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
        anchor = ClockAnchor.read(metadata.metadata)
        assert anchor is not None
        assert metadata.metadata == METADATA | anchor.metadata() | {"version": software_version()}
        assert {attached.name: attached.data for attached in reader.iter_attachments()} == ATTACHED
        times = [(m.log_time, m.publish_time, m.data[:4]) for _, c, m in reader.iter_messages() if c.topic == "touch"]
    start = 10**12
    assert times == [(start + n * 2_000_000, start + n * 2_000_000, n.to_bytes(4, "little")) for n in range(1000)]


def test_a_recording_grows_by_one_chunk_between_two_flushes_at_any_rate(tmp_path: Path) -> None:
    """Each chunk of the file costs memory until the file is closed: a session of hours must not pay by the byte."""
    record(tmp_path / "s.mcap", 1500)
    with (tmp_path / "s.mcap").open("rb") as file:
        summary = make_reader(file).get_summary()
    assert summary is not None
    assert summary.statistics is not None
    # A busy machine may let a flush or two fall into the writing of these 200 kB.
    assert 1 <= summary.statistics.chunk_count <= 4


def readable(path: Path) -> list[bytes]:
    """Payloads of all messages of a file that may end in the middle of a record."""
    found = []
    # The reader says in more ways than one that it does.
    with path.open("rb") as file, contextlib.suppress(McapError, struct.error):
        found.extend(item.data for item in StreamReader(file).records if isinstance(item, Message))
    return found


def test_a_file_cut_anywhere_still_yields_its_closed_chunks(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write_in_a_thread(monkeypatch)
    monkeypatch.setattr(writer_process, "CHUNK_BYTES", 16 * 1024)
    record(tmp_path / "s.mcap", 2000)
    whole = (tmp_path / "s.mcap").read_bytes()
    for share in (0.3, 0.5, 0.77):
        cut = tmp_path / "cut.mcap"
        cut.write_bytes(whole[: int(len(whole) * share)])
        numbers = [int.from_bytes(data[:4], "little") for data in readable(cut) if data != b"event"]
        assert numbers == list(range(len(numbers)))
        # At most the chunk under way is lost; chunk and index take some bytes more than the messages.
        chunk_messages = writer_process.CHUNK_BYTES / 131
        assert len(numbers) >= 2000 * share * 0.95 - 2 * chunk_messages


class SlowDisk:
    """A path whose file takes nothing while the disk is stuck."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self.moving = threading.Event()
        self.moving.set()

    def is_file(self) -> bool:
        return False

    def open(self) -> IO[bytes]:
        self.file = self.path.open("wb", buffering=0)
        return cast(IO[bytes], self)

    def write(self, data: bytes) -> int:
        self.moving.wait(30.0)
        return self.file.write(data)

    def __enter__(self) -> "SlowDisk":
        return self

    def __exit__(self, *_: object) -> None:
        """Open until the test has ended."""

    def __getattr__(self, name: str) -> Any:
        return getattr(self.file, name)


@pytest.fixture
def disk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[SlowDisk]:
    write_in_a_thread(monkeypatch)
    disk = SlowDisk(tmp_path / "s.mcap")
    monkeypatch.setattr(recording, "create_private", lambda _: disk.open())
    yield disk
    disk.moving.set()
    disk.file.close()


def test_a_stuck_disk_never_makes_the_loop_wait_and_what_does_not_fit_is_counted(
    disk: SlowDisk, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(recording, "_QUEUE_LENGTH", 10)
    disk.moving.clear()
    recorder = Recorder(cast(Path, disk), SCHEMAS, {})
    payload = bytes(50_000)
    for n in range(1000):
        recorder.write("touch", n * 2_000_000, payload)  # each comes back although nothing moves before all are written
    assert not disk.moving.is_set()
    lost = recorder.lost
    # Ten wait in the queue, ten or a few more are being handed over; the sockets hold a few hundred kilobytes.
    assert 900 <= lost <= 990
    disk.moving.set()
    wait_until(lambda: recorder.written["touch"] == 1000 - lost)
    for n in range(3):
        recorder.write("touch", 10**10 + n, b"x")
    recorder.close()
    assert recorder.failed is None
    assert recorder.written == Counter(touch=1000 - lost + 3)


def test_a_disk_that_stays_stuck_does_not_keep_the_process(disk: SlowDisk, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recording, "_CLOSE_S", 0.05)
    disk.moving.clear()
    recorder = Recorder(cast(Path, disk), SCHEMAS, {})
    recorder.write("touch", 1, b"x")
    recorder.close()
    assert recorder.failed == "the disk accepted no data for 0.05 s"
    assert recorder.lost == 1
    assert recording_figures(recorder) == figures({}, 1, "the disk accepted no data for 0.05 s", recorder.failed_ns)
    disk.moving.set()
    recorder._process.wait()


def test_a_full_disk_stops_the_recording_and_not_the_loop() -> None:
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


def test_a_writer_that_dies_of_anything_stops_the_recording_and_not_the_loop(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def die(*_: object, **__: object) -> None:
        raise RuntimeError("out of order")

    monkeypatch.setattr("mcap.writer.Writer.add_message", die)
    write_in_a_thread(monkeypatch)
    recorder = Recorder(tmp_path / "s.mcap", SCHEMAS, {})
    recorder.write("touch", 1, b"x")
    wait_until(lambda: recorder.failed)
    for n in range(10):
        recorder.write("touch", n, b"x")
    recorder.close()
    assert recording_figures(recorder) == figures({}, 11, "out of order", recorder.failed_ns)


def test_a_writer_that_is_killed_stops_the_recording_and_not_the_loop(tmp_path: Path) -> None:
    recorder = Recorder(tmp_path / "s.mcap", SCHEMAS, {})
    recorder.write("touch", 1, b"x")
    wait_until(lambda: recorder.written)
    killed_ns = time.monotonic_ns()
    os.kill(recorder._process.pid, signal.SIGKILL)
    wait_until(lambda: recorder.failed)
    for n in range(10):
        recorder.write("touch", 10**9 * n, b"x")
    recorder.close()
    why = "the process that writes it has ended"
    assert recorder.failed_ns is not None
    assert killed_ns <= recorder.failed_ns <= time.monotonic_ns()
    assert recording_figures(recorder) == figures({"touch": 1}, 10, why, recorder.failed_ns)


def test_a_signal_to_all_processes_does_not_end_the_recording_before_its_owner(tmp_path: Path) -> None:
    with Recorder(tmp_path / "s.mcap", SCHEMAS, {}) as recorder:
        recorder.write("touch", 1, b"x")
        wait_until(lambda: recorder.written)
        for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP):
            os.kill(recorder._process.pid, number)
        recorder.write("touch", 10**9, b"y")
    assert (recorder.written, recorder.lost, recorder.failed) == (Counter(touch=2), 0, None)


def test_rows_already_handed_over_survive_their_owner(tmp_path: Path) -> None:
    recorder = Recorder(tmp_path / "s.mcap", SCHEMAS, {})
    for n in range(5):
        recorder.write("touch", 10**9 * (n + 1), b"x")
    recorder._writer.close()  # as if the owner had been killed
    assert recorder._process.wait() == 0
    with (tmp_path / "s.mcap").open("rb") as file:
        assert [message.log_time for _, _, message in make_reader(file).iter_messages()] == [
            10**9 * (n + 1) for n in range(5)
        ]


def test_an_owner_that_never_listens_does_not_stop_the_writer(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """A report that does not fit into the socket is part of the next one."""
    monkeypatch.setattr(writer_process, "FLUSH_S", 0.0)
    ours, theirs = socket.socketpair()
    theirs.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 4096)
    head = {"metadata": {}, "schemas": {"touch": b"{}"}, "attachments": {}, "durable": False}
    with ours, theirs, (tmp_path / "s.mcap").open("wb") as file:
        writer = threading.Thread(target=writer_process.write_recording, args=(theirs, file))
        writer.start()
        ours.sendall(msgpack.packb(head))
        for n in range(2000):
            ours.sendall(msgpack.packb([[0, n, b"x"]]))
        ours.sendall(msgpack.packb(None))
        reports = msgpack.Unpacker()
        last = [[], None, False, False]
        while not last[3]:
            reports.feed(ours.recv(1 << 16))
            last = [last, *reports][-1]
        writer.join(30.0)
    assert last == [[2000], None, False, True]


@pytest.mark.parametrize(("reason", "full"), [(errno.ENOSPC, True), (errno.EDQUOT, True), (errno.EIO, False)])
def test_a_writer_reports_whether_there_is_no_room(reason: int, full: bool) -> None:
    ours, theirs = socket.socketpair()
    head = {"metadata": {}, "schemas": {"touch": b"{}"}, "attachments": {}, "durable": False}
    with ours, theirs:
        ours.sendall(msgpack.packb(head))
        writer_process.write_recording(theirs, Mock(write=Mock(side_effect=OSError(reason, os.strerror(reason)))))
        assert msgpack.unpackb(ours.recv(1 << 16))[2:] == [full, True]


def test_an_unknown_stream_is_the_callers_error_and_the_recording_continues(tmp_path: Path) -> None:
    with Recorder(tmp_path / "s.mcap", SCHEMAS, {}) as recorder:
        with pytest.raises(ValueError, match="'tuoch' is not in the recording's schemas: touch, event"):
            recorder.write("tuoch", 1, b"x")
        recorder.write("touch", 2, b"x")
    assert (recorder.written, recorder.lost, recorder.failed) == (Counter(touch=1), 0, None)


def test_written_rows_are_in_the_file_before_it_is_closed(tmp_path: Path) -> None:
    """However little it is: the chunk under way is ended on time, not when it is full."""
    recorder = Recorder(tmp_path / "s.mcap", SCHEMAS, {})
    recorder.write("touch", 7, b"seven")
    wait_until(lambda: recorder.written)
    assert readable(tmp_path / "s.mcap") == [b"seven"]
    recorder.close()


def test_a_site_without_a_recording_knows_it(tmp_path: Path) -> None:
    assert recording_figures(None) == figures({}, 0, "", None)
    with pytest.raises(OSError, match="No such file"):
        Recorder(tmp_path / "absent" / "s.mcap", SCHEMAS, {})


def test_closing_twice_is_no_error_and_rows_after_the_end_are_counted_as_lost(tmp_path: Path) -> None:
    recorder = record(tmp_path / "s.mcap", 1)
    recorder.close()
    recorder.write("touch", 1, b"x")
    assert recorder.lost == 1


def test_a_durable_recording_counts_only_rows_on_the_disk_and_flushes_at_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(writer_process, "FLUSH_S", 60.0)
    write_in_a_thread(monkeypatch)
    synced: list[int] = []
    asked, moving = threading.Event(), threading.Event()
    moving.set()

    def sync(number: int) -> None:
        if stat.S_ISREG(os.fstat(number).st_mode):
            asked.set()
            assert moving.wait(30.0)
            synced.append(os.fstat(number).st_size)

    monkeypatch.setattr(os, "fsync", sync)
    recorder = Recorder(tmp_path / "s.mcap", SCHEMAS, {}, durable=True)
    wait_until(lambda: synced)  # the head is there
    moving.clear()
    asked.clear()
    recorder.write("touch", 7, b"seven")
    assert asked.wait(30.0)
    assert not recorder.written, "the disk has not got it yet"
    moving.set()
    wait_until(lambda: recorder.written)
    assert synced[-1] == (tmp_path / "s.mcap").stat().st_size
    recorder.close()
    assert synced[-1] == (tmp_path / "s.mcap").stat().st_size


def test_a_recording_reaches_the_disk_every_few_seconds_without_waiting_for_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(writer_process, "SYNC_S", 0.01)
    write_in_a_thread(monkeypatch)
    synced: list[int] = []
    asked, moving = threading.Event(), threading.Event()

    def sync(number: int) -> None:
        asked.set()
        assert moving.wait(30.0)
        synced.append(os.fstat(number).st_size)

    monkeypatch.setattr(os, "fdatasync", sync)
    with Recorder(tmp_path / "s.mcap", SCHEMAS, {}) as recorder:
        assert asked.wait(30.0)
        recorder.write("touch", 7, b"seven")
        wait_until(lambda: recorder.written)
        assert synced == [], "the disk is still busy"
        moving.set()
        wait_until(lambda: synced and synced[-1] == (tmp_path / "s.mcap").stat().st_size)
    assert synced[-1] == (tmp_path / "s.mcap").stat().st_size, "the index is on the disk"


def test_a_disk_that_loses_what_it_took_fails_the_recording(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def sync(number: int) -> None:
        raise OSError(errno.EIO, os.strerror(errno.EIO))

    monkeypatch.setattr(os, "fdatasync", sync)
    monkeypatch.setattr(writer_process, "SYNC_S", 0.01)
    write_in_a_thread(monkeypatch)
    recorder = Recorder(tmp_path / "s.mcap", SCHEMAS, {})
    wait_until(lambda: recorder.failed)
    recorder.close()
    assert recorder.failed == "[Errno 5] Input/output error"
