"""A session's recordings brought together, whole or cut by a killed process."""

import shutil
from pathlib import Path

import msgpack
import pytest
from mcap.reader import make_reader

from common.recording import writer_process
from common.recording.recorder import Recorder
from common.version import software_version
from teletaction.recordings.merge import ORIGIN, merge_recordings
from teletaction.session.conclude import conclude, recordings_of
from teletaction.session.demo_files import PROCESSES, SITES
from tests.commands import command
from tests.unit.teletaction.held_recordings import held
from tests.writer_thread import write_in_a_thread

COUNT = 3000


@pytest.fixture(autouse=True)
def _many_chunks(monkeypatch: pytest.MonkeyPatch) -> None:
    write_in_a_thread(monkeypatch)
    monkeypatch.setattr(writer_process, "CHUNK_BYTES", 4096)


def record(path: Path, stream: str, times_ns: range) -> Path:
    """Each message holds its time; the recording's name is in its configuration and in its table."""
    tables = {"table.json": path.stem.encode()}
    with Recorder(path, {stream: {"type": "integer"}}, {"configuration": path.stem}, tables) as recorder:
        for time_ns in times_ns:
            recorder.write(stream, time_ns, msgpack.packb(time_ns))
    return path


@pytest.mark.long
def test_streams_of_all_processes_stand_in_one_order_of_time_with_the_recording_of_each(tmp_path: Path) -> None:
    sources = (("a", "remote-1"), ("a", "remote"), ("b", "operator"))
    paths = [
        record(tmp_path / f"{name}.mcap", stream, range(n, 3 * COUNT, 3)) for n, (stream, name) in enumerate(sources)
    ]
    assert merge_recordings(paths, tmp_path / "all.mcap") == {"a": 2 * COUNT, "b": COUNT}
    with (tmp_path / "all.mcap").open("rb") as file:
        found = [
            (channel.topic, channel.metadata[ORIGIN], message.log_time, msgpack.unpackb(message.data))
            for _, channel, message in make_reader(file).iter_messages(log_time_order=False)
        ]
    assert found == [(*sources[n % 3], n, n) for n in range(3 * COUNT)]


def test_a_recording_without_its_end_gives_what_it_has_and_each_its_configuration_and_tables(tmp_path: Path) -> None:
    cut = record(tmp_path / "remote-1.mcap", "a", range(COUNT))
    whole = cut.read_bytes()
    cut.write_bytes(whole[: len(whole) // 2])
    after = record(tmp_path / "remote.mcap", "a", range(COUNT, 2 * COUNT))
    counts = merge_recordings([cut, after], tmp_path / "all.mcap")
    found = [time_ns for _, time_ns, _ in held(tmp_path / "all.mcap")]
    assert len(found) == counts["a"]
    assert COUNT // 4 < len(found) - COUNT < COUNT
    assert found == [*range(len(found) - COUNT), *range(COUNT, 2 * COUNT)]
    with (tmp_path / "all.mcap").open("rb") as file:
        reader = make_reader(file)
        metadata = {entry.name: entry.metadata for entry in reader.iter_metadata()}
        attached = {entry.name: entry.data for entry in reader.iter_attachments()}
    names = ("remote-1", "remote")
    assert metadata.keys() == {f"{name}/session" for name in names}
    for name in names:
        assert metadata[f"{name}/session"].items() >= {"version": software_version(), "configuration": name}.items()
    assert attached == {f"{name}/table.json": name.encode() for name in names}


@pytest.mark.parametrize("length", [0, 5, 30])
def test_a_recording_without_a_whole_chunk_gives_nothing(tmp_path: Path, length: int) -> None:
    begun = record(tmp_path / "begun.mcap", "a", range(3))
    begun.write_bytes(begun.read_bytes()[:length])
    assert merge_recordings([begun], tmp_path / "all.mcap") == {}


def test_a_restarted_process_has_several_recordings(tmp_path: Path) -> None:
    for name in ("remote.mcap", "remote-1.mcap", "remote-2.mcap", "sim-remote.mcap", "remote-x.mcap"):
        (tmp_path / name).touch()
    assert [p.name for p in recordings_of(tmp_path, "remote")] == ["remote-1.mcap", "remote-2.mcap", "remote.mcap"]


def test_a_wrong_scene_or_a_missing_recording_is_named_before_anything_is_written(tmp_path: Path) -> None:
    def refuse(words: str, **options: str) -> None:
        with pytest.raises(ValueError, match=words):
            conclude(tmp_path, tmp_path / "out", options)
        assert not (tmp_path / "out").exists()

    refuse("unknown scene 'nowhere'; known: ", scene="nowhere")
    refuse(r"no recording of sim-remote \(sim-remote\.mcap\)")
    for process in PROCESSES:
        (tmp_path / f"{process}.mcap").touch()
    refuse(r"sim-remote\.json: missing")
    (tmp_path / "sim-remote.json").write_text("{")
    refuse(r"sim-remote\.json: not a status file")


def test_a_missing_folder_and_a_merged_session_are_named(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="absent: no such folder"):
        conclude(tmp_path / "absent", tmp_path / "out", {})
    (tmp_path / "session.mcap").touch()
    with pytest.raises(ValueError, match=r"session\.mcap is merged already: `teletaction report` makes its report"):
        conclude(tmp_path, tmp_path / "out", {})
    assert not (tmp_path / "out").exists()


@pytest.mark.long
def test_a_session_on_real_devices_gets_recording_and_report_but_no_summary(session: Path, tmp_path: Path) -> None:
    """Only simulators know the truth that a summary compares with."""
    for site in SITES:
        shutil.copy(session.with_name(f"{site}.mcap"), tmp_path)
    outcome = command("summarise", "--recordings", tmp_path, "--out", tmp_path / "out")
    assert (outcome.code, outcome.out) == (0, ""), outcome
    assert "no summary: it compares with simulated devices" in outcome.err
    assert {path.name for path in (tmp_path / "out").iterdir()} == {"session.mcap", "report.html"}
    assert {path.name for path in tmp_path.glob("*.mcap")} == {f"{site}.mcap" for site in SITES}
    streams = {stream for stream, *_ in held(tmp_path / "out" / "session.mcap")}
    assert {"operator/touch", "remote/touch"} <= streams
