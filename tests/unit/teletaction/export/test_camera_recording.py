"""A session whose console recorded camera and voice: merged, exported, reported, replayed and played."""

import csv
from pathlib import Path

import msgpack
import pytest

from common.recording.clock_anchor import boot_id
from common.recording.reader import RecordingReader
from common.recording.recorder import Recorder
from operator_site.console.camera.camera_picture import Picture
from operator_site.console.examination.journal import SCHEMAS
from operator_site.console.playback.playback import CAMERA, Recording
from operator_site.console.playback.played_media import PlayedPictures
from operator_site.console.voice.voice_sound import VoiceSound
from teletaction.export.export import export
from teletaction.recordings.merge import merge_recordings
from tests.commands import command
from tests.vp8_stream import HEIGHT, HZ, WIDTH, pictures

pytestmark = pytest.mark.long


@pytest.fixture(scope="module")
def recorded(session: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The session of the test bed with the test stream beside it."""
    folder = tmp_path_factory.mktemp("camera")
    with session.open("rb") as file:
        start_ns = RecordingReader(session, file).start_ns
    with Recorder(folder / "console.mcap", SCHEMAS, {"boot": boot_id()}) as recorder:
        for number, coded in enumerate(pictures()):
            time_ns = start_ns + (number + 1) * 1_000_000_000 // HZ
            made = Picture(number, time_ns * 1e-9 - 0.05, 0.001, coded.is_key, WIDTH, HEIGHT, coded.content)
            recorder.write("console/camera", time_ns, msgpack.packb(made.record()))
            sound = VoiceSound("to_remote", number, time_ns * 1e-9 - 0.05, 0.001, b"opus")
            recorder.write("console/voice", time_ns, msgpack.packb(sound.record()))
    sources = [path for path in sorted(session.parent.glob("*.mcap")) if path != session]
    counts = merge_recordings([*sources, folder / "console.mcap"], folder / "session.mcap")
    assert counts["console/camera"] == counts["console/voice"] == len(pictures())
    return folder / "session.mcap"


def test_an_export_has_everything_but_the_pictures_bytes(recorded: Path, tmp_path: Path) -> None:
    rows = export(recorded, "csv", tmp_path)
    assert rows["console-camera"] == len(pictures())
    with (tmp_path / "console-camera.csv").open(encoding="utf-8", newline="") as file:
        table = list(csv.DictReader(file))
    assert [int(row["content"]) for row in table] == [len(coded.content) for coded in pictures()]
    assert {row["width"] for row in table} == {str(WIDTH)}
    with (tmp_path / "console-voice.csv").open(encoding="utf-8", newline="") as file:
        sounds = list(csv.DictReader(file))
    assert len(sounds) == rows["console-voice"] == len(pictures())
    assert {(row["direction"], row["content"]) for row in sounds} == {("to_remote", "4")}
    assert export(recorded, "foxglove", tmp_path / "foxglove")


def test_report_and_replay_take_it(recorded: Path, tmp_path: Path, coarse: None) -> None:
    for arguments in (["report", recorded, "--out", tmp_path / "report.html"], ["replay", recorded, "--out", tmp_path]):
        done = command(*arguments)
        assert done.code == 0, done.err


def test_playback_has_the_pictures(recorded: Path) -> None:
    recording = Recording(recorded)
    played = PlayedPictures(recording)
    assert recording.has(CAMERA)
    last = played.jump(recording.end_ns)
    assert [picture.content for picture in last] == [coded.content for coded in pictures()[HZ:]]
    recording.close()
