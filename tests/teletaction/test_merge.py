"""What a merged recording keeps of each recording that went into it."""

from pathlib import Path

import msgpack
from mcap.reader import make_reader

from common.recording import Recorder
from common.software_version import software_version
from teletaction.merge import ORIGIN, merge_recordings


def record(path: Path, times_ns: range) -> Path:
    with Recorder(path, {"a": {"type": "integer"}}, {"key": path.stem}, {"table.json": path.stem.encode()}) as recorder:
        for time_ns in times_ns:
            recorder.write("a", time_ns, msgpack.packb(time_ns))
    return path


def test_configuration_and_tables_of_each_recording_are_kept_under_its_name(tmp_path: Path) -> None:
    paths = [record(tmp_path / f"{name}.mcap", range(10)) for name in ("remote-1", "remote")]
    cut = record(tmp_path / "operator.mcap", range(3000))
    cut.write_bytes(cut.read_bytes()[:60_000])
    merge_recordings([*paths, cut], tmp_path / "session.mcap")
    with (tmp_path / "session.mcap").open("rb") as file:
        reader = make_reader(file)
        metadata = {entry.name: entry.metadata for entry in reader.iter_metadata()}
        attached = {entry.name: entry.data for entry in reader.iter_attachments()}
    names = ("remote-1", "remote", "operator")
    assert metadata == {f"{name}/session": {"version": software_version(), "key": name} for name in names}
    assert attached == {f"{name}/table.json": name.encode() for name in names}


def test_each_message_tells_which_recording_it_came_from(tmp_path: Path) -> None:
    first = record(tmp_path / "remote-1.mcap", range(0, 100, 2))
    second = record(tmp_path / "remote.mcap", range(1, 100, 2))
    merge_recordings([first, second], tmp_path / "session.mcap")
    with (tmp_path / "session.mcap").open("rb") as file:
        found = [(m.log_time, channel.metadata[ORIGIN]) for _, channel, m in make_reader(file).iter_messages()]
    assert found == [(n, "remote" if n % 2 else "remote-1") for n in range(100)]
