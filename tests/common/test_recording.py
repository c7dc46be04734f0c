import contextlib
import json
import struct
import threading
from collections import Counter
from pathlib import Path

import pytest
from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap.records import Message
from mcap.stream_reader import StreamReader

from common import recording
from common.recording import Recorder

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
        assert metadata.metadata == {"configuration": "rate_hz = 500.0\n", "key": "curve:abc"}
        times = [(m.log_time, m.publish_time, m.data[:4]) for _, c, m in reader.iter_messages() if c.topic == "touch"]
    start = 10**12
    assert times == [(start + n * 2_000_000, start + n * 2_000_000, n.to_bytes(4, "little")) for n in range(1000)]


def test_a_file_cut_anywhere_still_yields_its_closed_chunks(tmp_path: Path) -> None:
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


def test_what_does_not_fit_is_lost_and_counted_and_never_waits(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(recording, "_QUEUE_LENGTH", 10)
    blocked = threading.Event()
    monkeypatch.setattr(Recorder, "_write_queued", lambda self: not blocked.wait(5.0))
    recorder = Recorder(tmp_path / "s.mcap", SCHEMAS, {})
    for n in range(25):
        recorder.write("touch", n, b"x")
    assert recorder.lost == 15
    blocked.set()
    recorder.close()


def test_a_full_disk_stops_the_recording_and_not_the_loop(tmp_path: Path) -> None:
    if not Path("/dev/full").exists():
        pytest.skip("no /dev/full here")
    recorder = Recorder(Path("/dev/full"), SCHEMAS, {})
    for n in range(3000):
        recorder.write("touch", n, bytes(100))
    recorder.close()
    assert recorder.failed is not None
    assert "space" in recorder.failed
    recorder.write("touch", 0, b"x")
    assert recorder.lost >= 1


def test_a_folder_that_is_not_there_is_said(tmp_path: Path) -> None:
    with pytest.raises(OSError, match="No such file"):
        Recorder(tmp_path / "absent" / "s.mcap", SCHEMAS, {})


def test_closing_twice_is_no_error(tmp_path: Path) -> None:
    recorder = record(tmp_path / "s.mcap", 1)
    recorder.close()
