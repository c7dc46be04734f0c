"""A recording that was cut anywhere is made whole again, up to half a second before the cut."""

import os
import random
import shlex
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from mcap.reader import make_reader
from mcap.records import Chunk, McapRecord
from mcap.stream_reader import StreamReader

from common.recording import recorder as recording
from common.recording import writer_process
from common.recording.recorder import Recorder
from common.recording.truncated_mcap import TruncatedMcap
from teletaction.recordings.recover import Recovered, recover
from tests.commands import command, one_line
from tests.places import ROOT
from tests.unit.teletaction.held_recordings import held
from tests.waiting import wait_until
from tests.writer_thread import write_in_a_thread

CHILD = Path(__file__).with_name("recording_child.py")
ENVIRONMENT = {**os.environ, "PYTHONPATH": str(ROOT)}
SCHEMAS = {"touch": {"type": "array", "description": "a packet"}, "event": {"type": "object"}}
COUNT = 2000
LOST_AT_MOST_NS = 500_000_000


@pytest.fixture(scope="module", autouse=True)
def _small_chunks() -> Iterator[None]:
    """So that a short recording has many of them."""
    with pytest.MonkeyPatch.context() as patch:
        write_in_a_thread(patch)
        patch.setattr(writer_process, "CHUNK_BYTES", 16 * 1024)
        yield


@pytest.fixture(scope="module")
def whole(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    path = tmp_path_factory.mktemp("whole") / "s.mcap"
    with Recorder(path, SCHEMAS, {"configuration": "rate_hz = 500.0\n"}, {"table.json": b"{}" * 500}) as recorder:
        for n in range(COUNT):
            recorder.write("touch", 10**12 + n * 2_000_000, n.to_bytes(4, "little") * 25)
            if n % 10 == 0:
                recorder.write("event", 10**12 + n * 2_000_000, b"event")
    return path.read_bytes()


def recovered(path: Path, out: Path | None = None) -> Recovered:
    result = recover(path, out)
    assert result is not None
    return result


@pytest.mark.parametrize("share", [0.1, 0.2, 0.5, 0.9, 0.999])
def test_a_file_cut_anywhere_is_made_whole_with_metadata_and_attachments(
    tmp_path: Path, whole: bytes, share: float
) -> None:
    cut = tmp_path / "remote.mcap"
    cut.write_bytes(whole[: int(len(whole) * share)])
    result = recovered(cut)
    assert result.out == tmp_path / "remote-recovered.mcap"
    assert cut.read_bytes() == whole[: int(len(whole) * share)], "the original is not touched"
    restored = held(result.out)
    (tmp_path / "whole.mcap").write_bytes(whole)
    assert restored == held(tmp_path / "whole.mcap")[: len(restored)]
    assert result.messages.total() == len(restored) > COUNT * share - 2 * writer_process.CHUNK_BYTES / 131
    assert result.seconds == pytest.approx((restored[-1][1] - restored[0][1]) * 1e-9)
    assert 0 < result.unreadable_bytes < 2 * writer_process.CHUNK_BYTES
    with result.out.open("rb") as file:
        reader = make_reader(file)
        assert [entry.metadata["configuration"] for entry in reader.iter_metadata()] == ["rate_hz = 500.0\n"]
        assert [(entry.name, entry.data) for entry in reader.iter_attachments()] == [("table.json", b"{}" * 500)]
        summary = reader.get_summary()
        assert summary is not None
        assert {schema.name for schema in summary.schemas.values()} == set(SCHEMAS)
    assert recover(result.out) is None, "what was recovered is whole"


def ends_of_chunks(whole: bytes) -> list[int]:
    file = BytesIO(whole)
    return [file.tell() for record in StreamReader(file, emit_chunks=True).records if isinstance(record, Chunk)]


def test_only_whole_chunks_count(tmp_path: Path, whole: bytes) -> None:
    """A chunk of which the last byte is missing is not half believed."""
    end = ends_of_chunks(whole)[3]
    counts = []
    for cut_at in (end - 1, end):
        cut = tmp_path / f"{cut_at}.mcap"
        cut.write_bytes(whole[:cut_at])
        counts.append(recovered(cut).messages.total())
    assert counts[1] - counts[0] > 50


def test_a_damaged_chunk_is_left_out_and_the_rest_is_kept(tmp_path: Path, whole: bytes) -> None:
    path = tmp_path / "s.mcap"
    damaged = bytearray(whole)
    damaged[ends_of_chunks(whole)[3] - 100] ^= 1
    path.write_bytes(damaged)
    result = recovered(path)
    assert (result.damaged_parts, result.unreadable_bytes) == (1, 0)
    numbers = [int.from_bytes(data[:4], "little") for stream, _, data in held(result.out) if stream == "touch"]
    missing = sorted(set(range(COUNT)) - set(numbers))
    assert missing == list(range(missing[0], missing[-1] + 1))
    assert 50 < len(missing) < 2 * writer_process.CHUNK_BYTES / 131


@pytest.mark.long
def test_everything_before_any_damage_is_restored(tmp_path_factory: pytest.TempPathFactory, whole: bytes) -> None:
    folder = tmp_path_factory.mktemp("damaged")
    path, out = folder / "damaged.mcap", folder / "out.mcap"
    ends = ends_of_chunks(whole)

    @settings(max_examples=30, deadline=None)
    @given(st.integers(ends[0], len(whole) - 1), st.binary(min_size=1, max_size=40), st.integers(0, len(whole)))
    def check(at: int, junk: bytes, length: int) -> None:
        damaged = bytearray(whole[: max(length, at)])
        damaged[at : at + len(junk)] = junk
        path.write_bytes(damaged)
        out.unlink(missing_ok=True)
        result = recover(path, out)
        if result is None:
            assert len(damaged) == len(whole), "what is said to be whole has its end"
            return
        path.write_bytes(whole[: max(end for end in ends if end <= at)])
        (folder / "before.mcap").unlink(missing_ok=True)
        before = held(recovered(path, folder / "before.mcap").out)
        assert held(out)[: len(before)] == before

    check()


@pytest.mark.long
def test_a_recorder_and_its_writer_killed_lose_at_most_half_a_second(tmp_path: Path) -> None:
    moments = random.Random(3)
    for turn in range(5):
        path, progress = tmp_path / f"{turn}.mcap", tmp_path / f"{turn}.progress"
        progress.write_bytes(bytes(8))
        payload_bytes = moments.choice([0, 30, 300, 3000])
        child = subprocess.Popen(
            [sys.executable, str(CHILD), str(path), str(progress), str(payload_bytes)],
            env=ENVIRONMENT,
            start_new_session=True,
        )
        try:
            wait_until(lambda progress=progress: any(progress.read_bytes()), patience_s=60.0)
            time.sleep(moments.uniform(0.5, 1.3))
        finally:
            os.killpg(child.pid, signal.SIGKILL)  # and its writer, as when the machine stops
            child.wait()
        last_ns = int.from_bytes(progress.read_bytes(), "little")
        result = recovered(path)
        assert held(result.out)[-1][1] >= last_ns - LOST_AT_MOST_NS
        times = [time_ns for _, time_ns, _ in held(result.out)]
        assert times == sorted(times)
        assert len(times) == result.messages["touch"]


def test_a_full_disk_leaves_a_file_that_is_good_up_to_that_point(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "full.mcap"

    class FullDisk:
        """Has no more room from a length on, until room is made again."""

        def __init__(self) -> None:
            self.file = path.open("wb", buffering=0)
            self.room = 50_000

        def write(self, data: bytes) -> int:
            taken = min(len(data), self.room)
            self.file.write(data[:taken])
            self.room -= taken
            if taken < len(data):
                self.room = 10**9  # somebody makes room right afterwards
                raise OSError(28, "No space left on device")
            return taken

        def __enter__(self) -> "FullDisk":
            return self

        def __exit__(self, *_: object) -> None:
            pass

        def __getattr__(self, name: str) -> Any:
            return getattr(self.file, name)

    disk = FullDisk()
    monkeypatch.setattr(recording, "create_private", lambda _: disk)
    recorder = Recorder(tmp_path / "absent.mcap", SCHEMAS, {})
    for n in range(COUNT):
        recorder.write("touch", n, n.to_bytes(4, "little") * 25)
    recorder.close()
    disk.file.close()
    assert (recorder.failed, recorder.disk_full) == ("[Errno 28] No space left on device", True)
    assert 0 < recorder.lost <= COUNT
    result = recovered(path)
    times = [time_ns for _, time_ns, _ in held(result.out)]
    assert times == list(range(len(times)))
    assert 200 < len(times) < 50_000 / 100


def test_the_command_reports_what_was_restored(tmp_path: Path, whole: bytes) -> None:
    cut, out = tmp_path / "remote.mcap", tmp_path / "remote-recovered.mcap"
    cut.write_bytes(whole[: len(whole) // 2])
    outcome = command("recover", cut)
    assert outcome.code == 0
    *streams, last = outcome.err.splitlines()
    assert [line.split()[1] for line in streams] == ["event", "touch"]
    total = sum(int(line.split()[0]) for line in streams)
    assert f"remote-recovered.mcap: {total} messages over" in last
    assert "bytes and 0 damaged parts could not be read" in last
    assert "remote-recovered.mcap: exists; name another file with --out" in one_line(command("recover", cut), 2)
    assert command("recover", out).said == (0, "", f"{out} is whole: nothing needs repair\n")


@pytest.mark.parametrize(
    ("content", "words"),
    [(b"", "not an MCAP file"), (b"time_s,force_n\n", "not an MCAP file"), (None, "No such file")],
)
def test_a_file_that_is_no_recording_is_reported_in_one_line(tmp_path: Path, content: bytes | None, words: str) -> None:
    path = tmp_path / "x.mcap"
    if content is not None:
        path.write_bytes(content)
    assert words in one_line(command("recover", path), 2)
    assert list(tmp_path.glob("*-recovered.mcap")) == []


def test_an_empty_recovery_is_reported_and_leaves_no_file(tmp_path: Path, whole: bytes) -> None:
    cut = tmp_path / "s.mcap"
    cut.write_bytes(whole[:400])
    with pytest.raises(ValueError, match="not one message in it can be read"):
        recover(cut)
    assert [path.name for path in tmp_path.iterdir()] == ["s.mcap"]


def test_a_device_that_cannot_hold_a_recording_stays(tmp_path: Path, whole: bytes) -> None:
    cut = tmp_path / "s.mcap"
    cut.write_bytes(whole[:400])
    leader, follower = os.openpty()
    try:
        with pytest.raises(OSError, match="Illegal seek"):
            recover(cut, Path(os.ttyname(follower)))
    finally:
        os.close(leader)
        os.close(follower)


def test_an_interrupted_recovery_leaves_no_file(tmp_path: Path, whole: bytes, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupt(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    cut = tmp_path / "remote.mcap"
    cut.write_bytes(whole[: len(whole) // 2])
    monkeypatch.setattr("teletaction.recordings.recover.Writer.finish", interrupt)
    with pytest.raises(KeyboardInterrupt):
        recover(cut)
    assert [path.name for path in tmp_path.iterdir()] == ["remote.mcap"]


def test_until_it_is_whole_a_recovery_has_no_name(
    tmp_path: Path, whole: bytes, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A recovery that is killed leaves no cut file that looks like its result, and the next one can begin."""
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(whole[: len(whole) // 2])
    before = TruncatedMcap.records
    seen: list[bool] = []

    def records(self: TruncatedMcap) -> Iterator[McapRecord]:
        for record in before(self):
            seen.append((tmp_path / "cut-recovered.mcap").exists())
            yield record

    monkeypatch.setattr(TruncatedMcap, "records", records)
    assert recovered(cut).messages
    assert not any(seen)


def test_the_command_to_recover_a_cut_file_can_be_copied(tmp_path: Path, whole: bytes) -> None:
    cut = tmp_path / "Mrs. Müller's touch.mcap"
    cut.write_bytes(whole[: len(whole) // 2])
    line = one_line(command("export", cut, "--to", "csv", "--out", tmp_path / "csv"), 2)
    words = shlex.split(line.split("`")[1])
    assert words[1:] == ["recover", str(cut)]
    assert command(*words[1:]).code == 0


def test_a_pipe_is_named_and_refused(tmp_path: Path) -> None:
    ours, theirs = os.pipe()
    try:
        line = one_line(command("report", f"/dev/fd/{ours}", "--out", tmp_path / "r.html"), 2)
    finally:
        os.close(ours)
        os.close(theirs)
    assert line == f"teletaction: /dev/fd/{ours}: is a pipe; a recording is read from a file"
