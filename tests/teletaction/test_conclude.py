"""A session's recordings brought together, whole or cut by a killed process."""

from pathlib import Path

import msgpack
import pytest
from mcap.reader import make_reader

from common import recording_writer
from common.recording import Recorder
from teletaction.conclude import conclude, recordings_of
from teletaction.demo_files import DemoOptions
from teletaction.merge import merge_recordings
from tests.writer_thread import write_in_a_thread

COUNT = 3000


@pytest.fixture(autouse=True)
def _many_chunks(monkeypatch: pytest.MonkeyPatch) -> None:
    write_in_a_thread(monkeypatch)
    monkeypatch.setattr(recording_writer, "CHUNK_BYTES", 4096)


def record(path: Path, stream: str, times_ns: range) -> Path:
    with Recorder(path, {stream: {"type": "integer"}}, {"configuration": path.stem}) as recorder:
        for time_ns in times_ns:
            recorder.write(stream, time_ns, msgpack.packb(time_ns))
    return path


def times(path: Path) -> dict[str, list[int]]:
    found: dict[str, list[int]] = {}
    last = 0
    with path.open("rb") as file:
        for _, channel, message in make_reader(file).iter_messages():
            assert message.log_time >= last
            last = message.log_time
            assert msgpack.unpackb(message.data) == message.log_time
            found.setdefault(channel.topic, []).append(message.log_time)
    return found


def test_streams_of_all_processes_stand_in_one_order_of_time(tmp_path: Path) -> None:
    one = record(tmp_path / "one.mcap", "even", range(0, 2 * COUNT, 2))
    two = record(tmp_path / "two.mcap", "odd", range(1, 2 * COUNT, 2))
    assert merge_recordings([one, two], tmp_path / "all.mcap") == {"even": COUNT, "odd": COUNT}
    assert times(tmp_path / "all.mcap") == {"even": [*range(0, 2 * COUNT, 2)], "odd": [*range(1, 2 * COUNT, 2)]}


def test_a_recording_without_its_end_gives_what_it_has(tmp_path: Path) -> None:
    whole = record(tmp_path / "whole.mcap", "a", range(COUNT)).read_bytes()
    cut = tmp_path / "cut.mcap"
    cut.write_bytes(whole[: len(whole) // 2])
    after = record(tmp_path / "cut-1.mcap", "a", range(COUNT, 2 * COUNT))
    counts = merge_recordings([cut, after], tmp_path / "all.mcap")
    found = times(tmp_path / "all.mcap")["a"]
    assert len(found) == counts["a"]
    assert COUNT // 4 < len(found) - COUNT < COUNT
    assert found == [*range(len(found) - COUNT), *range(COUNT, 2 * COUNT)]


@pytest.mark.parametrize("length", [0, 5, 30])
def test_a_recording_that_hardly_began_gives_nothing(tmp_path: Path, length: int) -> None:
    whole = record(tmp_path / "whole.mcap", "a", range(3)).read_bytes()
    (tmp_path / "begun.mcap").write_bytes(whole[:length])
    assert merge_recordings([tmp_path / "begun.mcap"], tmp_path / "all.mcap") == {}


def test_a_restarted_process_has_several_recordings(tmp_path: Path) -> None:
    for name in ("remote.mcap", "remote-1.mcap", "remote-2.mcap", "sim-remote.mcap", "remote-x.mcap"):
        (tmp_path / name).touch()
    assert [p.name for p in recordings_of(tmp_path, "remote")] == ["remote-1.mcap", "remote-2.mcap", "remote.mcap"]


def test_a_scene_that_is_none_is_refused_before_anything_is_written(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="unknown scene 'nowhere'; known: "):
        conclude(tmp_path, tmp_path / "out", DemoOptions(scene="nowhere"))
    assert not (tmp_path / "out").exists()


def test_what_is_missing_is_named(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"no recording of sim-remote \(sim-remote\.mcap\)"):
        conclude(tmp_path, tmp_path / "out", DemoOptions())
    for process in ("sim-remote", "sim-operator", "remote", "operator"):
        (tmp_path / f"{process}.mcap").touch()
    with pytest.raises(ValueError, match=r"sim-remote\.json: missing"):
        conclude(tmp_path, tmp_path / "out", DemoOptions())
    (tmp_path / "sim-remote.json").write_text("{")
    with pytest.raises(ValueError, match=r"sim-remote\.json: not JSON"):
        conclude(tmp_path, tmp_path / "out", DemoOptions())
